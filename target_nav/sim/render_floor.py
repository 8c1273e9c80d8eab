"""The floor: a tiled texture in world coordinates, brought into the picture by one homography."""

from __future__ import annotations

import math

import cv2
import numpy as np

from target_nav.sim.render_canvas import ImageBgr, View
from target_nav.sim.render_look import Look
from target_nav.state.types import FloatArray

TILE_M = 0.5
JOINT_M = 0.012
PIXELS_PER_M = 120.0
MAX_TEXTURE_PX = 2400
BOARD_M = 0.12
BOARD_SIGMA = 9.0
JOINT_DARKER = 26.0
MOTTLE_SIGMA = 7.0
BLEND_FROM_M = 1.2
BLEND_TO_M = 3.5
"""Where a row covers more floor than the texture's details: they fade into the mean, or they would flicker."""
TEXTURE_SEED = 7


class Floor:
    """Covers the rectangle `bounds` (x0, y0, x1, y1); beyond it its border is repeated."""

    def __init__(self, bounds: tuple[float, float, float, float], look: Look | None = None) -> None:
        x0, y0, x1, y1 = bounds
        scale = min(PIXELS_PER_M, MAX_TEXTURE_PX / max(x1 - x0, y1 - y0))
        look = look or Look()
        self._mean_bgr = np.array(look.floor_bgr, np.float32)
        self._texture = _texture(x1 - x0, y1 - y0, scale, look)
        self._world_to_texture = np.array(
            [[scale, 0.0, -x0 * scale], [0.0, scale, -y0 * scale], [0.0, 0.0, 1.0]]
        )

    def draw(self, view: View, image_bgr: ImageBgr) -> None:
        """Every row under the horizon."""
        first = math.ceil(view.center_v_px)
        rows, columns = image_bgr.shape[0] - first, image_bgr.shape[1]
        depth_m = (
            view.focal_px
            * view.height_over_floor_m
            / (np.arange(first, first + rows) + 0.5 - view.center_v_px)
        )
        into_texture = self._world_to_texture @ _picture_to_world(view, first)
        floor = cv2.warpPerspective(
            self._texture,
            into_texture,
            (columns, rows),
            flags=cv2.INTER_LINEAR | cv2.WARP_INVERSE_MAP,
            borderMode=cv2.BORDER_REPLICATE,
        )
        fade = np.clip((depth_m - BLEND_FROM_M) / (BLEND_TO_M - BLEND_FROM_M), 0.0, 1.0).astype(np.float32)
        far = int(np.count_nonzero(fade))
        weight = fade[:far, None, None]
        floor[:far] = (floor[:far] * (1.0 - weight) + self._mean_bgr * weight).astype(np.uint8)
        image_bgr[first:] = floor


def _picture_to_world(view: View, first_row: int) -> FloatArray:
    """Homography from pixel (column, row - first_row) to the floor in world coordinates.

    A floor point at depth X lies in row v = center + f * h / X, so X : Y : 1 = f h : (center_u - u) h : (v - center_v).
    """
    f, h = view.focal_px, view.height_over_floor_m
    to_camera = np.array(
        [
            [0.0, 0.0, f * h],
            [-h, 0.0, (view.center_u_px - 0.5) * h],
            [0.0, 1.0, first_row + 0.5 - view.center_v_px],
        ]
    )
    pose = view.camera_in_world
    c, s = math.cos(pose.yaw_rad), math.sin(pose.yaw_rad)
    return np.array([[c, -s, pose.x_m], [s, c, pose.y_m], [0.0, 0.0, 1.0]]) @ to_camera


def _texture(width_m: float, height_m: float, scale: float, look: Look) -> ImageBgr:
    rng = np.random.default_rng(TEXTURE_SEED + look.seed)
    rows, columns = max(int(height_m * scale), 2), max(int(width_m * scale), 2)
    coarse = rng.normal(0.0, 1.0, (max(rows // 12, 2), max(columns // 12, 2))).astype(np.float32)
    fine = rng.normal(0.0, 0.4, (rows, columns)).astype(np.float32)
    light = MOTTLE_SIGMA * (cv2.resize(coarse, (columns, rows), interpolation=cv2.INTER_CUBIC) + fine)
    x_m, y_m = np.arange(columns) / scale, np.arange(rows) / scale
    if look.floor == "tiles":
        joint = (np.mod(x_m, TILE_M) < JOINT_M)[None, :] | (np.mod(y_m, TILE_M) < JOINT_M)[:, None]
        light -= JOINT_DARKER * joint
    elif look.floor == "boards":
        board = (y_m / BOARD_M).astype(int)
        light += rng.normal(0.0, BOARD_SIGMA, board.max() + 1).astype(np.float32)[board][:, None]
        light -= 0.6 * JOINT_DARKER * (np.mod(y_m, BOARD_M) < 0.5 * JOINT_M)[:, None]
    texture = np.array(look.floor_bgr, np.float32) + light[:, :, None]
    return np.clip(texture, 0.0, 255.0).astype(np.uint8)
