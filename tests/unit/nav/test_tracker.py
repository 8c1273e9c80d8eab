"""The tracker: what makes a track, which frames and scans count, and what bad input does."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Callable, Sequence

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from target_nav.nav.poses import PoseHistory
from target_nav.nav.tracker import TargetTracker
from target_nav.state.types import DetectionFrame, Odometry, Pose2D, TargetSpec, Twist2D
from tests.unit.nav.scripted_world import (
    SPEC,
    Drive,
    Sensors,
    World,
    error_m,
)
from tests.unit.nav.tracker_feed import AHEAD, CONFIG, ROOM, Feed, pin_at


@settings(max_examples=25, deadline=None)
@given(st.floats(0.7, 3.5), st.floats(-0.4, 0.4))
def test_with_perfect_sensors_the_track_is_on_the_pin(range_m: float, bearing: float) -> None:
    pin = (range_m * math.cos(bearing), range_m * math.sin(bearing))
    track = World(pins=[pin], walls=ROOM).track_after(1.5)
    assert track is not None
    assert track.confirmed
    # Half a beam aside: the robot stands, so the same beams meet the pin each time.
    assert error_m(track, pin) < 0.01 + 0.5 * math.radians(1.0) * range_m
    assert track.range_m == pytest.approx(range_m, abs=0.015)
    assert track.bearing_rad == pytest.approx(bearing, abs=0.012)


def test_a_track_is_confirmed_by_the_fourth_frame_and_not_before() -> None:
    feed = Feed()
    confirmed = []
    for _ in range(5):
        track = feed.step(pin_at(2.0))
        assert track is not None
        confirmed.append((track.hits, track.confirmed))
    assert confirmed == [(1, False), (2, False), (3, False), (4, True), (5, True)]


def test_a_detection_the_camera_process_does_not_yet_stand_behind_confirms_nothing() -> None:
    track = Feed().steps(10, pin_at(2.0, confirmed=False))
    assert track is not None
    assert not track.confirmed


def test_the_same_frame_and_scan_again_and_again_count_once() -> None:
    feed, world = Feed(), World(pins=[(2.0, 0.0)])
    feed.step(pin_at(2.0), world=world)
    once = feed.step(pin_at(2.0), world=world)
    frame, scan = feed.frame(pin_at(2.0)), world.scan(feed.now_s - 0.2)
    tracks = [feed.tracker.update(feed.now_s, feed.poses, SPEC, frame, scan) for _ in range(5)]
    assert [track and track.hits for track in tracks] == [once and once.hits] * 5
    assert len({track and track.covariance_m2 for track in tracks}) == 1


def test_it_says_where_the_target_is_from_where_the_robot_is_now() -> None:
    tick = World(pins=[(2.0, 0.3)], walls=ROOM, drive=AHEAD).last_tick(6.0)
    assert tick.track is not None
    assert tick.track.stamp_s == tick.now_s
    dx, dy = 2.0 - tick.robot.x_m, 0.3 - tick.robot.y_m
    assert tick.track.range_m == pytest.approx(math.hypot(dx, dy), abs=0.01)
    assert tick.track.bearing_rad == pytest.approx(math.atan2(dy, dx), abs=0.01)


def test_the_camera_may_sit_anywhere_and_look_anywhere() -> None:
    config = CONFIG.override({"camera.x_m": -0.1, "camera.y_m": 0.2, "camera.yaw_rad": 2.0})
    pin = (-1.0, 1.2)
    track = World(pins=[pin], walls=ROOM, config=config).track_after(1.5)
    assert error_m(track, pin) < 0.02


def test_frames_of_false_boxes_confirm_nothing() -> None:
    rng, feed = np.random.default_rng(0), Feed()
    for _ in range(200):
        boxes = [
            pin_at(rng.uniform(0.6, 4.0), rng.uniform(-0.3, 0.3)) for _ in range(int(rng.random() < 0.1))
        ]
        track = feed.step(*boxes)
        assert track is None or not track.confirmed


def test_a_picture_full_of_boxes_is_not_too_many() -> None:
    rng, feed = np.random.default_rng(1), Feed()
    for _ in range(10):
        crowd = [pin_at(rng.uniform(0.6, 4.0), rng.uniform(-0.3, 0.3), score=0.6) for _ in range(63)]
        track = feed.step(pin_at(0.8), *crowd)
    assert error_m(track, (0.8, 0.0)) < 0.15


def test_things_of_another_class_are_not_looked_at() -> None:
    world = World(decoys=[("bottle", 1.0, 0.0)], walls=ROOM)
    assert world.track_after(2.0) is None
    both = World(pins=[(2.5, 0.4)], decoys=[("bottle", 1.2, -0.1)], walls=ROOM, sensors=Sensors(seed=3))
    assert error_m(both.track_after(3.0), (2.5, 0.4)) < 0.05


def errors_while_turning(restamp: Callable[[DetectionFrame, float], DetectionFrame]) -> list[float]:
    """Camera only, 0.5 rad/s to and fro, frames 100 ms late; the error of every tick after the first second."""
    legs = tuple((1.5, Twist2D(0.0, 0.0, rate)) for rate in (0.25, -0.5, 0.5, -0.5))
    pin, world = (2.0, 0.0), World(pins=[(2.0, 0.0)], drive=Drive(Pose2D(0.0, 0.0, -0.1), legs))
    tracker, errors = TargetTracker(CONFIG), []
    last: DetectionFrame | None = None
    restamped: DetectionFrame | None = None
    for tick in world.run(TargetTracker(CONFIG), 6.0):
        if tick.frame is not None and tick.frame is not last:
            last, restamped = tick.frame, restamp(tick.frame, tick.now_s)
        track = tracker.update(tick.now_s, tick.poses, SPEC, restamped, None)
        if tick.now_s > 11.0:
            errors.append(error_m(track, pin))
    return errors


def test_late_frames_are_placed_with_the_pose_of_their_own_stamp() -> None:
    assert max(errors_while_turning(lambda frame, now_s: frame)) < 0.01


def test_and_would_be_far_off_with_the_pose_of_their_arrival() -> None:
    """Keeps the test above honest: the world it uses tells the two apart."""
    arrived = errors_while_turning(lambda frame, now_s: dataclasses.replace(frame, stamp_s=now_s))
    assert max(arrived) > 0.05


def test_a_frame_that_comes_before_its_odometry_is_taken_when_that_comes() -> None:
    feed = Feed()
    frame = DetectionFrame(feed.now_s + 0.2, 0, (pin_at(2.0),))
    assert feed.tracker.update(feed.now_s + 0.25, feed.poses, SPEC, frame, None) is None
    for index in range(1, 6):
        feed.poses.add(feed.world.odometry(feed.now_s + 0.05 * index))
    assert feed.tracker.update(feed.now_s + 0.25, feed.poses, SPEC, frame, None) is not None


@pytest.mark.parametrize("stamp_s", [math.nan, math.inf, -math.inf, -5.0, 1e9])
def test_a_frame_or_scan_with_a_wrong_stamp_is_ignored_and_stops_nothing(stamp_s: float) -> None:
    feed, world = Feed(), World(pins=[(2.0, 0.0)])
    for _ in range(3):
        feed.step(pin_at(2.0), world=world)
        feed.tracker.update(
            feed.now_s,
            feed.poses,
            SPEC,
            dataclasses.replace(feed.frame(pin_at(1.0)), stamp_s=stamp_s),
            dataclasses.replace(world.scan(feed.now_s - 0.2), stamp_s=stamp_s),
        )
    track = feed.step(pin_at(2.0), world=world)
    assert track is not None
    assert track.confirmed
    assert error_m(track, (2.0, 0.0)) < 0.02
    assert feed.tracker.rejected["stamp"] + feed.tracker.rejected["unplaced"] == 6


def test_an_older_frame_after_a_newer_one_is_ignored() -> None:
    feed = Feed()
    feed.steps(3, pin_at(2.0))
    old = DetectionFrame(feed.now_s - 0.5, 0, (pin_at(2.0),))
    track = feed.tracker.update(feed.now_s, feed.poses, SPEC, old, None)
    assert track is not None
    assert track.hits == 3


def test_another_target_starts_it_over() -> None:
    feed = Feed()
    feed.steps(6, pin_at(2.0))
    assert feed.step(pin_at(2.0), spec=TargetSpec("cone", 0.3, 0.2)) is None


def test_a_jump_of_odometry_starts_it_over() -> None:
    feed = Feed()
    feed.steps(6, pin_at(2.0))
    feed.now_s += 0.05
    feed.poses.add(Odometry(feed.now_s, Pose2D(1.0, 1.0, 1.0), Twist2D()))
    assert feed.tracker.update(feed.now_s, feed.poses, SPEC, None, None) is None


def test_reset_forgets() -> None:
    feed = Feed()
    feed.steps(6, pin_at(2.0))
    feed.tracker.reset()
    assert feed.wait(0.05) is None


def test_without_odometry_there_is_no_track() -> None:
    tracker, frame = TargetTracker(CONFIG), DetectionFrame(9.9, 0, (pin_at(2.0),))
    assert tracker.update(10.0, PoseHistory(), SPEC, frame, None) is None


BAD: Sequence[tuple[str, dict[str, object]]] = [
    ("non_finite", {"range_m": math.nan}),
    ("non_finite", {"range_m": math.inf}),
    ("non_finite", {"bearing_rad": math.nan}),
    ("non_finite", {"range_sigma_m": math.nan}),
    ("non_finite", {"bearing_sigma_rad": math.inf}),
    ("non_finite", {"height_px": math.nan}),
    ("negative", {"range_m": -1.0}),
    ("negative", {"range_m": 0.0}),
    ("negative", {"range_sigma_m": -0.1}),
    ("negative", {"bearing_sigma_rad": -0.1}),
    ("negative", {"height_px": 0.0}),
    ("too_far", {"range_m": 20.0}),
    ("size", {"height_px": 20.0}),
    ("size", {"height_px": 300.0}),
]


@pytest.mark.parametrize(("reason", "changes"), BAD)
def test_a_detection_that_is_no_measurement_is_ignored_and_counted(
    reason: str, changes: dict[str, object]
) -> None:
    with_bad, without = Feed(), Feed()
    for _ in range(5):
        first = with_bad.step(pin_at(2.0, **changes), pin_at(2.0))
        second = without.step(pin_at(2.0))
        assert first == second
    assert with_bad.tracker.rejected[reason] == 5
    assert sum(without.tracker.rejected.values()) == 1  # the first detection fits no candidate


def test_nan_all_over_a_scan_is_a_scan_of_drop_outs() -> None:
    feed, world = Feed(), World(pins=[(2.0, 0.0)])
    scan = world.scan(10.0)
    blind = dataclasses.replace(scan, ranges_m=np.full(360, math.nan))
    for _ in range(6):
        feed.step(pin_at(2.0))
        track = feed.tracker.update(
            feed.now_s, feed.poses, SPEC, None, dataclasses.replace(blind, stamp_s=feed.now_s - 0.2)
        )
    assert track is not None
    assert track.last_ranged_s == -math.inf
    assert math.isfinite(track.sigma_m)


@pytest.mark.parametrize("now_s", [math.nan, math.inf, -1.0])
def test_a_bad_clock_gives_no_track_and_changes_nothing(now_s: float) -> None:
    feed = Feed()
    feed.steps(6, pin_at(2.0))
    assert feed.tracker.update(now_s, feed.poses, SPEC, None, None) is None
    assert feed.wait(0.05) is not None
