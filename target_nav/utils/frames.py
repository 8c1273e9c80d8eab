"""Poses and points in the plane: composition, inversion, angles. The names follow `parent_T_child` thinking in words.

A pose `base_in_odom` maps points in base to points in odom.
"""

from __future__ import annotations

import math

import numpy as np

from target_nav.state.types import FloatArray, Pose2D


def wrap_angle(angle_rad: float) -> float:
    """The same direction in [-pi, pi]."""
    return math.remainder(angle_rad, 2.0 * math.pi)


def compose(outer: Pose2D, inner: Pose2D) -> Pose2D:
    """The pose `inner`, given in the frame of `outer`, in the frame that `outer` is given in."""
    c, s = math.cos(outer.yaw_rad), math.sin(outer.yaw_rad)
    return Pose2D(
        outer.x_m + c * inner.x_m - s * inner.y_m,
        outer.y_m + s * inner.x_m + c * inner.y_m,
        wrap_angle(outer.yaw_rad + inner.yaw_rad),
    )


def inverse(pose: Pose2D) -> Pose2D:
    c, s = math.cos(pose.yaw_rad), math.sin(pose.yaw_rad)
    return Pose2D(-c * pose.x_m - s * pose.y_m, s * pose.x_m - c * pose.y_m, -pose.yaw_rad)


def relative(pose: Pose2D, reference: Pose2D) -> Pose2D:
    """`pose` as seen from `reference`, both given in the same frame."""
    return compose(inverse(reference), pose)


def to_parent(pose: Pose2D, x_m: float, y_m: float) -> tuple[float, float]:
    """A point in the frame of `pose`, in the frame that `pose` is given in."""
    c, s = math.cos(pose.yaw_rad), math.sin(pose.yaw_rad)
    return pose.x_m + c * x_m - s * y_m, pose.y_m + s * x_m + c * y_m


def to_child(pose: Pose2D, x_m: float, y_m: float) -> tuple[float, float]:
    """A point in the frame that `pose` is given in, in the frame of `pose`."""
    c, s = math.cos(pose.yaw_rad), math.sin(pose.yaw_rad)
    dx, dy = x_m - pose.x_m, y_m - pose.y_m
    return c * dx + s * dy, -s * dx + c * dy


def points_to_parent(pose: Pose2D, points_m: FloatArray) -> FloatArray:
    """`to_parent` for points of shape (N, 2)."""
    c, s = math.cos(pose.yaw_rad), math.sin(pose.yaw_rad)
    return points_m @ np.array([[c, s], [-s, c]]) + np.array([pose.x_m, pose.y_m])


def points_to_child(pose: Pose2D, points_m: FloatArray) -> FloatArray:
    """`to_child` for points of shape (N, 2)."""
    c, s = math.cos(pose.yaw_rad), math.sin(pose.yaw_rad)
    return (points_m - np.array([pose.x_m, pose.y_m])) @ np.array([[c, -s], [s, c]])


def interpolate(first: Pose2D, second: Pose2D, fraction: float) -> Pose2D:
    """Straight line between two poses, the shorter way round in yaw; `fraction` 0 is `first`."""
    return Pose2D(
        first.x_m + fraction * (second.x_m - first.x_m),
        first.y_m + fraction * (second.y_m - first.y_m),
        wrap_angle(first.yaw_rad + fraction * wrap_angle(second.yaw_rad - first.yaw_rad)),
    )
