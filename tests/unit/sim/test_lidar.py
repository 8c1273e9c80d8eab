"""The LiDAR's errors are those of the table; its scans are skewed as those of a rotating head are."""

import math
from dataclasses import replace

import numpy as np
import pytest

from target_nav.config import LidarConfig
from target_nav.sim.arena import Arena, Bounds, PlacedObject
from target_nav.sim.history import PoseHistory
from target_nav.sim.lidar import Lidar
from target_nav.sim.world import RayCaster, World
from target_nav.state.types import Pose2D, Scan

STEP_S = 0.01
A1 = LidarConfig(lost_scan_probability=0.0)
PERFECT = replace(A1, noise_scale=0.0, dropout_scale=0.0)


def round_room(radius_m: float, sides: int = 180) -> RayCaster:
    """A room whose wall is `radius_m` away in every direction."""
    angle = np.linspace(0.0, 2.0 * math.pi, sides + 1)
    x, y = radius_m * np.cos(angle), radius_m * np.sin(angle)
    return RayCaster(np.column_stack([x[:-1], y[:-1], x[1:], y[1:]]), np.empty((0, 3)))


def scans_of(
    config: LidarConfig,
    caster: RayCaster,
    turns: int,
    *,
    yaw_rate: float = 0.0,
    speed: float = 0.0,
    seed: int = 1,
) -> list[Scan]:
    lidar = Lidar(config, caster, np.random.default_rng(seed), start_s=10.0)
    history = PoseHistory(10.0, STEP_S, 0.0, 0.0, 0.0)
    scans: list[Scan] = []
    step = 0
    while len(scans) < turns and step < 400_000:
        step += 1
        t = step * STEP_S
        history.append(speed * t, 0.0, yaw_rate * t)
        scans += lidar.advance(10.0 + t, history)
    return scans


@pytest.mark.parametrize(
    ("range_m", "sigma_m", "dropout"),
    [
        (0.3, 0.0013, (0.13, 0.19)),
        (0.8, 0.0025, (0.13, 0.19)),
        (1.25, 0.0045, (0.13, 0.19)),
        (2.0, 0.0065, (0.13, 0.19)),
        (3.0, 0.013, (0.20, 0.27)),
        (4.0, 0.020, (0.28, 0.32)),
        (5.5, 0.031, (0.42, 0.46)),
    ],
)
def test_noise_and_dropouts_are_the_measured_ones(range_m, sigma_m, dropout):
    ranges = np.concatenate([scan.ranges_m for scan in scans_of(A1, round_room(range_m), 60)])
    back = ranges[np.isfinite(ranges)]
    assert dropout[0] - 0.01 <= 1.0 - len(back) / len(ranges) <= dropout[1] + 0.01
    # Each beam's sigma is the median times exp(spread * normal), so ln|error| has the mean ln(sigma) + E ln|normal|.
    # The steps of 2 mm take it from small errors; there the interquartile range of the mixture is held instead.
    error = back - range_m * math.cos(math.pi / 360)
    assert abs(np.median(error)) < 0.002
    mixture = np.random.default_rng(0).standard_normal((2, 200_000))
    expected = sigma_m * np.exp(math.log(3.0) / 1.2816 * mixture[0]) * mixture[1]
    expected = np.rint(expected / 0.002) * 0.002
    wide = np.percentile(np.abs(expected), 90)
    assert np.percentile(np.abs(error), 90) == pytest.approx(wide, rel=0.15, abs=0.0015)


def test_ranges_come_in_steps_of_two_millimetres():
    (scan,) = scans_of(A1, round_room(2.0), 1)
    steps = scan.ranges_m[np.isfinite(scan.ranges_m)] / 0.002
    assert np.allclose(steps, np.rint(steps), atol=1e-6)


@pytest.mark.parametrize(("range_m", "seen"), [(0.12, False), (0.17, True), (11.8, True), (12.4, False)])
def test_nothing_comes_back_from_the_blind_zone_and_from_beyond(range_m, seen):
    (scan,) = scans_of(PERFECT, round_room(range_m), 1)
    assert np.all(np.isfinite(scan.ranges_m) == seen)


@pytest.mark.parametrize(("distance_m", "beams"), [(1.0, 4.6), (2.0, 2.3), (3.0, 1.5)])
def test_a_pin_is_met_by_as_many_beams_as_measured_before_dropouts(distance_m, beams):
    target = PlacedObject("bowling_pin", distance_m, 0.0)
    arena = Arena("pin", Bounds(-4, -4, 4, 4), Pose2D(), target=target)
    scans = scans_of(replace(A1, dropout_scale=0.0), World(arena).ray_caster(0.18), 150)
    hits = [np.count_nonzero(np.abs(scan.ranges_m - distance_m) < 0.35) for scan in scans]
    assert np.mean(hits) == pytest.approx(beams, rel=0.05)
    assert len(set(hits)) > 1  # one beam more or less from turn to turn


