"""The world round the robot, in base_link as it stands now: LiDAR, obstacles as VFH sees them, target, chosen way."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from target_nav.config import RobotConfig
from target_nav.gui.geometry import Ellipse, ellipse_of, seen_from
from target_nav.gui.source import World
from target_nav.state.types import STOP, FloatArray, Pose2D, Twist2D
from target_nav.utils.frames import to_child, wrap_angle

_NO_POINTS: FloatArray = np.empty((0, 2))


@dataclass(frozen=True)
class TargetView:
    """The track in base_link. `age_s` is the time since the camera saw it last."""

    ellipse: Ellipse
    range_m: float
    bearing_rad: float
    sigma_m: float
    confirmed: bool
    age_s: float


@dataclass(frozen=True)
class BodyView:
    """The footprint, from base_link."""

    front_m: float
    rear_m: float
    half_width_m: float


@dataclass(frozen=True, eq=False)
class RadarView:
    """Points have shape (N, 2), metres, x ahead, y left. `direction_rad` is None when nobody steers round obstacles."""

    points_m: FloatArray
    points_age_s: float
    points_fresh: bool
    obstacles_m: FloatArray
    room_m: FloatArray
    """Corners of the room that the body can reach going straight: VFH's histogram."""
    direction_rad: float | None
    free_ahead_m: float
    along_the_way: bool
    avoid_fresh: bool
    target: TargetView | None
    twist: Twist2D
    body: BodyView
    fresh: bool
    message: str


def radar_view(world: World, robot: RobotConfig) -> RadarView:
    nav, laser, avoid = world.nav.value, world.laser.value, world.avoid.value
    pose = nav.pose_in_odom if nav is not None else Pose2D()
    points = obstacles = room = _NO_POINTS
    direction: float | None = None
    if laser is not None:
        points = seen_from(laser.points_in_base_m, laser.pose_in_odom, pose)
    if avoid is not None:
        obstacles = seen_from(avoid.obstacles_in_base_m, avoid.pose_in_odom, pose)
        if avoid.active:
            room = seen_from(avoid.outline_in_base_m, avoid.pose_in_odom, pose)
            direction = wrap_angle(avoid.direction_rad + avoid.pose_in_odom.yaw_rad - pose.yaw_rad)
    return RadarView(
        points_m=points,
        points_age_s=world.laser.age_s,
        points_fresh=world.laser.fresh,
        obstacles_m=obstacles,
        room_m=room,
        direction_rad=direction,
        free_ahead_m=avoid.free_ahead_m if avoid is not None else 0.0,
        along_the_way=avoid.along_the_way if avoid is not None else False,
        avoid_fresh=world.avoid.fresh,
        target=_target(world, pose),
        twist=nav.twist_sent if nav is not None else STOP,
        body=BodyView(robot.front_m, robot.rear_m, robot.half_width_m),
        fresh=world.nav.fresh and world.laser.fresh,
        message=world.nav.excuse or world.laser.excuse,
    )


def _target(world: World, pose: Pose2D) -> TargetView | None:
    nav = world.nav.value
    if nav is None or nav.track is None:
        return None
    track, ellipse = nav.track, ellipse_of(nav.track)
    x_m, y_m = to_child(pose, track.x_m, track.y_m)
    return TargetView(
        Ellipse(x_m, y_m, ellipse.major_m, ellipse.minor_m, wrap_angle(ellipse.angle_rad - pose.yaw_rad)),
        math.hypot(x_m, y_m),
        math.atan2(y_m, x_m),
        track.sigma_m,
        track.confirmed,
        world.now_s - track.last_seen_s,
    )
