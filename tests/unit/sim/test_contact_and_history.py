"""Two helpers that save work must not change the answer."""

import math

import numpy as np
import pytest

from target_nav.sim.arena import load_arena
from target_nav.sim.contact import ContactMonitor
from target_nav.sim.history import PoseHistory
from target_nav.sim.world import World


def test_the_lazy_monitor_finds_the_same_least_clearance_as_asking_each_time():
    arena = load_arena("cluttered_room")
    world, rng = World(arena), np.random.default_rng(2)
    x, y, yaw = arena.robot.x_m, arena.robot.y_m, arena.robot.yaw_rad
    monitor = ContactMonitor(world, x, y, yaw)
    reach, least = arena.config.robot.circumscribed_radius_m, world.clearance_m(x, y, yaw)
    touched = 0
    heading = 0.3
    for _ in range(6000):
        heading += float(rng.normal(0.0, 0.1))
        step, turn = 0.004, float(rng.normal(0.0, 0.01))
        nx, ny, nyaw = x + step * math.cos(heading), y + step * math.sin(heading), yaw + turn
        clearance = world.clearance_m(nx, ny, nyaw)
        admitted = monitor.admits(nx, ny, nyaw, step + abs(turn) * reach)
        assert admitted == (clearance > 0.0)
        if admitted:
            x, y, yaw = nx, ny, nyaw
            least = min(least, clearance)
        else:
            touched, least, heading = touched + 1, 0.0, heading + 2.0
        assert monitor.min_clearance_m == pytest.approx(least, abs=1e-12)
    assert monitor.collided == (touched > 0)
    assert touched > 3  # or this walk has shown nothing


def test_history_gives_poses_between_steps_also_after_it_forgot_old_ones():
    history = PoseHistory(100.0, 0.01, 0.0, 0.0, 0.0)
    for step in range(1, 3001):
        t = step * 0.01
        history.append(0.3 * t, -0.1 * t, 0.5 * t)
    moments = np.array([127.5, 128.0, 128.123, 129.9999, 130.0])
    x, y, yaw = history.at_many(moments)
    since = moments - 100.0
    assert np.allclose(x, 0.3 * since)
    assert np.allclose(y, -0.1 * since)
    assert np.allclose(yaw, 0.5 * since)
    for i, moment in enumerate(moments.tolist()):
        assert history.at(moment) == pytest.approx((x[i], y[i], yaw[i]))


def test_outside_of_what_is_kept_history_gives_its_ends():
    history = PoseHistory(0.0, 0.01, 1.0, 2.0, 3.0)
    assert history.at(-1.0) == history.at(5.0) == (1.0, 2.0, 3.0)
    history.append(1.1, 2.0, 3.0)
    assert history.at(-1.0) == (1.0, 2.0, 3.0)
    assert history.at(5.0) == (1.1, 2.0, 3.0)
