"""Pins and bottles: surfaces of revolution, met by one ray per pixel.

For every pixel the ray passes the axis at a distance b on the ground; where the profile's radius at the height of the
ray is larger than b, the pixel sees the body. The height is that of the point of entry, which two steps of fixed-point
iteration find to a fraction of a pixel. Edges are blended by the share of the pixel they cover.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from target_nav.sim.render_canvas import NEAR_M, Canvas, View
from target_nav.sim.render_surfaces import LIGHT_AZIMUTH_RAD
from target_nav.state.types import FloatArray
from target_nav.utils import bowling_pin

Float32Array = NDArray[np.float32]
TABLE_STEPS = 1024
NORMAL_SMOOTHING_STEPS = 101
ENTRY_STEPS = 2
AMBIENT = 0.60
DIFFUSE = 0.36
FROM_ABOVE = 0.12
LIGHT_ELEVATION_RAD = math.radians(35.0)
SHADOW_RADII = 1.9
SHADOW_DEPTH = 0.55
MARGIN_PX = 2

BANDS = ((0.36, 0.28),)
"""Where a thing with one band has it: centre and thickness, shares of its height."""

PROFILES: dict[str, tuple[FloatArray, FloatArray]] = {
    "bowling_pin": (bowling_pin.PROFILE_HEIGHTS, bowling_pin.PROFILE_WIDTHS),
    "bottle": (np.array([0.0, 0.03, 0.58, 0.74, 0.97, 1.0]), np.array([0.92, 1.0, 1.0, 0.38, 0.36, 0.30])),
    "cup": (np.array([0.0, 1.0]), np.array([0.72, 1.0])),
    "vase": (np.array([0.0, 0.35, 0.75, 0.85, 1.0]), np.array([0.55, 1.0, 0.55, 0.5, 0.7])),
    "ball": (
        np.linspace(0.0, 1.0, 41),
        2.0 * np.sqrt(np.linspace(0.0, 1.0, 41) * (1.0 - np.linspace(0.0, 1.0, 41))),
    ),
    "cone": (np.array([0.0, 0.06, 0.061, 1.0]), np.array([1.0, 1.0, 0.72, 0.1])),
}
"""Height and width shares. A class that is not here is an upright cylinder."""
CYLINDER = (np.array([0.0, 1.0]), np.array([1.0, 1.0]))


@dataclass(frozen=True, eq=False)
class Revolved:
    """Radius (m), colour (BGR) and the surface's normal at `TABLE_STEPS` heights from the floor to `height_m`.

    `flat` and `up` are the normal's level and upright parts.
    """

    height_m: float
    radii_m: Float32Array
    colours_bgr: Float32Array
    flat: Float32Array
    up: Float32Array

    @property
    def max_radius_m(self) -> float:
        return float(self.radii_m.max())


def body_of(
    class_name: str,
    height_m: float,
    radius_m: float,
    body_bgr: tuple[float, float, float],
    band_bgr: tuple[float, float, float] | None,
) -> Revolved:
    """A thing by its class's profile; a pin has its band twice, round the neck."""
    share = np.linspace(0.0, 1.0, TABLE_STEPS)
    heights, widths = PROFILES.get(class_name, CYLINDER)
    colours = np.tile(np.array(body_bgr), (TABLE_STEPS, 1))
    if band_bgr is not None:
        for center, thickness in bowling_pin.STRIPES if class_name == bowling_pin.CLASS_NAME else BANDS:
            colours[np.abs(share - center) <= 0.5 * thickness] = band_bgr
    return revolved_from(heights, widths, colours, height_m, radius_m)


