"""The tracker in scripted worlds: where it says the target is, when it says so, and when it stops saying so."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Callable, Sequence
from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from target_nav.config import Config
from target_nav.nav.poses import PoseHistory
from target_nav.nav.tracker import TargetTracker
from target_nav.state.types import Detection, DetectionFrame, Odometry, Pose2D, TargetSpec, Track, Twist2D
from tests.unit.nav.scripted_world import (
    SPEC,
    STANDING,
    Drive,
    Sensors,
    Tick,
    World,
    box,
    detection,
    error_m,
    mirrored_frame,
    mirrored_odometry,
    mirrored_scan,
)

CONFIG = Config()
CAMERA_X_M = CONFIG.camera.x_m
ROOM = [(-3.0, -3.0, 5.0, -3.0), (5.0, -3.0, 5.0, 3.0), (5.0, 3.0, -3.0, 3.0), (-3.0, 3.0, -3.0, -3.0)]
AHEAD = Drive(Pose2D(), ((8.0, Twist2D(0.15, 0.0, 0.0)),))


class Feed:
    """A tracker on a robot that stands at the origin (or moves as told), fed with frames by hand at 10 Hz."""

    def __init__(self, drive: Drive = STANDING, config: Config = CONFIG) -> None:
        self.world = World(drive=drive, config=config)
        self.tracker = TargetTracker(config)
        self.now_s = drive.begin_s
        self.poses = self.world.poses(self.now_s, since_s=self.now_s - 1.0)

    def frame(self, *detections: Detection) -> DetectionFrame:
        return DetectionFrame(self.now_s - 0.1, 0, detections)

    def step(
        self, *detections: Detection, spec: TargetSpec = SPEC, world: World | None = None
    ) -> Track | None:
        """One frame with these detections, and a scan of `world` if given."""
        for _ in range(2):
            self.now_s += 0.05
            self.poses.add(self.world.odometry(self.now_s))
        scan = None if world is None else world.scan(self.now_s - 0.2)
        return self.tracker.update(self.now_s, self.poses, spec, self.frame(*detections), scan)

    def steps(self, count: int, *detections: Detection) -> Track | None:
        track = None
        for _ in range(count):
            track = self.step(*detections)
        return track

    def wait(self, seconds: float) -> Track | None:
        """No frames at all for so long."""
        track = None
        for _ in range(round(seconds / 0.05)):
            self.now_s += 0.05
            self.poses.add(self.world.odometry(self.now_s))
            track = self.tracker.update(self.now_s, self.poses, SPEC, None, None)
        return track


def pin_at(x_m: float, y_m: float = 0.0, **changes: object) -> Detection:
    """What the camera of a robot at the origin says of a pin there."""
    seen = detection(math.hypot(x_m - CAMERA_X_M, y_m), math.atan2(y_m, x_m - CAMERA_X_M))
    return dataclasses.replace(seen, **changes)


def relative_error_m(world: World, tick: Tick, pin: tuple[float, float]) -> float:
    return error_m(tick.track, world.in_odom(pin, tick.now_s))


# --- what it finds ---------------------------------------------------------------------------------------------------


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


# --- stamps ----------------------------------------------------------------------------------------------------------


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


# --- what the LiDAR may and may not do -----------------------------------------------------------------------------


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


# --- close by --------------------------------------------------------------------------------------------------------

TO_THE_PIN = Drive(Pose2D(), ((9.0, Twist2D(0.145, 0.0, 0.0)),))


def test_the_whole_approach_down_to_the_stand_off() -> None:
    pin = (1.6, 0.02)
    for seed in range(5):
        sensors = Sensors(seed=seed, scale_error=0.03, yaw_error_rad=0.008)
        world = World(pins=[pin], walls=ROOM, drive=TO_THE_PIN, sensors=sensors)
        for tick in world.run(TargetTracker(CONFIG), 12.0):
            if tick.now_s > 13.0:
                assert error_m(tick.track, pin) < 0.04
        assert error_m(tick.track, pin) < 0.01


def test_clipped_boxes_are_not_believed_in_range() -> None:
    """Without LiDAR: under 0.32 m from the lens the naive range stays at 0.32 m, whatever the pin's is."""
    pin = (1.6, 0.02)
    world = World(pins=[pin], drive=TO_THE_PIN, sensors=Sensors(seed=1, dropouts=99.0, miss_probability=0.0))
    tick = world.last_tick(12.0)
    assert tick.track is not None
    assert tick.frame is not None
    assert tick.frame.detections[0].clipped
    assert tick.now_s - tick.track.last_seen_s < 0.3
    assert tick.frame.detections[0].range_m > 1.5 * (tick.track.range_m - CAMERA_X_M)
    assert error_m(tick.track, pin) < 0.05


