"""Draws an AprilTag on its white plate: the marker by homography, three times as fine as the picture and averaged, so
that edges lie between pixels as in a camera's picture."""

from __future__ import annotations

import math
from typing import Any

import cv2
import numpy as np

from target_nav.config import CameraConfig
from target_nav.errors import ConfigError
from target_nav.sim.arena_types import PlacedObject
from target_nav.sim.objects import TAG_CELLS, TAG_MARGIN_CELLS, tag_number
from target_nav.sim.render_canvas import Canvas, ImageBgr, View
from target_nav.sim.render_surfaces import brightness
from target_nav.sim.tags import project_corners, tag_corners_m, turned_rad
from target_nav.utils.frames import to_child

CELL_PX = 16
FINER = 3
PAPER = 236.0
INK = 26.0
_BEFORE_WALL_M = 0.03
"""It hangs on what is behind it; what is nearer than this by so much hides it."""


class TagPlate:
    def __init__(self, tag: PlacedObject, camera: CameraConfig) -> None:
        """Raises:
        ConfigError: this OpenCV cannot draw markers, or the family has no such tag.
        """
        self._tag, self._camera = tag, camera
        self._corners_m = tag_corners_m(tag, with_margin=True)
        self._sheet = _sheet(tag_number(tag.class_name))

    def paint(self, view: View, canvas: Canvas) -> None:
        """Over what is on the canvas already, where nothing stands before it."""
        tag, pose = self._tag, view.camera_in_world
        if abs(turned_rad(tag, pose)) >= 0.5 * math.pi:
            return
        corners = project_corners(self._corners_m, pose, self._camera, view.focal_px)
        if corners is None:
            return
        rows, columns = canvas.depth_m.shape
        left, top = (max(int(value) - 1, 0) for value in corners.min(axis=0))
        right, bottom = (int(value) + 2 for value in corners.max(axis=0))
        right, bottom = min(right, columns), min(bottom, rows)
        if right <= left or bottom <= top:
            return
        share, grey = self._seen(corners - (left, top), right - left, bottom - top)
        depths = [to_child(pose, x, y)[0] for x, y, _ in self._corners_m.tolist()]
        region = canvas.depth_m[top:bottom, left:right]
        free = region > min(depths) - _BEFORE_WALL_M
        share = np.where(free, share, 0.0)[:, :, None]
        picture = canvas.image_bgr[top:bottom, left:right]
        light = float(brightness(tag.yaw_rad))
        mixed = picture * (1.0 - share) + light * grey[:, :, None] * np.where(free, 1.0, 0.0)[:, :, None]
        picture[:] = np.clip(np.rint(mixed), 0.0, 255.0).astype(np.uint8)

    def _seen(self, corners_px: np.ndarray, width: int, height: int) -> tuple[np.ndarray, np.ndarray]:
        """Share of each pixel that the plate covers, and the plate's grey in it times that share."""
        size = self._sheet.shape[0]
        source = np.array([(0, 0), (size, 0), (size, size), (0, size)], np.float32)
        # Half a pixel: OpenCV counts from the middle of the first one.
        shift = np.array([[1.0, 0.0, -0.5], [0.0, 1.0, -0.5], [0.0, 0.0, 1.0]])
        matrix = (
            shift
            @ cv2.getPerspectiveTransform(source, (FINER * corners_px).astype(np.float32))
            @ np.linalg.inv(shift)
        )
        fine = (FINER * width, FINER * height)
        layers = np.dstack([self._sheet, np.full_like(self._sheet, 255)])
        warped = cv2.warpPerspective(layers, matrix, fine, flags=cv2.INTER_LINEAR, borderValue=0)
        small = cv2.resize(warped, (width, height), interpolation=cv2.INTER_AREA).astype(np.float64)
        return small[:, :, 1] / 255.0, small[:, :, 0]


def _sheet(number: int) -> ImageBgr:
    """The plate from the front, grey."""
    if not hasattr(cv2, "aruco"):
        raise ConfigError(f"OpenCV {cv2.__version__} has no aruco and draws no tags: take 4.7 or later")
    # The functions of 4.6 are unknown to the types of later ones.
    aruco: Any = cv2.aruco
    dictionary = aruco.getPredefinedDictionary(aruco.DICT_APRILTAG_36h11)
    draw = aruco.generateImageMarker if hasattr(aruco, "generateImageMarker") else aruco.drawMarker
    inner, margin = TAG_CELLS * CELL_PX, TAG_MARGIN_CELLS * CELL_PX
    marker = np.asarray(draw(dictionary, number, inner), np.float64) / 255.0
    sheet = np.full((inner + 2 * margin, inner + 2 * margin), PAPER)
    sheet[margin : margin + inner, margin : margin + inner] = INK + (PAPER - INK) * marker
    return np.asarray(np.rint(sheet), np.uint8)
