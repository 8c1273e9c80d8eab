"""Which target is meant, how long an unseen one is kept, and what close range changes."""

from __future__ import annotations

import math
from dataclasses import replace
from itertools import pairwise

import pytest

from target_nav.nav.tracker import TargetTracker
from target_nav.state.types import Pose2D, Track, Twist2D
from tests.unit.nav.scripted_world import (
    SPEC,
    Drive,
    Sensors,
    World,
    box,
    error_m,
)
from tests.unit.nav.tracker_feed import AHEAD, CAMERA_X_M, CONFIG, ROOM, Feed, pin_at, relative_error_m

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


def test_a_thing_that_is_taken_for_a_target_now_and_then_is_never_confirmed() -> None:
    """A bottle that carries the target's label in one frame of six is seen often enough in a minute, never steadily."""
    feed = Feed()
    for _ in range(60):
        track = feed.step(pin_at(2.0))
        assert track is None or not track.confirmed
        feed.steps(5)


def test_a_target_that_half_of_the_frames_miss_is_confirmed() -> None:
    feed = Feed()
    track = None
    for _ in range(6):
        feed.step(pin_at(2.0))
        track = feed.step()
    assert track is not None
    assert track.confirmed


@pytest.mark.parametrize("lidar_width_m", [0.0, 0.032])
def test_the_lidar_is_believed_for_the_width_that_it_sees(lidar_width_m: float) -> None:
    """A pin's neck is where the LiDAR looks: its centre lies nearer behind what comes back than half a belly."""
    spec = replace(SPEC, lidar_width_m=lidar_width_m)
    pin = (0.7, 0.0)
    world = World(circles=[(*pin, 0.5 * spec.width_at_lidar_m)], walls=ROOM)
    feed, track = Feed(), None
    for _ in range(15):
        track = feed.step(pin_at(*pin), spec=spec, world=world)
    assert track is not None
    assert feed.now_s - track.last_ranged_s < 0.5
    assert track.range_m == pytest.approx(0.7, abs=0.008)