def test_scans_have_the_direction_times_and_shape_of_the_message():
    (scan,) = scans_of(A1, round_room(2.0), 1)
    assert scan.ranges_m.shape == (360,)
    assert scan.angle_min_rad == pytest.approx(-math.pi)
    assert scan.angle_increment_rad == pytest.approx(math.radians(1.0))
    assert scan.time_increment_s * 360 == pytest.approx(1.0 / 5.5, rel=0.07)
    assert 10.0 <= scan.stamp_s < 10.0 + 1.0 / 5.5


def test_turns_take_182_ms_with_the_measured_spread():
    stamps = np.array([scan.stamp_s for scan in scans_of(A1, round_room(2.0, sides=12), 400)])
    periods_ms = np.diff(stamps) * 1000.0
    assert np.percentile(periods_ms, [5, 50, 95]) == pytest.approx([178, 182, 188], abs=2.5)


def test_a_scan_is_delivered_when_its_turn_is_complete_and_not_before():
    lidar = Lidar(PERFECT, round_room(2.0), np.random.default_rng(3), start_s=0.0)
    history = PoseHistory(0.0, STEP_S, 0.0, 0.0, 0.0)
    due_s = lidar.due_s
    assert lidar.advance(due_s - 1e-6, history) == []
    (scan,) = lidar.advance(due_s, history)
    assert scan.stamp_s + 360 * scan.time_increment_s == pytest.approx(due_s)


def test_at_half_a_radian_a_second_one_scan_is_skewed_by_5_degrees():
    """Seen from the turning robot, a pin that is met by the first beams stands elsewhere when met by the last."""
    pin = RayCaster(np.empty((0, 4)), np.array([[2.0, 0.0, 0.2]]))
    config = replace(PERFECT, beams=3600)
    first_scan, second_scan = scans_of(config, pin, 2, yaw_rate=0.5)
    for scan in (first_scan, second_scan):
        met = np.flatnonzero(np.isfinite(scan.ranges_m))
        middle = met[len(met) // 2]
        bearing = scan.angle_min_rad + middle * scan.angle_increment_rad
        taken_s = scan.stamp_s + middle * scan.time_increment_s
        assert bearing == pytest.approx(-0.5 * (taken_s - 10.0), abs=0.01)
    whole_turn_s = 3600 * first_scan.time_increment_s
    assert math.degrees(0.5 * whole_turn_s) == pytest.approx(5.2, abs=0.4)


def test_beams_start_from_where_the_robot_was():
    (scan,) = scans_of(PERFECT, round_room(5.0), 1, speed=1.0)
    ahead = 180
    taken_s = scan.stamp_s + ahead * scan.time_increment_s
    assert scan.ranges_m[ahead] == pytest.approx(5.0 - (taken_s - 10.0), abs=0.003)


def test_another_lidar_by_configuration():
    config = replace(PERFECT, rate_hz=40.0, beams=720, fov_rad=math.radians(270.0))
    scans = scans_of(config, round_room(2.0), 40)
    assert scans[0].ranges_m.shape == (720,)
    assert scans[0].angle_min_rad == pytest.approx(math.radians(-135.0))
    assert scans[0].angle_min_rad + 719 * scans[0].angle_increment_rad == pytest.approx(math.radians(135.0))
    assert np.mean(np.diff([scan.stamp_s for scan in scans])) == pytest.approx(0.025, rel=0.02)
    assert 720 * scans[0].time_increment_s == pytest.approx(0.025 * 270 / 360, rel=0.07)


def test_the_laser_may_sit_anywhere_on_the_robot():
    walls = World(Arena("room", Bounds(-3, -3, 3, 3), Pose2D())).ray_caster(0.18)
    (scan,) = scans_of(replace(PERFECT, x_m=0.5, yaw_rad=math.pi / 2), walls, 1)
    assert scan.ranges_m[[90, 180, 270]] == pytest.approx([2.5, 3.0, 3.5], abs=0.002)


def test_lost_turns_leave_gaps_of_up_to_0_7_seconds():
    config = replace(A1, lost_scan_probability=0.05)
    gaps = np.diff([scan.stamp_s for scan in scans_of(config, round_room(2.0, sides=12), 1500)])
    turns = np.rint(gaps * 5.5).astype(int) - 1
    assert set(turns) == {0, 1, 2, 3}
    assert np.count_nonzero(turns) / len(turns) == pytest.approx(0.05, abs=0.015)
    assert np.max(gaps) < 0.78


def test_without_noise_ranges_are_the_geometry():
    (scan,) = scans_of(PERFECT, round_room(2.0), 1)
    assert np.all(np.abs(scan.ranges_m - 2.0) < 0.002)
