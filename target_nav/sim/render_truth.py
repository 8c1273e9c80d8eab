"""Where the things of a rendered picture really are: for training and for judging detectors, never for the robot."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from target_nav.sim.render_canvas import NEAR_M, Canvas, View
from target_nav.sim.render_revolved import Revolved, paint_revolved
from target_nav.state.types import FloatArray


@dataclass(frozen=True)
class TrueBox:
    """A thing's outline in picture coordinates; it may reach beyond the borders.

    `visible` is the share of its pixels in the picture that nothing hides, `in_picture` the share of all its pixels
    that lie within the borders. `range_m` is on the ground, from the camera to the axis.
    """

    class_name: str
    left_px: float
    top_px: float
    right_px: float
    bottom_px: float
    visible: float
    in_picture: float
    range_m: float
    bearing_rad: float


def true_box(
    class_name: str, body: Revolved, x_m: float, y_m: float, view: View, drawn: Canvas, scratch: Canvas
) -> TrueBox | None:
    """Of a body that stands at (x_m, y_m) of the world in the picture just `drawn`; None outside of it or behind."""
    x, y = (float(value) for value in view.to_camera(np.array([[x_m, y_m]]))[0])
    range_m, bearing_rad = math.hypot(x, y), math.atan2(y, x)
    if range_m - body.max_radius_m <= NEAR_M or abs(bearing_rad) > 0.5 * math.pi - 0.2:
        return None
    half_rad = math.asin(body.max_radius_m / range_m)
    heights_m = np.linspace(0.0, body.height_m, body.radii_m.size)
    # The nearest point of every ring is the one that lies farthest from the horizon.
    nearest_m: FloatArray = np.asarray((range_m - body.radii_m) * math.cos(bearing_rad), np.float64)
    rows = drawn.row_of(heights_m, nearest_m)
    scratch.depth_m.fill(np.inf)
    paint_revolved(body, x_m, y_m, view, scratch)
    mask = np.isfinite(scratch.depth_m)
    inside = int(np.count_nonzero(mask))
    if inside == 0:
        return None
    seen = int(np.count_nonzero(mask & (drawn.depth_m == scratch.depth_m)))
    scale = view.focal_px / x
    whole = 2.0 * scale**2 * float(body.radii_m.mean()) * body.height_m / math.cos(bearing_rad)
    return TrueBox(
        class_name,
        view.center_u_px - view.focal_px * math.tan(min(bearing_rad + half_rad, 1.5)),
        float(rows.min()),
        view.center_u_px - view.focal_px * math.tan(max(bearing_rad - half_rad, -1.5)),
        float(rows.max()),
        seen / inside,
        min(inside / whole, 1.0),
        range_m,
        bearing_rad,
    )