def test_a_pin_right_before_the_robot_at_the_start_is_found_though_its_box_is_clipped() -> None:
    pin = (0.36, 0.03)
    track = World(pins=[pin], walls=ROOM, sensors=Sensors(seed=2)).track_after(3.0)
    assert track is not None
    assert track.confirmed
    assert error_m(track, pin) < 0.02


def across_m(track: Track | None) -> float:
    """Standard deviation in y; the targets here are straight ahead."""
    assert track is not None
    return math.sqrt(track.covariance_m2[3])


def test_a_box_cut_off_at_the_side_is_less_sure_of_its_bearing_than_one_cut_off_at_the_top() -> None:
    top = Feed().step(pin_at(0.5, clipped=True))
    side = Feed().step(pin_at(0.5, clipped=True, u_px=5.0, width_px=20.0))
    assert across_m(side) > 1.5 * across_m(top)


def test_a_bearing_taken_while_turning_is_less_sure_for_its_stamp_is() -> None:
    turning = Feed(Drive(Pose2D(), ((5.0, Twist2D(0.0, 0.0, 1.0)),), begin_s=10.0)).step(pin_at(2.0))
    assert across_m(turning) > 1.3 * across_m(Feed().step(pin_at(2.0)))


def test_a_clipped_box_is_no_evidence_for_a_pin_far_away() -> None:
    feed = Feed()
    feed.steps(5, pin_at(3.0))
    track = feed.step(pin_at(0.4, clipped=True))
    assert track is not None
    assert track.range_m == pytest.approx(3.0, abs=0.1)
    assert track.hits == 5


# --- coasting and losing ---------------------------------------------------------------------------------------------


def test_an_unseen_target_stays_and_is_lost_after_three_seconds() -> None:
    feed = Feed()
    seen = feed.steps(6, pin_at(2.0))
    track = feed.wait(2.8)
    assert seen is not None
    assert track is not None
    assert (track.x_m, track.y_m) == (seen.x_m, seen.y_m)
    assert track.sigma_m > seen.sigma_m
    assert feed.wait(0.3) is None


def test_close_by_it_is_kept_as_long_as_a_blind_approach_may_last() -> None:
    feed = Feed()
    feed.steps(6, pin_at(CONFIG.approach.blind_from_m - 0.05))
    assert feed.wait(CONFIG.approach.blind_timeout_s - 0.3) is not None
    assert feed.wait(0.4) is None


def test_the_lidar_keeps_its_position_good_close_by_while_odometry_drifts() -> None:
    pin, drive = (1.2, 0.05), Drive(Pose2D(), ((6.0, Twist2D(0.14, 0.005, 0.0)),))
    world = World(
        pins=[pin],
        walls=ROOM,
        drive=drive,
        believed=drive.as_odometry_sees_it(1.05, 1.25, 0.05),
        sensors=Sensors(seed=4),
    )
    tick = world.last_tick(7.0)
    assert relative_error_m(world, tick, pin) < 0.02


def test_uncertainty_of_an_unseen_target_grows_with_the_way_driven() -> None:
    still, driven = Feed(), Feed(Drive(Pose2D(), ((20.0, Twist2D(0.2, 0.0, 0.0)),)))
    first, second = still.steps(6, pin_at(3.0)), None
    for _ in range(6):
        second = driven.step(pin_at(3.0 - driven.world.drive.pose(driven.now_s).x_m))
    assert first is not None
    assert second is not None
    after_still, after_driven = still.wait(2.0), driven.wait(2.0)
    assert after_still is not None
    assert after_driven is not None
    assert after_driven.sigma_m - second.sigma_m > 2.0 * (after_still.sigma_m - first.sigma_m)


def test_three_misses_or_ten_lose_nothing() -> None:
    feed, world = Feed(), World(pins=[(2.0, 0.0)], walls=ROOM)
    for _ in range(6):
        feed.step(pin_at(2.0), world=world)
    assert all(feed.step(world=world) is not None for _ in range(10))


def looked_at_and_not_seen(world: World, frames: int = 25) -> Track | None:
    feed = Feed()
    for _ in range(6):
        feed.step(pin_at(2.0))
    for _ in range(frames):
        track = feed.step(world=world)
    return track


def test_a_target_that_the_camera_looks_straight_at_and_does_not_see_is_lost_sooner() -> None:
    assert looked_at_and_not_seen(World(walls=ROOM)) is None


def test_but_not_when_something_hides_it() -> None:
    assert looked_at_and_not_seen(World(walls=[*ROOM, *box(1.0, 0.0, 0.2, 0.4)])) is not None


def test_nor_when_the_lidar_sees_it_stand_there() -> None:
    assert looked_at_and_not_seen(World(walls=ROOM, pins=[(2.0, 0.0)])) is not None


