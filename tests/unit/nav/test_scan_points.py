"""Scans in odom: each beam where the robot was when it was taken, drop-outs left out."""

from __future__ import annotations

import dataclasses
import math

import numpy as np
import pytest

from target_nav.config import Config, LidarConfig
from target_nav.nav.poses import PoseHistory
from target_nav.nav.scan_points import ScanPlacer, deskewed_points_in_odom
from target_nav.state.types import Odometry, Pose2D, Scan, Twist2D
from tests.unit.nav.scripted_world import Drive, World

ROOM = [(-2.0, -2.0, 3.0, -2.0), (3.0, -2.0, 3.0, 2.0), (3.0, 2.0, -2.0, 2.0), (-2.0, 2.0, -2.0, -2.0)]


def distance_to_room(points_m: np.ndarray) -> np.ndarray:
    x, y = points_m[:, 0], points_m[:, 1]
    return np.min(np.abs([x + 2.0, x - 3.0, y + 2.0, y - 2.0]), axis=0)


def test_a_still_robot_sees_the_room_where_it_is() -> None:
    world = World(walls=ROOM)
    points = deskewed_points_in_odom(world.scan(9.5), world.poses(9.7, since_s=9.0), world.config.lidar)
    assert points is not None
    assert points.points_in_odom_m.shape == (360, 2)
    assert distance_to_room(points.points_in_odom_m).max() < 1e-9
    assert points.points_in_base_m == pytest.approx(points.points_in_odom_m)


def test_a_scan_taken_while_driving_and_turning_is_straightened() -> None:
    world = World(walls=ROOM, drive=Drive(Pose2D(), ((3.0, Twist2D(0.3, 0.1, 0.5)),)))
    poses = world.poses(12.0, since_s=9.5)
    scan = world.scan(11.5)
    points = deskewed_points_in_odom(scan, poses, world.config.lidar)
    rigid = deskewed_points_in_odom(
        dataclasses.replace(scan, time_increment_s=0.0), poses, world.config.lidar
    )
    assert points is not None
    assert rigid is not None
    assert distance_to_room(points.points_in_odom_m).max() < 1e-3
    assert distance_to_room(rigid.points_in_odom_m).max() > 0.1


def test_the_laser_may_sit_anywhere_on_the_robot_and_look_anywhere() -> None:
    config = Config().override({"lidar.x_m": 0.1, "lidar.y_m": -0.05, "lidar.yaw_rad": 2.0})
    world = World(
        walls=ROOM, config=config, drive=Drive(Pose2D(0.4, 0.2, 1.0), ((3.0, Twist2D(0.2, 0.0, 0.4)),))
    )
    points = deskewed_points_in_odom(world.scan(11.0), world.poses(12.0, since_s=9.5), config.lidar)
    assert points is not None
    assert distance_to_room(points.points_in_odom_m).max() < 1e-3


def still(stamp_s: float = 1.0) -> PoseHistory:
    history = PoseHistory()
    for index in range(21):
        history.add(Odometry(stamp_s - 0.5 + 0.05 * index, Pose2D(), Twist2D()))
    return history


def scan_of(ranges_m: list[float], **changes: float) -> Scan:
    scan = Scan(1.0, 0.0, math.radians(1.0), 0.0005, 0.15, 12.0, np.array(ranges_m))
    return dataclasses.replace(scan, **changes)


def test_drop_outs_and_what_lies_outside_the_limits_are_no_points() -> None:
    ranges = [1.0, math.inf, math.nan, 0.0, -1.0, 0.14, 0.15, 12.0, 12.1, -math.inf]
    points = deskewed_points_in_odom(scan_of(ranges), still(), LidarConfig())
    assert points is not None
    assert points.beams.tolist() == [0, 6, 7]
    assert np.isinf(points.ranges_m).tolist() == [i not in (0, 6, 7) for i in range(10)]


def test_a_scan_of_nothing_but_drop_outs_has_no_points() -> None:
    points = deskewed_points_in_odom(scan_of([math.inf] * 360), still(), LidarConfig())
    assert points is not None
    assert points.points_in_odom_m.shape == (0, 2)
    assert points.is_closed


def test_poses_must_cover_the_whole_scan() -> None:
    poses = still()
    assert deskewed_points_in_odom(scan_of([1.0] * 360, stamp_s=0.41), poses, LidarConfig()) is not None
    assert deskewed_points_in_odom(scan_of([1.0] * 360, stamp_s=0.39), poses, LidarConfig()) is None
    assert deskewed_points_in_odom(scan_of([1.0] * 360, stamp_s=1.5), poses, LidarConfig()) is None
    assert deskewed_points_in_odom(scan_of([1.0] * 360), PoseHistory(), LidarConfig()) is None


@pytest.mark.parametrize(
    "scan",
    [
        scan_of([]),
        scan_of([1.0], stamp_s=math.nan),
        scan_of([1.0], angle_min_rad=math.inf),
        scan_of([1.0, 1.0], angle_increment_rad=0.0),
        scan_of([1.0, 1.0], angle_increment_rad=math.nan),
        scan_of([1.0, 1.0], time_increment_s=-0.001),
    ],
)
def test_a_scan_without_a_geometry_is_none(scan: Scan) -> None:
    assert deskewed_points_in_odom(scan, still(), LidarConfig()) is None


def test_a_laser_may_turn_clockwise() -> None:
    clockwise = scan_of([2.0, 1.0], angle_increment_rad=-0.5 * math.pi)
    points = deskewed_points_in_odom(clockwise, still(), LidarConfig())
    assert points is not None
    assert points.points_in_odom_m == pytest.approx(np.array([[2.0, 0.0], [0.0, -1.0]]))


def test_single_precision_ranges_are_taken() -> None:
    scan = dataclasses.replace(scan_of([]), ranges_m=np.array([1.0, 2.0], dtype=np.float32))
    points = deskewed_points_in_odom(scan, still(), LidarConfig())
    assert points is not None
    assert points.points_in_odom_m.dtype == np.float64


def test_a_scan_is_placed_once_until_a_newer_odometry_may_place_it_better() -> None:
    world = World(walls=ROOM, drive=Drive(Pose2D(), ((3.0, Twist2D(0.3, 0.0, 0.0)),)))
    scan, poses = world.scan(11.5), world.poses(11.6, since_s=10.5)
    placer = ScanPlacer(world.config.lidar)
    first = placer.place(scan, poses)
    assert first is not None
    assert placer.place(scan, poses) is first
    poses.add(world.odometry(11.75))
    again = placer.place(scan, poses)
    assert again is not first
    expected = deskewed_points_in_odom(scan, poses, world.config.lidar)
    assert again is not None
    assert expected is not None
    assert (again.points_in_odom_m == expected.points_in_odom_m).all()


def test_a_scan_that_odometry_does_not_cover_is_placed_when_it_does() -> None:
    world = World(walls=ROOM)
    scan, poses = world.scan(11.5), world.poses(11.2, since_s=10.5)
    placer = ScanPlacer(world.config.lidar)
    assert placer.place(scan, poses) is None
    poses.add(world.odometry(11.4))
    poses.add(world.odometry(11.7))
    assert placer.place(scan, poses) is not None