def revolved_from(
    heights: FloatArray, widths: FloatArray, colours_bgr: FloatArray, height_m: float, radius_m: float
) -> Revolved:
    """A body of any profile: widths (of the largest) at heights (of its own), colours (n, 3) from floor to top."""
    share = np.linspace(0.0, 1.0, TABLE_STEPS)
    radii_m = radius_m * np.interp(share, heights, widths)
    at = np.linspace(0, len(colours_bgr) - 1, TABLE_STEPS).round().astype(int)
    # The profile is given by few points: without smoothing, shading would show its corners.
    kernel = np.hanning(NORMAL_SMOOTHING_STEPS)
    slope = np.convolve(
        np.pad(np.gradient(radii_m, height_m / (TABLE_STEPS - 1)), NORMAL_SMOOTHING_STEPS // 2, mode="edge"),
        kernel / kernel.sum(),
        mode="valid",
    )
    flat = 1.0 / np.sqrt(1.0 + slope**2)
    tables = (radii_m, colours_bgr[at], flat, -slope * flat)
    return Revolved(height_m, *(table.astype(np.float32) for table in tables))


def paint_revolved(body: Revolved, x_m: float, y_m: float, view: View, canvas: Canvas) -> None:
    """Draw `body` standing at (x_m, y_m) of the world over what is farther away."""
    x, y = view.to_camera(np.array([[x_m, y_m]]))[0]
    distance_m = math.hypot(x, y)
    near_m = distance_m - body.max_radius_m
    if near_m <= NEAR_M:
        return
    columns = _columns(math.atan2(y, x), math.asin(body.max_radius_m / distance_m), view)
    if columns.stop <= columns.start:
        return
    rows = _rows(body.height_m, near_m, distance_m, columns, view, canvas)
    if rows.stop <= rows.start:
        return
    _blend(body, math.atan2(y, x), distance_m, columns, rows, view, canvas)


def _columns(bearing_rad: float, half_rad: float, view: View) -> slice:
    limit = math.radians(85.0)
    left, right = min(bearing_rad + half_rad, limit), max(bearing_rad - half_rad, -limit)
    if left <= right:
        return slice(0, 0)
    first = int(view.center_u_px - view.focal_px * math.tan(left)) - MARGIN_PX
    last = int(view.center_u_px - view.focal_px * math.tan(right)) + MARGIN_PX + 1
    return slice(max(first, 0), min(last, view.slopes.size))


def _rows(height_m: float, near_m: float, far_m: float, columns: slice, view: View, canvas: Canvas) -> slice:
    """Rows that the body can reach, from the nearest and the farthest depth it can have in these columns."""
    cos = np.cos(view.angles_rad[columns])
    depths = np.array([near_m * float(cos.min()), far_m * float(cos.max())])
    top = int(np.min(canvas.row_of(height_m, depths))) - MARGIN_PX
    bottom = int(np.max(canvas.row_of(0.0, depths))) + MARGIN_PX + 1
    return slice(max(top, 0), min(bottom, canvas.depth_m.shape[0]))


def _blend(
    body: Revolved,
    bearing_rad: float,
    distance_m: float,
    columns: slice,
    rows: slice,
    view: View,
    canvas: Canvas,
) -> None:
    off_axis = bearing_rad - view.angles_rad[columns]
    b_m = (distance_m * np.sin(off_axis)).astype(np.float32)
    abeam_m = (distance_m * np.cos(off_axis)).astype(np.float32)
    cos = np.cos(view.angles_rad[columns]).astype(np.float32)
    row_slope = (view.center_v_px - (np.arange(rows.start, rows.stop) + 0.5)) / view.focal_px
    rise = row_slope.astype(np.float32)[:, None] * cos
    radii = body.radii_m
    steps = np.float32((TABLE_STEPS - 1) / body.height_m)

    def index_at(reach_m: Float32Array) -> NDArray[np.int32]:
        height = np.float32(view.height_over_floor_m) + reach_m * rise
        return np.clip(height * steps, 0.0, TABLE_STEPS - 1.0).astype(np.int32)

    b2 = b_m * b_m
    entry_m = np.broadcast_to(abeam_m, rise.shape)
    for _ in range(ENTRY_STEPS):
        radius_m = radii[index_at(entry_m)]
        entry_m = abeam_m - np.sqrt(np.maximum(radius_m * radius_m - b2, 0.0))
    index = index_at(entry_m)
    radius_m = radii[index]
    pixel_m = abeam_m / np.float32(view.focal_px)
    height_m = np.float32(view.height_over_floor_m) + entry_m * rise
    cover = np.clip((radius_m - np.abs(b_m)) / pixel_m + 0.5, 0.0, 1.0)
    cover *= np.clip(height_m / pixel_m + 0.5, 0.0, 1.0)
    cover *= np.clip((body.height_m - height_m) / pixel_m + 0.5, 0.0, 1.0)
    depth = entry_m * cos
    nearest = canvas.depth_m[rows, columns]
    cover *= depth < nearest
    sideways = np.asarray(b_m / np.maximum(radius_m, np.float32(1e-4)), np.float32)
    shade = _shade(body, index, sideways, view.camera_in_world.yaw_rad + bearing_rad)
    colours = np.minimum(body.colours_bgr[index] * shade[:, :, None], 255.0)
    picture = canvas.image_bgr[rows, columns]
    picture[:] = (picture + cover[:, :, None] * (colours - picture)).astype(np.uint8)
    np.copyto(nearest, depth, where=cover > 0.5)


def _shade(
    body: Revolved, index: NDArray[np.int32], sideways: Float32Array, ray_yaw_rad: float
) -> Float32Array:
    """Brightness per pixel: Lambert's law with the light of the window, and a little more from above."""
    flat, up = body.flat[index], body.up[index]
    right = np.clip(sideways, -1.0, 1.0)
    toward = np.sqrt(1.0 - right * right)
    level = math.cos(LIGHT_ELEVATION_RAD)
    light_right = np.float32(level * math.cos(LIGHT_AZIMUTH_RAD - (ray_yaw_rad - math.pi / 2)))
    light_toward = np.float32(level * math.cos(LIGHT_AZIMUTH_RAD - (ray_yaw_rad + math.pi)))
    lambert = flat * (right * light_right + toward * light_toward) + up * np.float32(
        math.sin(LIGHT_ELEVATION_RAD)
    )
    return AMBIENT + DIFFUSE * np.maximum(lambert, 0.0) + FROM_ABOVE * np.maximum(up, 0.0)


def paint_shadow(radius_m: float, x_m: float, y_m: float, view: View, canvas: Canvas) -> None:
    """The soft dark spot on the floor round the foot of a body; to be painted before anything upright."""
    x, y = view.to_camera(np.array([[x_m, y_m]]))[0]
    reach_m = SHADOW_RADII * radius_m
    if x - reach_m <= NEAR_M:
        return
    left = int(
        view.center_u_px - view.focal_px * (y + reach_m) / (x - reach_m * math.copysign(1.0, y + reach_m))
    )
    right = (
        int(
            view.center_u_px - view.focal_px * (y - reach_m) / (x + reach_m * math.copysign(1.0, y - reach_m))
        )
        + 1
    )
    top = int(canvas.row_of(0.0, np.array(x + reach_m)))
    bottom = int(canvas.row_of(0.0, np.array(x - reach_m))) + 1
    rows, columns = (
        slice(max(top, 0), min(bottom, canvas.depth_m.shape[0])),
        slice(max(left, 0), max(right, 0)),
    )
    picture = canvas.image_bgr[rows, columns]
    if picture.size == 0:
        return
    row_middle = np.arange(rows.start, rows.start + picture.shape[0]) + 0.5 - view.center_v_px
    depth = (view.focal_px * view.height_over_floor_m / np.maximum(row_middle, 0.25))[:, None]
    side = depth * view.slopes[columns][None, : picture.shape[1]]
    off2 = ((depth - x) ** 2 + (side - y) ** 2) / reach_m**2
    darken = 1.0 - SHADOW_DEPTH * np.clip(1.0 - off2, 0.0, 1.0)
    picture[:] = (picture * darken[:, :, None].astype(np.float32)).astype(np.uint8)
