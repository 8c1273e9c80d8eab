"""The little geometry that pictures need: an ellipse of a covariance, points of one pose seen from another."""

from __future__ import annotations

import math
from dataclasses import dataclass

from target_nav.state.types import FloatArray, Pose2D, Track
from target_nav.utils.frames import points_to_child, points_to_parent

SIGMAS_95 = math.sqrt(5.991)
"""Radius in sigmas that holds 95 % of a two-dimensional normal distribution (chi-square, two degrees of freedom)."""


@dataclass(frozen=True)
class Ellipse:
    """Where something is with 95 % probability. `angle_rad` is the direction of the longer half-axis."""

    x_m: float
    y_m: float
    major_m: float
    minor_m: float
    angle_rad: float


def ellipse_of(track: Track) -> Ellipse:
    """The track's ellipse in odom, by the eigenvalues of its covariance."""
    xx, xy, _, yy = track.covariance_m2
    mean, spread = 0.5 * (xx + yy), math.hypot(0.5 * (xx - yy), xy)
    angle = 0.5 * math.atan2(2.0 * xy, xx - yy)
    return Ellipse(
        track.x_m,
        track.y_m,
        SIGMAS_95 * math.sqrt(max(mean + spread, 0.0)),
        SIGMAS_95 * math.sqrt(max(mean - spread, 0.0)),
        angle,
    )


def seen_from(points_m: FloatArray, then: Pose2D, now: Pose2D) -> FloatArray:
    """Points taken in base_link at the pose `then`, in base_link at the pose `now`; shape (N, 2) both."""
    if then == now or len(points_m) == 0:
        return points_m
    return points_to_child(now, points_to_parent(then, points_m))
