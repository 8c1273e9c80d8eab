"""From where the last metre can be driven: the poses round a target whose straight way in is free.

A box in front of the target, or a wall beside it, leaves only some sides to come from. Avoidance is sent to those,
so that the approach, which looks straight ahead only, never begins where it cannot end.
"""

from __future__ import annotations

import math

import numpy as np

from target_nav.nav.footprint import Footprint
from target_nav.state.types import FloatArray

_SIDES = 64
_RING_STEP_M = 0.05
_TARGET_RADIUS_M = 0.04
"""Of the reference pin; a thicker target only makes the free way a little shorter than it is."""
_ROOM_TO_APPROACH_M = 0.08
"""The approach keeps at least so much way to straighten out in."""


def approach_spots(
    target_m: tuple[float, float],
    points_m: FloatArray,
    body: Footprint,
    *,
    stand_off_m: float,
    farthest_m: float,
    margin_m: float,
    sides_rad: FloatArray | None = None,
) -> FloatArray:
    """Spots with a free straight way to the target, shape (M, 3): x, y, extra cost 0. All in one frame.

    `farthest_m` is base_link to the target's centre at most, `margin_m` is kept free beside the body all the way in.
    `sides_rad`, shape (S,), are directions from the target to look in; default: all round. Empty if no side is free.
    """
    nearest_m = min(body.front_m + stand_off_m + _TARGET_RADIUS_M + _ROOM_TO_APPROACH_M, farthest_m)
    angles = np.arange(_SIDES) * (2.0 * math.pi / _SIDES) if sides_rad is None else sides_rad
    outward_x, outward_y = np.cos(angles), np.sin(angles)
    longest = np.full(len(angles), farthest_m)
    if len(points_m):
        dx, dy = points_m[:, 0] - target_m[0], points_m[:, 1] - target_m[1]
        near = np.hypot(dx, dy) < farthest_m + body.circumscribed_radius_m + margin_m
        dx, dy = dx[near], dy[near]
        out = outward_x[:, None] * dx + outward_y[:, None] * dy
        across = np.abs(outward_x[:, None] * dy - outward_y[:, None] * dx)
        beside = (across < body.half_width_m + margin_m) & (out > stand_off_m + _TARGET_RADIUS_M - margin_m)
        if len(dx):
            met = np.where(beside, out, math.inf).min(axis=1)
            longest = np.minimum(longest, met - body.rear_m - margin_m)
    radii = np.arange(farthest_m, nearest_m - 1e-9, -_RING_STEP_M)
    if len(radii) == 0:
        radii = np.array([farthest_m])
    ring, side = np.nonzero(radii[:, None] <= longest[None, :] + 1e-9)
    x = target_m[0] + radii[ring] * outward_x[side]
    y = target_m[1] + radii[ring] * outward_y[side]
    return np.column_stack([x, y, np.zeros(len(ring))])


def straight_way_clear(
    target_in_base_m: tuple[float, float],
    points_m: FloatArray,
    body: Footprint,
    *,
    stand_off_m: float,
    margin_m: float,
) -> bool:
    """Whether the body, turned to the target, can drive straight up to its stand-off. Points in base_link."""
    if len(points_m) == 0:
        return True
    range_m = math.hypot(*target_in_base_m)
    c, s = target_in_base_m[0] / max(range_m, 1e-9), target_in_base_m[1] / max(range_m, 1e-9)
    along = c * points_m[:, 0] + s * points_m[:, 1]
    across = np.abs(c * points_m[:, 1] - s * points_m[:, 0])
    reach_m = max(range_m - stand_off_m - _TARGET_RADIUS_M + margin_m, body.front_m)
    inside = (along > -body.rear_m) & (along < reach_m) & (across < body.half_width_m + margin_m)
    return not bool(inside.any())


def without_own(points_m: FloatArray, target_m: tuple[float, float], radius_m: float) -> FloatArray:
    """`points_m` but those within `radius_m` of the target: what the tracker has left in of the target itself."""
    if len(points_m) == 0:
        return points_m
    kept: FloatArray = points_m[
        np.hypot(points_m[:, 0] - target_m[0], points_m[:, 1] - target_m[1]) > radius_m
    ]
    return kept
