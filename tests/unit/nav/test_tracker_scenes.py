"""The tracker in scripted worlds: what stands near the pin, what the LiDAR may do, and laws."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Sequence

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from target_nav.nav.poses import PoseHistory
from target_nav.nav.tracker import TargetTracker
from target_nav.state.types import Pose2D, Twist2D
from tests.unit.nav.scripted_world import (
    SPEC,
    Drive,
    Sensors,
    World,
    box,
    error_m,
    mirrored_frame,
    mirrored_odometry,
    mirrored_scan,
)
from tests.unit.nav.tracker_feed import AHEAD, CAMERA_X_M, CONFIG, ROOM, Feed, pin_at, relative_error_m


def test_the_lidar_alone_makes_no_track() -> None:
    feed, world = Feed(), World(pins=[(1.0, 0.0)])
    assert all(feed.step(world=world) is None for _ in range(20))


def test_last_seen_is_the_cameras_and_last_ranged_the_lidars() -> None:
    feed, world = Feed(), World(pins=[(2.0, 0.0)])
    seen = feed.steps(4, pin_at(2.0))
    assert seen is not None
    assert seen.last_ranged_s == -math.inf
    last_frame_s = feed.now_s - 0.1
    for _ in range(10):
        track = feed.step(world=world)
    assert track is not None
    assert track.last_seen_s == pytest.approx(last_frame_s)
    assert track.last_ranged_s == pytest.approx(feed.now_s, abs=0.25)


@pytest.mark.parametrize(
    ("scale", "yaw"), [(0.044, 0.014), (-0.044, 0.014), (0.044, -0.014), (-0.044, -0.014)]
)
def test_a_camera_that_is_always_wrong_by_as_much_as_was_measured_is_put_right_by_the_lidar(
    scale: float, yaw: float
) -> None:
    pin = (2.2, 0.2)
    sensors = Sensors(seed=1, scale_error=scale, yaw_error_rad=yaw)
    track = World(pins=[pin], walls=ROOM, sensors=sensors).track_after(3.0)
    assert error_m(track, pin) < 0.03


def test_without_lidar_it_knows_how_uncertain_such_a_camera_leaves_it() -> None:
    pin = (2.2, 0.2)
    world = World(pins=[pin], sensors=Sensors(seed=1, scale_error=0.044, yaw_error_rad=0.014, dropouts=99.0))
    track = world.track_after(4.0)
    assert track is not None
    assert error_m(track, pin) > 0.05
    assert error_m(track, pin) < 2.5 * track.sigma_m


NEAR_THINGS: dict[str, World] = {
    "wall 30 cm behind": World(walls=[*ROOM, (2.5, -2.0, 2.5, 2.0)]),
    "wall 12 cm behind": World(walls=[*ROOM, (2.32, -2.0, 2.32, 2.0)]),
    "wall it touches behind": World(walls=[*ROOM, (2.24, -2.0, 2.24, 2.0)]),
    "wall 10 cm beside": World(walls=[*ROOM, (0.0, 0.3, 4.0, 0.3)]),
    "box 10 cm beside": World(walls=[*ROOM, *box(2.2, 0.44, 0.2, 0.2)]),
    "box it touches beside": World(walls=[*ROOM, *box(2.2, 0.345, 0.2, 0.2)]),
    "box in front and beside": World(walls=[*ROOM, *box(1.8, 0.42, 0.2, 0.3)]),
    "low box in front": World(walls=ROOM, low_walls=box(1.6, 0.15, 0.3, 0.5)),
    "low post in front": World(walls=ROOM, low_walls=box(2.05, 0.18, 0.06, 0.08)),
    "chair leg beside": World(walls=ROOM, circles=[(2.2, 0.35, 0.02)]),
    "chair leg in front and beside": World(walls=ROOM, circles=[(2.05, 0.3, 0.03)]),
    "chair legs on both sides": World(walls=ROOM, circles=[(2.3, 0.3, 0.03), (2.1, 0.08, 0.03)]),
}


@pytest.mark.parametrize("name", NEAR_THINGS)
def test_what_stands_near_the_pin_does_not_lend_its_range(name: str) -> None:
    """Error 3 sigma of what a camera alone leaves at that range at most, for a camera with its own errors."""
    pin, bad = (2.2, 0.2), 0
    for seed in range(3):
        rng = np.random.default_rng(seed)
        sensors = Sensors(seed=seed, scale_error=0.02 * rng.normal(), yaw_error_rad=0.006 * rng.normal())
        world = dataclasses.replace(NEAR_THINGS[name], pins=[pin], sensors=sensors, drive=AHEAD)
        tracks = [(tick.robot, tick.track) for tick in world.run(TargetTracker(CONFIG), 8.0)]
        robot, track = tracks[-1]
        assert track is not None
        assert track.confirmed
        camera_m = math.hypot(pin[0] - robot.x_m - CAMERA_X_M, pin[1])
        bad += error_m(track, pin) > 3.0 * camera_m * CONFIG.track.camera_scale_sigma
    assert bad == 0


def test_a_low_box_never_pulls_the_track_to_itself_at_any_time() -> None:
    """The original's weakness: any finite range at the pin's bearing was believed."""
    pin = (2.2, 0.0)
    world = World(
        pins=[pin], low_walls=box(1.4, 0.0, 0.2, 0.3), walls=ROOM, sensors=Sensors(seed=2), drive=AHEAD
    )
    for tick in world.run(TargetTracker(CONFIG), 4.0):
        if tick.track is not None and tick.track.confirmed:
            assert error_m(tick.track, pin) < 0.3
            assert tick.track.last_ranged_s == -math.inf


@pytest.mark.parametrize("dropouts", [1.0, 2.0, 3.0])
def test_drop_outs_make_it_slower_not_wrong(dropouts: float) -> None:
    pin = (1.6, -0.2)
    world = World(pins=[pin], walls=ROOM, drive=AHEAD, sensors=Sensors(seed=7, dropouts=dropouts))
    track = world.track_after(5.0)
    assert error_m(track, pin) < 0.03


@settings(max_examples=10, deadline=None)
@given(
    st.tuples(st.floats(0.8, 3.0), st.floats(-0.8, 0.8)),
    st.tuples(st.floats(0.8, 3.0), st.floats(-0.8, 0.8)),
    st.floats(-0.1, 0.1),
    st.floats(-0.3, 0.3),
    st.integers(0, 1000),
)
def test_a_mirrored_world_makes_a_mirrored_track(
    pin: tuple[float, float], leg: tuple[float, float], vy: float, wz: float, seed: int
) -> None:
    drive = Drive(Pose2D(), ((1.0, Twist2D(0.1, vy, wz)),))
    world = World(pins=[pin], circles=[(*leg, 0.03)], walls=ROOM, drive=drive, sensors=Sensors(seed=seed))
    mirrored, poses = TargetTracker(CONFIG), PoseHistory()
    for index in range(20):
        poses.add(mirrored_odometry(world.odometry(9.05 + 0.05 * index)))
    for tick in world.run(TargetTracker(CONFIG), 2.0):
        poses.add(mirrored_odometry(world.odometry(tick.now_s)))
        frame = None if tick.frame is None else mirrored_frame(tick.frame, CONFIG)
        scan = None if tick.scan is None else mirrored_scan(tick.scan)
        track, other = tick.track, mirrored.update(tick.now_s, poses, SPEC, frame, scan)
        assert (track is None) == (other is None)
        if track is not None and other is not None:
            assert (track.x_m, track.y_m, track.bearing_rad) == pytest.approx(
                (other.x_m, -other.y_m, -other.bearing_rad), abs=1e-6
            )
            assert (track.confirmed, track.hits, track.last_seen_s) == (
                other.confirmed,
                other.hits,
                other.last_seen_s,
            )
            assert (track.range_m, track.last_ranged_s) == pytest.approx(
                (other.range_m, other.last_ranged_s), abs=1e-6
            )


def monte_carlo(
    lidar: bool, legs: Sequence[tuple[float, float]], runs: int
) -> tuple[list[float], list[float]]:
    """Normalised squared errors, and errors at the end, of noisy drives past and towards a pin. Odometry drifts.

    `legs` are where posts of 6 cm stand, relative to the pin.
    """
    squares, finals = [], []
    for seed in range(runs):
        rng = np.random.default_rng(1000 + seed)
        pin = (2.2 + rng.uniform(-0.4, 0.8), rng.uniform(-0.3, 0.3))
        sensors = Sensors(
            seed=seed,
            scale_error=CONFIG.track.camera_scale_sigma * rng.normal(),
            yaw_error_rad=CONFIG.track.camera_yaw_sigma_rad * rng.normal(),
            dropouts=1.0 if lidar else 99.0,
        )
        wz = rng.uniform(-0.1, 0.1)
        drive = Drive(Pose2D(), ((3.0, Twist2D(0.1, 0.1, wz)), (3.0, Twist2D(0.15, -0.1, -wz))))
        believed = drive.as_odometry_sees_it(
            1 + rng.uniform(-0.02, 0.02), 1 + rng.uniform(0.05, 0.1), rng.normal() * 0.008
        )
        posts = [(pin[0] + dx, pin[1] + dy, 0.03) for dx, dy in legs]
        world = World(pins=[pin], circles=posts, walls=ROOM, drive=drive, believed=believed, sensors=sensors)
        error = math.inf
        for index, tick in enumerate(world.run(TargetTracker(CONFIG), 6.0)):
            error = relative_error_m(world, tick, pin)
            if index % 20 == 19 and tick.track is not None and tick.track.confirmed:
                true = world.in_odom(pin, tick.now_s)
                off = np.array([tick.track.x_m - true[0], tick.track.y_m - true[1]])
                squares.append(
                    float(off @ np.linalg.solve(np.reshape(tick.track.covariance_m2, (2, 2)), off))
                )
        finals.append(error)
    return squares, finals


@pytest.mark.parametrize(
    ("lidar", "legs"),
    [(True, []), (False, []), (True, [(-0.15, 0.1)]), (True, [(0.1, 0.1), (-0.1, -0.12)])],
    ids=["open floor", "camera alone", "a chair leg in front", "chair legs on both sides"],
)
def test_it_knows_how_wrong_it_is(lidar: bool, legs: Sequence[tuple[float, float]]) -> None:
    """NEES of a position in the plane is 2 on average for an exact filter; less is careful, more is over-confident."""
    squares, finals = monte_carlo(lidar, legs, runs=12)
    assert len(squares) > 55
    assert 0.2 < np.mean(squares) < 3.5
    assert np.mean(np.array(squares) > 13.8) < 0.05
    assert np.quantile(finals, 0.95) < (0.15 if legs or not lidar else 0.03)
