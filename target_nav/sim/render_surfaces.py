"""Where the rays of the columns meet walls, boxes and cylinders, and how bright these are there."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from target_nav.sim.render_canvas import NEAR_M, Canvas, View
from target_nav.sim.render_skin import Skin
from target_nav.state.types import FloatArray

LIGHT_AZIMUTH_RAD = math.radians(130.0)
"""Direction to the window, in the world."""
AMBIENT = 0.72
DIFFUSE = 0.28
SKIRTING_M = 0.07
SKIRTING_SHADE = 0.55


@dataclass(frozen=True)
class Facet:
    """An upright rectangle over the segment from (x1, y1) to (x2, y2) of the world."""

    x1_m: float
    y1_m: float
    x2_m: float
    y2_m: float
    height_m: float
    colour_bgr: tuple[float, float, float]
    skirting: bool = False


@dataclass(frozen=True)
class Cylinder:
    x_m: float
    y_m: float
    radius_m: float
    height_m: float
    colour_bgr: tuple[float, float, float]


def brightness(normal_angle_rad: FloatArray | float) -> FloatArray:
    """Lambert's law for an upright surface whose normal points to that direction of the world."""
    return AMBIENT + DIFFUSE * np.maximum(np.cos(np.asarray(normal_angle_rad) - LIGHT_AZIMUTH_RAD), 0.0)


class FacetSet:
    """All facets of one height, tried against all columns at once; the nearest in each column is painted.

    Facets of one height that hide each other differ in depth alone, so the nearest covers the others entirely.
    """

    def __init__(self, facets: list[Facet], things_per_m: float = 0.0, seed: int = 0) -> None:
        """`things_per_m` pictures, doors and prints on each metre, drawn from `seed`."""
        self._height_m = facets[0].height_m
        self._ends_m = np.array([[(f.x1_m, f.y1_m), (f.x2_m, f.y2_m)] for f in facets])
        along = self._ends_m[:, 1] - self._ends_m[:, 0]
        self._lengths_m = np.hypot(along[:, 0], along[:, 1])
        normals_rad = np.arctan2(along[:, 0], -along[:, 1])
        self._skin = Skin(
            [float(length) for length in self._lengths_m],
            self._height_m,
            [facet.colour_bgr for facet in facets],
            np.stack([brightness(normals_rad), brightness(normals_rad + np.pi)], axis=1),
            [SKIRTING_M if facet.skirting else 0.0 for facet in facets],
            things_per_m,
            seed,
            SKIRTING_SHADE,
        )

    def paint(self, view: View, canvas: Canvas) -> None:
        ends = view.to_camera(self._ends_m.reshape(-1, 2)).reshape(-1, 2, 2)
        start, along = ends[:, 0], ends[:, 1] - ends[:, 0]
        depth, share = _meet(start, along, view.slopes)
        nearest = np.argmin(depth, axis=0)
        columns = np.arange(depth.shape[1])
        depth_m = depth[nearest, columns]
        # A facet is seen from either side: its normal is turned towards the camera.
        normal_x, normal_y = -along[:, 1], along[:, 0]
        away = normal_x * start[:, 0] + normal_y * start[:, 1] > 0.0
        position_m = np.where(np.isfinite(depth_m), share[nearest, columns], 0.0) * self._lengths_m[nearest]
        begin_px = self._skin.starts_px[nearest, away[nearest].astype(int)]
        scale = self._skin.pixels_per_m
        canvas.paint_texture(
            depth_m, self._height_m, begin_px + position_m * scale, self._skin.image_bgr, scale
        )


def _meet(start: FloatArray, along: FloatArray, slopes: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Depth and share of the segment, each (K, n), at which column rays (t, t * slope) cross segments; inf: never."""
    normal = np.stack([-along[:, 1], along[:, 0]], axis=1)
    offset = np.einsum("ki,ki->k", normal, start)[:, None]
    length2 = np.einsum("ki,ki->k", along, along)[:, None]
    with np.errstate(divide="ignore", invalid="ignore"):
        depth = offset / (normal[:, :1] + normal[:, 1:] * slopes)
        x = depth - start[:, :1]
        y = depth * slopes - start[:, 1:]
        share = (x * along[:, :1] + y * along[:, 1:]) / length2
        outside = ~((share >= 0.0) & (share <= 1.0) & (depth > NEAR_M))
    return np.where(outside, np.inf, depth), share


def paint_cylinder(cylinder: Cylinder, view: View, canvas: Canvas) -> None:
    """The near side: ray and circle on the ground; the camera inside of it sees nothing of it."""
    x, y = view.to_camera(np.array([[cylinder.x_m, cylinder.y_m]]))[0]
    if x <= -cylinder.radius_m or math.hypot(x, y) <= cylinder.radius_m:
        return
    a = 1.0 + view.slopes**2
    half_b = x + y * view.slopes
    discriminant = half_b**2 - a * (x * x + y * y - cylinder.radius_m**2)
    hit = np.flatnonzero(discriminant > 0.0)
    if hit.size == 0:
        return
    columns = slice(int(hit[0]), int(hit[-1]) + 1)
    depth = (half_b[columns] - np.sqrt(np.maximum(discriminant[columns], 0.0))) / a[columns]
    normal_rad = np.arctan2(depth * view.slopes[columns] - y, depth - x) + view.camera_in_world.yaw_rad
    colours = np.array(cylinder.colour_bgr) * brightness(normal_rad)[:, None]
    canvas.paint_columns(
        columns.start, np.where(depth > NEAR_M, depth, np.inf), 0.0, cylinder.height_m, colours
    )
