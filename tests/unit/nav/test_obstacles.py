"""The obstacle memory: holes in a scan are not free space, ghosts go, and the target is no obstacle."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Sequence

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from target_nav.config import Config
from target_nav.nav.obstacles import CELL_M, ObstacleMemory
from target_nav.nav.poses import PoseHistory
from target_nav.state.types import FloatArray, Odometry, Pose2D, Scan, Track, Twist2D
from tests.unit.nav.scripted_world import SPEC, Drive, Sensors, World, box, mirrored_odometry, mirrored_scan

CONFIG = Config()
ORIGIN = Pose2D()
TURN_S = 1.0 / CONFIG.lidar.rate_hz
BOX_AHEAD = box(0.9, 0.0, 0.2, 0.3)
ROOM = [(-2.0, -2.0, 3.0, -2.0), (3.0, -2.0, 3.0, 2.0), (3.0, 2.0, -2.0, 2.0), (-2.0, 2.0, -2.0, -2.0)]


def watch(
    worlds: Sequence[World], seconds: float, since_s: float = 10.0
) -> tuple[ObstacleMemory, PoseHistory]:
    """What a memory knows after each world was watched for so long, one after the other, at 20 Hz."""
    memory, poses = ObstacleMemory(worlds[0].config), PoseHistory()
    scan: Scan | None = None
    for index in range(round(seconds * len(worlds) * 20.0) + 1):
        now_s = since_s + 0.05 * index
        world = worlds[min(int((now_s - since_s) / seconds), len(worlds) - 1)]
        poses.add(world.odometry(now_s))
        begun_s = since_s + (math.floor((now_s - since_s) / TURN_S + 1e-9) - 1) * TURN_S
        if begun_s >= since_s and (scan is None or begun_s > scan.stamp_s + 1e-6):
            scan = world.scan(begun_s)
        memory.update(now_s, poses, scan)
    return memory, poses


def seen(memory: ObstacleMemory, pose: Pose2D = ORIGIN, track: Track | None = None) -> FloatArray:
    return memory.points_in_base(pose, track, SPEC)


def near(points_m: FloatArray, x_m: float, y_m: float, within_m: float = 0.1) -> int:
    return int((np.hypot(points_m[:, 0] - x_m, points_m[:, 1] - y_m) < within_m).sum())


def track_at(x_m: float, y_m: float, sigma_m: float = 0.01, confirmed: bool = True) -> Track:
    return Track(12.0, x_m, y_m, (sigma_m**2, 0.0, 0.0, sigma_m**2), confirmed, 9, 12.0, 12.0, 1.0, 0.0)


def scan_with(returns: dict[int, float], stamp_s: float, elsewhere: float = math.inf) -> Scan:
    """A scan at 1 degree a beam, beam 0 ahead, with these returns and the same range in all other directions."""
    ranges = np.full(360, elsewhere)
    for beam, range_m in returns.items():
        ranges[beam] = range_m
    return Scan(stamp_s, 0.0, math.radians(1.0), TURN_S / 360.0, 0.15, 12.0, ranges)


def still(until_s: float = 20.0) -> PoseHistory:
    return World().poses(until_s, since_s=until_s - 3.0)


def test_the_face_of_a_box_is_seen_point_by_point_at_its_place() -> None:
    memory, _ = watch([World(walls=BOX_AHEAD)], 0.5)
    points = seen(memory)
    assert len(points) >= 6
    assert np.abs(points[:, 0] - 0.8).max() < 1e-6
    assert np.abs(points[:, 1]).max() < 0.15
    assert np.abs(np.diff(np.sort(points[:, 1]))).max() < 0.06


def test_a_box_stays_while_the_lidar_loses_beam_after_beam() -> None:
    memory, _ = watch([World(walls=BOX_AHEAD, sensors=Sensors(seed=1, dropouts=3.0))], 1.5)
    assert len(seen(memory)) >= 6
    points = seen(memory)
    assert np.abs(np.diff(np.sort(points[:, 1]))).max() < 0.09


def test_a_box_out_of_sight_is_forgotten_after_the_memory_and_not_before() -> None:
    memory, poses = watch([World(walls=BOX_AHEAD)], 0.5)
    world = World()
    for now_s in np.arange(10.55, 13.2, 0.05):
        poses.add(world.odometry(now_s))
        memory.update(float(now_s), poses, scan_with({}, float(now_s) - 0.2))
    assert near(seen(memory), 0.8, 0.0)
    memory.update(10.5 + CONFIG.avoid.memory_s + 0.1, poses, None)
    assert len(seen(memory)) == 0


def test_what_the_newest_scan_saw_stays_though_the_memory_be_short() -> None:
    memory = ObstacleMemory(CONFIG.override({"avoid.memory_s": 0.0}))
    memory.update(20.0, still(), scan_with({0: 1.0, 1: 1.0}, 19.8))
    memory.update(20.1, still(), None)
    assert near(seen(memory), 1.0, 0.0) >= 1


def test_and_what_older_scans_saw_goes_without_it() -> None:
    memory = ObstacleMemory(CONFIG.override({"avoid.memory_s": 0.1}))
    memory.update(19.4, still(), scan_with({0: 1.0, 1: 1.0}, 19.2))
    memory.update(19.6, still(), scan_with({90: 1.0, 91: 1.0}, 19.4))
    memory.update(20.0, still(), None)
    assert near(seen(memory), 1.0, 0.0) == 0
    assert near(seen(memory), 0.0, 1.0) >= 1


def test_a_box_that_was_taken_away_is_seen_through_within_two_scans() -> None:
    memory, _ = watch([World(walls=[*BOX_AHEAD, *ROOM]), World(walls=ROOM)], 0.6)
    assert near(seen(memory), 0.8, 0.0, 0.25) == 0


def test_drop_outs_do_not_clear() -> None:
    memory, poses = watch([World(walls=BOX_AHEAD)], 0.5)
    before = len(seen(memory))
    for now_s in (10.6, 10.8, 11.0):
        poses.add(World().odometry(now_s))
        memory.update(now_s, poses, scan_with({}, now_s - 0.2))
    assert len(seen(memory)) == before


def test_a_leg_whose_own_beams_are_lost_is_not_cleared_by_the_beams_beside_it() -> None:
    memory = ObstacleMemory(CONFIG)
    memory.update(19.2, still(), scan_with({0: 1.0, 1: 1.0}, 19.0, elsewhere=3.0))
    for now_s in (19.4, 19.6, 19.8):
        memory.update(now_s, still(), scan_with({0: math.inf, 1: math.inf}, now_s - 0.2, elsewhere=3.0))
    assert near(seen(memory), 1.0, 0.01) >= 1


def test_one_scan_that_looks_past_a_thing_is_not_enough() -> None:
    memory = ObstacleMemory(CONFIG)
    memory.update(19.2, still(), scan_with({0: 1.0, 1: 1.0}, 19.0, elsewhere=3.0))
    memory.update(19.4, still(), scan_with({}, 19.2, elsewhere=3.0))
    assert near(seen(memory), 1.0, 0.01) >= 1
    memory.update(19.6, still(), scan_with({}, 19.4, elsewhere=3.0))
    assert near(seen(memory), 1.0, 0.01) == 0


def test_a_beam_that_comes_back_from_a_little_farther_is_noise_and_clears_nothing() -> None:
    memory = ObstacleMemory(CONFIG)
    memory.update(19.2, still(), scan_with(dict.fromkeys(range(10), 1.02), 19.0))
    for now_s in (19.4, 19.6, 19.8):
        memory.update(now_s, still(), scan_with(dict.fromkeys(range(10), 1.09), now_s - 0.2))
    assert near(seen(memory), 1.02, 0.05, 0.03) >= 1


def test_a_turning_robot_looks_with_the_right_beam() -> None:
    """At 1 rad/s the laser is 10 degrees farther at the end of a scan: a box there, its beams lost, must stay."""
    world = World(
        walls=[*box(-1.0, 0.25, 0.2, 0.3), *ROOM], drive=Drive(Pose2D(), ((9.0, Twist2D(0.0, 0.0, 1.0)),))
    )
    memory, poses = ObstacleMemory(CONFIG), world.poses(10.5, since_s=9.5)
    memory.update(10.3, poses, world.scan(10.05))
    before = len(memory.points_in_base(world.drive.pose(10.3), None, SPEC))
    assert before >= 4
    for stamp_s in (10.06, 10.07, 10.08):
        scan = world.scan(stamp_s)
        scan.ranges_m[scan.ranges_m < 1.5] = math.inf
        memory.update(10.4, poses, scan)
    # One at a grazing edge may go: the next beam aside really passes it.
    assert len(memory.points_in_base(world.drive.pose(10.3), None, SPEC)) >= before - 1


def test_something_nearer_does_not_clear_what_it_hides() -> None:
    memory = ObstacleMemory(CONFIG)
    memory.update(19.4, still(), scan_with(dict.fromkeys(range(10), 1.0), 19.2))
    for now_s in (19.6, 19.8, 20.0):
        memory.update(now_s, still(), scan_with(dict.fromkeys(range(-2, 12), 0.6), now_s - 0.2))
    assert near(seen(memory), 1.0, 0.09)


def test_a_wall_seen_along_its_length_is_not_cleared_by_beams_that_meet_it_farther_on() -> None:
    memory, _ = watch(
        [World(walls=[(-1.5, 0.3, 3.0, 0.3), (3.0, 3.0, 3.0, -3.0)], sensors=Sensors(seed=2))], 2.0
    )
    points = seen(memory)
    along = np.sort(points[np.abs(points[:, 1] - 0.3) < 0.03][:, 0])
    assert along[0] < -1.1
    assert along[-1] > 2.5
    # A beam meets a wall 0.3 m aside r^2 / 0.3 m * 1 degree after the one before it: 0.10 m at 1.3 m, 0.44 m at 2.7 m.
    # With one point a cell of the memory, no hole is wider than that: nothing was cleared in between.
    far_m = np.maximum(np.abs(along[:-1]), np.abs(along[1:]))
    spacing = (far_m**2 + 0.3**2) / 0.3 * math.radians(1.0)
    assert (np.diff(along) < 1.2 * spacing + 2.0 * CELL_M).all()


def test_a_lone_return_is_an_obstacle_at_once_and_is_forgotten_with_the_next_look() -> None:
    memory = ObstacleMemory(CONFIG)
    memory.update(19.6, still(), scan_with({0: 0.5}, 19.4, elsewhere=3.0))
    assert near(seen(memory), 0.5, 0.0) == 1
    memory.update(19.8, still(), scan_with({}, 19.6, elsewhere=3.0))
    assert near(seen(memory), 0.5, 0.0) == 0


def test_a_lone_return_in_the_open_is_forgotten_in_half_a_second() -> None:
    memory = ObstacleMemory(CONFIG)
    memory.update(19.2, still(), scan_with({0: 0.5}, 19.0))
    memory.update(19.4, still(), scan_with({}, 19.2))
    assert near(seen(memory), 0.5, 0.0) == 1
    memory.update(19.6, still(), None)
    assert near(seen(memory), 0.5, 0.0) == 0


def test_a_thin_leg_that_one_beam_finds_again_and_again_stays() -> None:
    memory = ObstacleMemory(CONFIG)
    memory.update(18.4, still(), scan_with({0: 1.0}, 18.2))
    memory.update(18.6, still(), scan_with({1: 1.0}, 18.4))
    memory.update(20.0, still(), scan_with({}, 19.8))
    assert near(seen(memory), 1.0, 0.02) >= 1


def test_noise_all_round_does_not_fill_the_way() -> None:
    rng, memory = np.random.default_rng(3), ObstacleMemory(CONFIG)
    counts = []
    for index in range(80):
        now_s = 17.2 + 0.182 * index
        poses = still(now_s + 0.1)
        ranges = np.where(rng.random(360) < 0.01, rng.uniform(0.2, 3.0, 360), 3.0)
        memory.update(now_s, poses, dataclasses.replace(scan_with({}, now_s - 0.182), ranges_m=ranges))
        points = seen(memory)
        ahead = (np.abs(points[:, 1]) < 0.2) & (points[:, 0] > 0.15) & (points[:, 0] < 1.4)
        counts.append(int(ahead.sum()))
    # 3.6 false returns a scan, a third of them within the look-ahead; the way ahead is a tenth of that area.
    assert np.mean(counts) < 0.5
    assert counts.count(0) > 40


def test_the_body_does_not_see_itself() -> None:
    memory = ObstacleMemory(CONFIG.override({"lidar.x_m": 0.05}))
    # something of the robot's own that stands 0.11 m behind base_link
    memory.update(20.0, still(), scan_with(dict.fromkeys(range(150, 211), 0.16), 19.8))
    assert len(seen(memory)) == 0
    memory.update(20.1, still(20.2), scan_with({0: 0.16, 1: 0.16}, 19.9))
    assert near(seen(memory), 0.21, 0.0) >= 1


def test_the_body_leaves_no_trail() -> None:
    world, memory = World(drive=Drive(Pose2D(), ((5.0, Twist2D(0.3, 0.0, 0.0)),))), ObstacleMemory(CONFIG)
    poses, own = world.poses(12.0, since_s=9.5), dict.fromkeys(range(170, 191), 0.10)
    blind = dataclasses.replace(scan_with(own, 10.0), range_min_m=0.05)
    for stamp_s in (10.0, 10.5, 11.0, 11.5):
        memory.update(stamp_s + 0.2, poses, dataclasses.replace(blind, stamp_s=stamp_s))
    assert len(seen(memory, world.drive.pose(12.0))) == 0


def test_a_point_the_robot_has_driven_over_was_none() -> None:
    memory, _ = watch([World(walls=BOX_AHEAD)], 0.5)
    points = seen(memory, Pose2D(0.75, 0.0, 0.0))
    assert not ((np.abs(points[:, 0]) < 0.13) & (np.abs(points[:, 1]) < 0.12)).any()


def test_points_are_given_in_base_wherever_the_robot_is_by_now() -> None:
    memory, _ = watch([World(walls=BOX_AHEAD)], 0.5)
    points = seen(memory, Pose2D(0.3, 0.2, math.pi / 2))
    assert near(points, -0.2, -0.5, 0.06)


def farthest_m(points_m: FloatArray) -> float:
    return float(np.hypot(points_m[:, 0], points_m[:, 1]).max())


def test_a_whole_room_is_handed_out_as_far_as_the_memory_reaches() -> None:
    memory, _ = watch([World(walls=ROOM)], 0.5)
    points = seen(memory)
    for x_m, y_m in ((-2.0, 0.0), (3.0, 0.0), (0.0, 2.0), (0.0, -2.0), (2.9, 1.9), (-1.9, -1.9)):
        assert near(points, x_m, y_m, 0.15), f"the wall at {x_m}, {y_m} m"
    assert farthest_m(points) <= CONFIG.avoid.memory_radius_m


def test_beyond_its_radius_nothing_is_handed_out_and_it_comes_in_as_the_robot_comes_nearer() -> None:
    config = CONFIG.override({"avoid.memory_radius_m": 1.8})
    memory, _ = watch([World(walls=ROOM, config=config)], 0.5)
    assert len(seen(memory)) == 0, "the nearest wall is 2 m off"
    close = seen(memory, Pose2D(-0.4, 0.0, 0.0))
    assert near(close, -1.6, 0.0), "remembered a little farther than it is handed out"
    assert farthest_m(close) <= 1.8


def test_however_short_the_memory_it_reaches_as_far_as_the_avoidance_looks() -> None:
    memory, _ = watch([World(walls=BOX_AHEAD, config=CONFIG.override({"avoid.memory_radius_m": 0.5}))], 0.5)
    assert near(seen(memory), 0.8, 0.0)


def test_noise_at_four_metres_does_not_eat_a_wall() -> None:
    """Far walls are noisy (sigma 25 mm, single beams much more): what one scan puts nearer the next does not clear."""
    walls = [(3.7, -1.5, 3.7, 1.5), (-5.0, -5.0, -5.0, 5.0)]
    memory, _ = watch([World(walls=walls, sensors=Sensors(seed=4))], 3.0)
    points = seen(memory)
    across = np.sort(points[np.abs(points[:, 0] - 3.7) < 0.3][:, 1])
    assert across[0] < -1.2
    assert across[-1] > 1.2
    assert np.diff(across).max() < 0.2


def test_the_confirmed_target_is_left_out_and_the_box_beside_it_is_not() -> None:
    world = World(pins=[(0.9, 0.0)], walls=box(0.9, 0.25, 0.2, 0.2))
    memory, _ = watch([world], 0.5)
    assert near(seen(memory), 0.9, 0.0, 0.06)
    without = seen(memory, track=track_at(0.9, 0.0))
    assert near(without, 0.9, 0.0, 0.06) == 0
    assert near(without, 0.8, 0.2, 0.06)
    assert near(without, 0.9, 0.15, 0.06)


def test_an_unconfirmed_target_is_an_obstacle() -> None:
    memory, _ = watch([World(pins=[(0.9, 0.0)])], 0.5)
    assert near(seen(memory, track=track_at(0.9, 0.0, confirmed=False)), 0.9, 0.0, 0.06)


def test_an_uncertain_target_never_hides_more_than_the_gate() -> None:
    memory, _ = watch([World(walls=[(0.9, -1.0, 0.9, 1.0)])], 0.5)
    points = seen(memory, track=track_at(0.9, 0.0, sigma_m=5.0))
    assert np.abs(points[:, 1]).min() <= CONFIG.track.lidar_range_gate_m + 0.5 * SPEC.width_m + 0.05
    assert len(seen(memory, track=track_at(math.nan, 0.0))) == len(seen(memory))


def test_a_jump_of_odometry_forgets_everything() -> None:
    memory, poses = watch([World(walls=BOX_AHEAD)], 0.5)
    poses.add(Odometry(10.6, Pose2D(3.0, 0.0, 0.0), Twist2D()))
    memory.update(10.6, poses, None)
    assert len(seen(memory)) == 0


def test_a_scan_that_comes_before_its_odometry_is_taken_when_that_comes() -> None:
    memory, poses = ObstacleMemory(CONFIG), World().poses(10.0, since_s=9.0)
    scan = scan_with({0: 1.0}, 10.0)
    memory.update(10.2, poses, scan)
    assert len(seen(memory)) == 0
    poses.add(World().odometry(10.15))
    memory.update(10.25, poses, scan)
    assert len(seen(memory)) == 1


@pytest.mark.parametrize("stamp_s", [math.nan, math.inf, 1e6])
def test_a_scan_with_a_wrong_stamp_is_ignored_and_does_not_stop_later_ones(stamp_s: float) -> None:
    memory = ObstacleMemory(CONFIG)
    memory.update(19.9, still(), scan_with({0: 1.0}, stamp_s))
    assert len(seen(memory)) == 0
    memory.update(20.0, still(), scan_with({0: 1.0}, 19.8))
    assert len(seen(memory)) == 1


def test_a_bad_clock_or_pose_is_nothing_to_go_by() -> None:
    memory, _ = watch([World(walls=BOX_AHEAD)], 0.5)
    before = len(seen(memory))
    memory.update(math.nan, still(), None)
    assert len(seen(memory)) == before
    assert seen(memory, Pose2D(math.nan, 0.0, 0.0)).shape == (0, 2)


def test_driving_past_a_box_with_odometry_that_drifts_leaves_one_box() -> None:
    drive = Drive(Pose2D(-0.6, 0.0, 0.0), ((6.0, Twist2D(0.25, 0.0, 0.0)),))
    world = World(
        walls=[*box(0.5, 0.55, 0.3, 0.3), *ROOM],
        drive=drive,
        believed=drive.as_odometry_sees_it(1.02, 1.08, 0.01),
        sensors=Sensors(seed=5),
    )
    memory, poses = watch([world], 5.0)
    assert poses.latest is not None
    points = seen(memory, poses.latest.pose_in_odom)
    true = drive.pose(15.0)
    corner = points[
        (points[:, 1] > 0.0) & (points[:, 1] < 1.2) & (points[:, 0] < 0.8) & (points[:, 0] > -0.8)
    ]
    inside_x = (corner[:, 0] > 0.35 - true.x_m - 0.08) & (corner[:, 0] < 0.65 - true.x_m + 0.08)
    inside_y = (corner[:, 1] > 0.40 - true.y_m - 0.08) & (corner[:, 1] < 0.70 - true.y_m + 0.08)
    assert len(corner) > 5
    assert (inside_x & inside_y).all()


@settings(max_examples=25, deadline=None)
@given(
    st.lists(st.tuples(st.floats(0.3, 1.3), st.floats(-math.pi, math.pi)), min_size=1, max_size=12),
    st.floats(-0.3, 0.3),
    st.integers(0, 1000),
)
def test_a_mirrored_world_makes_a_mirrored_memory(
    posts: list[tuple[float, float]], wz: float, seed: int
) -> None:
    circles = [(r * math.cos(a), r * math.sin(a), 0.05) for r, a in posts]
    drive = Drive(Pose2D(), ((5.0, Twist2D(0.1, 0.05, wz)),))
    world = World(circles=circles, drive=drive, sensors=Sensors(seed=seed))
    memory, mirrored = ObstacleMemory(CONFIG), ObstacleMemory(CONFIG)
    poses, mirrored_poses = world.poses(11.5, since_s=10.0), PoseHistory()
    for index in range(31):
        mirrored_poses.add(mirrored_odometry(world.odometry(10.0 + 0.05 * index)))
    for scan in (world.scan(10.8), world.scan(11.0), world.scan(11.2)):
        memory.update(11.5, poses, scan)
        mirrored.update(11.5, mirrored_poses, mirrored_scan(scan))
    left = memory.points_in_base(drive.pose(11.5), None, SPEC)
    right = mirrored.points_in_base(mirrored_odometry(world.odometry(11.5)).pose_in_odom, None, SPEC)
    assert len(left) == len(right)
    # One point a cell, and in a mirror another point of the cell may be the one that stays.
    for first, second in ((left, right), (right, left)):
        for x_m, y_m in first:
            assert np.hypot(second[:, 0] - x_m, second[:, 1] + y_m).min() < 1.5 * CELL_M