def test_nor_when_it_is_out_of_the_picture() -> None:
    turning = Drive(Pose2D(), ((0.6, Twist2D()), (2.0, Twist2D(0.0, 0.0, 1.0))))
    feed = Feed(turning)
    for _ in range(6):
        feed.step(pin_at(2.0))
    room = World(walls=ROOM, drive=turning)
    for _ in range(28):
        track = feed.step(world=room)
    assert track is not None


def test_a_pin_that_is_carried_away_is_found_again_where_it_stands_now() -> None:
    feed, before, after = Feed(), World(pins=[(2.0, 0.3)], walls=ROOM), World(pins=[(2.0, -0.4)], walls=ROOM)
    for _ in range(20):
        feed.step(pin_at(2.0, 0.3), world=before)
    for _ in range(35):
        track = feed.step(pin_at(2.0, -0.4), world=after)
    assert track is not None
    assert track.confirmed
    assert error_m(track, (2.0, -0.4)) < 0.03


# --- which one -------------------------------------------------------------------------------------------------------


def test_of_two_pins_the_nearer_is_meant() -> None:
    for pins in ([(1.5, 0.4), (2.6, -0.3)], [(2.6, -0.3), (1.5, 0.4)]):
        track = World(pins=pins, walls=ROOM, sensors=Sensors(seed=3)).track_after(2.0)
        assert error_m(track, (1.5, 0.4)) < 0.03


def switch_time_s(nearer_by_m: float) -> float | None:
    """Pin A is tracked, then B appears that is so much nearer: after how long B is meant, None if never in 4 s."""
    feed = Feed()
    a, b = pin_at(2.5, 0.4), pin_at(2.5 - nearer_by_m, -0.4)
    feed.steps(6, a)
    begin_s = feed.now_s
    for _ in range(40):
        track = feed.step(a, b)
        assert track is not None
        if track.y_m < 0.0:
            return feed.now_s - begin_s
    return None


def test_a_pin_that_is_a_little_nearer_does_not_change_its_mind() -> None:
    assert switch_time_s(0.1) is None
    assert switch_time_s(0.25) is None


def test_a_pin_that_is_clearly_nearer_does_after_a_while() -> None:
    took_s = switch_time_s(0.8)
    assert took_s is not None
    assert CONFIG.track.switch_after_s <= took_s < CONFIG.track.switch_after_s + 1.0


def test_it_does_not_swing_between_two_pins_while_driving_past_both() -> None:
    pins, chosen = [(2.2, 0.35), (2.3, -0.35)], []
    world = World(pins=pins, walls=ROOM, drive=AHEAD, sensors=Sensors(seed=11))
    for tick in world.run(TargetTracker(CONFIG), 9.0):
        if tick.track is not None and tick.track.confirmed:
            chosen.append(tick.track.y_m > 0.0)
    assert sum(a != b for a, b in pairwise(chosen)) == 0


def test_when_the_chosen_pin_is_lost_the_other_is_taken() -> None:
    feed = Feed()
    feed.steps(6, pin_at(1.5, 0.3), pin_at(2.5, -0.3))
    for _ in range(32):
        track = feed.step(pin_at(2.5, -0.3))
    assert error_m(track, (2.5, -0.3)) < 0.05


def test_two_boxes_on_one_pin_are_one_target() -> None:
    feed, chosen = Feed(), set()
    for _ in range(12):
        track = feed.step(pin_at(2.0, 0.0), pin_at(2.03, 0.01))
        assert track is not None
        chosen.add((round(track.x_m, 1), round(track.y_m, 1), track.hits))
    assert chosen == {(2.0, 0.0, hits) for hits in range(1, 13)}


# --- starting over ---------------------------------------------------------------------------------------------------


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


# --- bad input -------------------------------------------------------------------------------------------------------

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


# --- laws ------------------------------------------------------------------------------------------------------------


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


def monte_carlo(lidar: bool, runs: int) -> tuple[list[float], list[float]]:
    """Normalised squared errors, and errors at the end, of noisy drives past and towards a pin. Odometry drifts."""
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
        world = World(pins=[pin], walls=ROOM, drive=drive, believed=believed, sensors=sensors)
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


@pytest.mark.parametrize("lidar", [True, False])
def test_it_knows_how_wrong_it_is(lidar: bool) -> None:
    """NEES of a position in the plane is 2 on average for an exact filter; less is careful, more is over-confident."""
    squares, finals = monte_carlo(lidar, runs=12)
    assert len(squares) > 55
    assert 0.2 < np.mean(squares) < 3.5
    assert np.mean(np.array(squares) > 13.8) < 0.05
    assert np.quantile(finals, 0.95) < (0.03 if lidar else 0.15)
