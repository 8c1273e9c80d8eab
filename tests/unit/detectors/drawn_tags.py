"""Pictures of AprilTags hanging in space, by homography: what a pinhole camera would see."""

from __future__ import annotations

import math
from typing import Any

import cv2
import numpy as np

from target_nav.config import CameraConfig
from target_nav.detectors.detector import ImageBgr

CELLS = 10
"""36h11 is 8 cells wide; one white cell is left round it."""
CELL_PX = 24


def marker(tag_id: int) -> np.ndarray:
    aruco: Any = cv2.aruco
    dictionary = aruco.getPredefinedDictionary(aruco.DICT_APRILTAG_36h11)
    draw = aruco.generateImageMarker if hasattr(aruco, "generateImageMarker") else aruco.drawMarker
    sheet = np.full((CELLS * CELL_PX, CELLS * CELL_PX), 255, np.uint8)
    inner = (CELLS - 2) * CELL_PX
    sheet[CELL_PX : CELL_PX + inner, CELL_PX : CELL_PX + inner] = draw(dictionary, tag_id, inner)
    return sheet


def picture_of_tag(
    camera: CameraConfig,
    tag_id: int,
    side_m: float,
    x_m: float,
    y_m: float,
    facing_rad: float,
    z_m: float = 0.14,
) -> ImageBgr:
    """A tag whose middle is at (x, y, z) in the camera's frame on the ground, its face looking towards `facing_rad`."""
    half = 0.5 * side_m * CELLS / (CELLS - 2)
    # Seen from the front, the tag's right is to the left of its outward normal turned by a quarter.
    right = np.array([-math.sin(facing_rad), math.cos(facing_rad)])
    corners = []
    for across, up in ((-1, 1), (1, 1), (1, -1), (-1, -1)):
        x, y = np.array([x_m, y_m]) + across * half * right
        height = z_m + up * half - camera.z_m
        corners.append(
            (
                0.5 * camera.width_px - camera.focal_px * y / x,
                0.5 * camera.height_px - camera.focal_px * height / x,
            )
        )
    size = CELLS * CELL_PX
    source = np.array([(0, 0), (size, 0), (size, size), (0, size)], np.float32)
    # Twice as large and averaged: edges between pixels come out grey, as in a camera.
    goal = 2.0 * np.array(corners, np.float32)
    shift = np.array([[1, 0, -0.5], [0, 1, -0.5], [0, 0, 1]])
    matrix = shift @ cv2.getPerspectiveTransform(source, goal) @ np.linalg.inv(shift)
    frame = (2 * camera.width_px, 2 * camera.height_px)
    large = cv2.warpPerspective(marker(tag_id), matrix, frame, flags=cv2.INTER_AREA, borderValue=150)
    grey = cv2.GaussianBlur(
        cv2.resize(large, (camera.width_px, camera.height_px), interpolation=cv2.INTER_AREA), (3, 3), 0.6
    )
    return np.asarray(cv2.cvtColor(grey, cv2.COLOR_GRAY2BGR), np.uint8)
