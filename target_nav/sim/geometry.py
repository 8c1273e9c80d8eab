"""Exact distances from the robot's footprint, a rectangle, to points and segments; in plain floats, which are fast."""

from __future__ import annotations

import math


def point_to_rectangle(px: float, py: float, half_x: float, half_y: float) -> float:
    """From a point to the rectangle [-half_x, half_x] x [-half_y, half_y]; 0 inside."""
    dx = abs(px) - half_x
    dy = abs(py) - half_y
    if dx <= 0.0:
        return dy if dy > 0.0 else 0.0
    return dx if dy <= 0.0 else math.sqrt(dx * dx + dy * dy)


def point_to_segment(px: float, py: float, ax: float, ay: float, bx: float, by: float) -> float:
    ex, ey = bx - ax, by - ay
    length2 = ex * ex + ey * ey
    along = ((px - ax) * ex + (py - ay) * ey) / length2 if length2 > 0.0 else 0.0
    along = 0.0 if along < 0.0 else 1.0 if along > 1.0 else along
    return math.hypot(px - ax - along * ex, py - ay - along * ey)


def segment_meets_rectangle(ax: float, ay: float, bx: float, by: float, half_x: float, half_y: float) -> bool:
    """Liang and Barsky's clipping (ACM TOG 3(1), 1984): is any of the segment in the rectangle round the origin?"""
    enter, leave = 0.0, 1.0
    for start, step, half in ((ax, bx - ax, half_x), (ay, by - ay, half_y)):
        if step == 0.0:
            if abs(start) > half:
                return False
            continue
        near, far = (-half - start) / step, (half - start) / step
        if near > far:
            near, far = far, near
        enter = near if near > enter else enter
        leave = far if far < leave else leave
        if enter > leave:
            return False
    return True


def segment_to_rectangle(ax: float, ay: float, bx: float, by: float, half_x: float, half_y: float) -> float:
    """From a segment to the rectangle round the origin; 0 when they meet.

    Two convex polygons that do not meet are nearest to each other at a corner of one of them.
    """
    if segment_meets_rectangle(ax, ay, bx, by, half_x, half_y):
        return 0.0
    return min(
        point_to_rectangle(ax, ay, half_x, half_y),
        point_to_rectangle(bx, by, half_x, half_y),
        point_to_segment(half_x, half_y, ax, ay, bx, by),
        point_to_segment(half_x, -half_y, ax, ay, bx, by),
        point_to_segment(-half_x, half_y, ax, ay, bx, by),
        point_to_segment(-half_x, -half_y, ax, ay, bx, by),
    )


def box_corners(
    x_m: float, y_m: float, length_m: float, width_m: float, yaw_rad: float
) -> tuple[tuple[float, float], ...]:
    """The four corners of a box, counter-clockwise."""
    c, s = math.cos(yaw_rad), math.sin(yaw_rad)
    hx, hy = 0.5 * length_m, 0.5 * width_m
    return tuple(
        (x_m + c * u - s * v, y_m + s * u + c * v) for u, v in ((hx, hy), (-hx, hy), (-hx, -hy), (hx, -hy))
    )
