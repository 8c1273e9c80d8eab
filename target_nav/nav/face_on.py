"""Standing squarely before a face: which spots there are, and how far off square the robot is.

What decides is the direction from the target to the robot, not the robot's heading: the last metre is driven towards
the target, so whoever begins it on the face's normal ends squarely.
"""

from __future__ import annotations

import math

import numpy as np

from target_nav.nav.footprint import Footprint
from target_nav.nav.staging import approach_spots
from target_nav.state.types import FloatArray, Pose2D
from target_nav.utils.frames import to_child, wrap_angle

SQUARE_RAD = 0.02
"""Driven to: 14 mm aside at 0.68 m."""
SQUARE_THERE_RAD = 0.09
"""Enough for who stands on the spot as exactly as the route leads there: it ends in the middle of a 5 cm cell."""
LAST_STRETCH_M = 0.35
"""So near to the spot it goes straight there, if nothing is in the way: more exactly than by the route's cells."""
AT_SPOT_M = 0.015
_NEARER_COST = 2.0
"""The farthest spot that is free is best: an error aside is the smaller angle there."""


def face_spots(
    target_m: tuple[float, float],
    points_m: FloatArray,
    body: Footprint,
    *,
    facing_rad: float,
    stand_off_m: float,
    farthest_m: float,
    margin_m: float,
) -> FloatArray:
    """Spots on the face's normal with a free straight way in, as those of `approach_spots`; may be none."""
    spots = approach_spots(
        target_m,
        points_m,
        body,
        stand_off_m=stand_off_m,
        farthest_m=farthest_m,
        margin_m=margin_m,
        sides_rad=np.array([facing_rad]),
    )
    away_m = np.hypot(spots[:, 0] - target_m[0], spots[:, 1] - target_m[1])
    spots[:, 2] += _NEARER_COST * (farthest_m - away_m)
    return spots


def off_square_rad(pose: Pose2D, target_m: tuple[float, float], facing_rad: float) -> float:
    """From the face's normal to the way to the robot; 0 is straight before it. All in one frame."""
    return wrap_angle(math.atan2(pose.y_m - target_m[1], pose.x_m - target_m[0]) - facing_rad)


def straight_onto(
    pose: Pose2D, spot_m: tuple[float, float], points_in_base_m: FloatArray, body: Footprint, margin_m: float
) -> tuple[float, float] | None:
    """The spot in base_link if it is near and the way there is free, else None."""
    x_m, y_m = to_child(pose, *spot_m)
    way_m = math.hypot(x_m, y_m)
    if way_m > LAST_STRETCH_M:
        return None
    if len(points_in_base_m):
        direction = np.array([math.atan2(y_m, x_m)])
        if float(body.free_distances_m(points_in_base_m, direction, margin_m)[0]) < way_m:
            return None
    return x_m, y_m
