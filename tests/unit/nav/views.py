"""Views made by hand, and a world mirrored at the robot's x axis, for tests of skills."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from target_nav.nav.skill import View
from target_nav.state.types import STOP, DetectionFrame, FloatArray, Pose2D, Track, Twist2D
from target_nav.utils.frames import to_child

ORIGIN = Pose2D()
NO_POINTS: FloatArray = np.empty((0, 2))


def points(*xy: tuple[float, float]) -> FloatArray:
    return np.array(xy, dtype=np.float64).reshape(-1, 2)


def wall(x1: float, y1: float, x2: float, y2: float, step: float = 0.03) -> FloatArray:
    """Points along a line, both ends included."""
    count = max(int(math.hypot(x2 - x1, y2 - y1) / step) + 1, 2)
    return np.column_stack([np.linspace(x1, x2, count), np.linspace(y1, y2, count)])


def track_at(
    x: float,
    y: float,
    now_s: float,
    pose: Pose2D = ORIGIN,
    *,
    seen_ago_s: float = 0.1,
    ranged_ago_s: float = 0.1,
    confirmed: bool = True,
    sigma_m: float = 0.01,
) -> Track:
    ahead, left = to_child(pose, x, y)
    variance = sigma_m**2
    return Track(
        stamp_s=now_s,
        x_m=x,
        y_m=y,
        covariance_m2=(variance, 0.0, 0.0, variance),
        confirmed=confirmed,
        hits=10,
        last_seen_s=now_s - seen_ago_s,
        last_ranged_s=now_s - ranged_ago_s,
        range_m=math.hypot(ahead, left),
        bearing_rad=math.atan2(left, ahead),
    )


def view(
    now_s: float = 100.0,
    *,
    pose: Pose2D = ORIGIN,
    twist: Twist2D = STOP,
    track: Track | None = None,
    obstacles: FloatArray | Sequence[tuple[float, float]] = (),
    detections: DetectionFrame | None = None,
    dt_s: float = 0.05,
) -> View:
    return View(
        now_s, dt_s, pose, twist, track, np.array(obstacles, dtype=np.float64).reshape(-1, 2), detections
    )


def mirrored(seen: View) -> View:
    """The same view with left and right exchanged, in base_link and in odom."""
    pose, twist, track = seen.pose_in_odom, seen.twist_in_base, seen.track
    return replace(
        seen,
        pose_in_odom=Pose2D(pose.x_m, -pose.y_m, -pose.yaw_rad),
        twist_in_base=Twist2D(twist.vx_mps, -twist.vy_mps, -twist.wz_radps),
        track=None if track is None else replace(track, y_m=-track.y_m, bearing_rad=-track.bearing_rad),
        obstacles_in_base_m=seen.obstacles_in_base_m * np.array([1.0, -1.0]),
    )


def assert_mirrored(one: Twist2D, other: Twist2D, tolerance: float = 1e-6) -> None:
    assert abs(one.vx_mps - other.vx_mps) <= tolerance, (one, other)
    assert abs(one.vy_mps + other.vy_mps) <= tolerance, (one, other)
    assert abs(one.wz_radps + other.wz_radps) <= tolerance, (one, other)
