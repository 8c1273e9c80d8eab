"""The picture being drawn, its depth, and the rays of its columns.

The camera is level, so everything that stands upright is painted column by column: one ray on the ground per column
says how deep a surface is there, and the depth which rows it fills. A depth per pixel keeps what is nearer.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from target_nav.config import CameraConfig
from target_nav.state.types import FloatArray, Pose2D

ImageBgr = NDArray[np.uint8]
NEAR_M = 0.02
"""Nothing nearer than this is drawn."""


@dataclass(frozen=True, eq=False)
class View:
    """Where the camera stands, and the rays on the ground through the middles of its columns.

    At depth `t` along the optical axis, column i sees the point (t, t * slopes[i]) of the camera's frame.
    """

    camera_in_world: Pose2D
    slopes: FloatArray
    angles_rad: FloatArray
    focal_px: float
    center_u_px: float
    center_v_px: float
    height_over_floor_m: float

    def to_camera(self, points_in_world_m: FloatArray) -> FloatArray:
        """Points of shape (N, 2) in the camera's frame."""
        pose = self.camera_in_world
        c, s = math.cos(pose.yaw_rad), math.sin(pose.yaw_rad)
        return (points_in_world_m - np.array([pose.x_m, pose.y_m])) @ np.array([[c, -s], [s, c]])


class Canvas:
    """`image_bgr` (height, width, 3) and `depth_m` (height, width), inf where there is only floor and ceiling."""

    def __init__(self, camera: CameraConfig) -> None:
        shape = (camera.height_px, camera.width_px)
        self.image_bgr: ImageBgr = np.zeros((*shape, 3), np.uint8)
        self.depth_m = np.full(shape, np.inf, np.float32)
        self._camera = camera
        columns = np.arange(camera.width_px) + 0.5
        self._slopes: FloatArray = np.asarray((0.5 * camera.width_px - columns) / camera.focal_px, np.float64)
        self._angles_rad = np.arctan(self._slopes)
        self._rows = np.arange(camera.height_px, dtype=np.float32)[:, None] + 0.5

    def view_from(self, camera_in_world: Pose2D) -> View:
        camera = self._camera
        return View(
            camera_in_world,
            self._slopes,
            self._angles_rad,
            camera.focal_px,
            0.5 * camera.width_px,
            0.5 * camera.height_px,
            camera.z_m,
        )

    def row_of(self, height_m: float | FloatArray, depth_m: FloatArray) -> FloatArray:
        """The picture's row (continuous) of a height over the floor at given depths."""
        camera = self._camera
        return 0.5 * camera.height_px - camera.focal_px * (height_m - camera.z_m) / depth_m

    def paint_columns(
        self, first: int, depth_m: FloatArray, bottom_m: float, top_m: float, colours_bgr: FloatArray
    ) -> None:
        """Upright surfaces that begin at column `first`: depth (n,), inf where there is none, colours (n, 3)."""
        span = self._span(first, depth_m, bottom_m, top_m)
        if span is None:
            return
        start, stop, row0, columns, mask = span
        colours = np.clip(colours_bgr[start:stop], 0.0, 255.0).astype(np.uint8)
        np.copyto(self.image_bgr[row0 : row0 + len(mask), columns], colours, where=mask[:, :, None])

    def paint_texture(
        self,
        depth_m: FloatArray,
        top_m: float,
        along_px: FloatArray,
        texture_bgr: ImageBgr,
        pixels_per_m: float,
    ) -> None:
        """Upright surfaces from the floor to `top_m`, in all columns: depth (n,), inf where there is none.

        `texture_bgr` is as high as they are; column i shows its column `along_px[i]`.
        """
        span = self._span(0, depth_m, 0.0, top_m)
        if span is None:
            return
        start, stop, row0, columns, mask = span
        camera = self._camera
        depth = np.where(np.isfinite(depth_m[start:stop]), depth_m[start:stop], 0.0)
        # height = z + (v0 - row) * depth / focal, and the texture counts down from its top
        per_row = (depth * (pixels_per_m / camera.focal_px)).astype(np.float32)
        at_horizon = np.float32((top_m - camera.z_m) * pixels_per_m - 0.5)
        rows = self._rows[row0 : row0 + len(mask)] - np.float32(0.5 * camera.height_px)
        map_y = np.clip(at_horizon + rows * per_row, 0.0, len(texture_bgr) - 1.0)
        map_x = np.broadcast_to((along_px[start:stop] - 0.5).astype(np.float32), map_y.shape)
        seen = cv2.remap(
            texture_bgr, np.ascontiguousarray(map_x), map_y, cv2.INTER_LINEAR, borderMode=cv2.BORDER_REPLICATE
        )
        np.copyto(self.image_bgr[row0 : row0 + len(mask), columns], seen, where=mask[:, :, None])

    def _span(
        self, first: int, depth_m: FloatArray, bottom_m: float, top_m: float
    ) -> tuple[int, int, int, slice, NDArray[np.bool_]] | None:
        """Stores the depth. First and last hit, first row, columns of the picture, which pixels are to be painted."""
        hit = np.flatnonzero(np.isfinite(depth_m))
        if hit.size == 0:
            return None
        start, stop = int(hit[0]), int(hit[-1]) + 1
        depth = depth_m[start:stop]
        with np.errstate(invalid="ignore"):
            top = self.row_of(top_m, depth)
            bottom = self.row_of(bottom_m, depth)
        seen = np.isfinite(depth)
        row0 = max(int(np.min(top[seen])), 0)
        row1 = min(int(np.max(bottom[seen])) + 1, self._camera.height_px)
        if row1 <= row0:
            return None
        columns = slice(first + start, first + stop)
        rows = self._rows[row0:row1]
        depth32 = depth.astype(np.float32)
        nearest = self.depth_m[row0:row1, columns]
        mask = (rows >= top.astype(np.float32)) & (rows < bottom.astype(np.float32)) & (depth32 < nearest)
        np.copyto(nearest, depth32, where=mask)
        return start, stop, row0, columns, mask
