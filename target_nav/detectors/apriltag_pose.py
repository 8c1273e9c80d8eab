"""How a tag stands: the one or two poses of a square that fit its corners.

Both solutions of the planar pose problem (Collins and Bartoli, *Infinitesimal plane-based pose estimation*, IJCV 109,
2014) reproject almost equally well beyond a few metres. Both go to the nav process, which knows how the robot was
turned and so tells them apart (`target_nav.nav.facing`).
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass

import cv2
import numpy as np

from target_nav.config import CameraConfig
from target_nav.state.types import Facing, FloatArray

ROLLS_RAD = (0.1, 0.35, -0.23)
"""The picture is solved as if the camera were rolled by this much: with edges exactly upright, which a wall and a level
camera give, OpenCV 4.6 divides by next to nothing and is off by tens of pixels, or answers NaN. Where one roll does,
the next is tried."""


@dataclass(frozen=True)
class TagPose:
    """One solution: the tag's middle in the camera's frame on the ground (x forward, y left), and where its face looks.

    `facing_rad` is the direction of the tag's outward normal in the camera's frame; pi is straight at the camera.
    """

    x_m: float
    y_m: float
    facing_rad: float
    error_px: float


def tag_poses(corners_px: FloatArray, side_m: float, camera: CameraConfig) -> tuple[TagPose, ...]:
    """The one or two poses that fit the corners, shape (4, 2) as `TagCorners` has them, the better fitting first."""
    h = 0.5 * side_m
    points = np.array([(-h, h, 0.0), (h, h, 0.0), (h, -h, 0.0), (-h, -h, 0.0)])
    middle = np.array([camera.center_u_px, camera.center_v_px])
    # Upright pixels in units of sideways ones, so that the roll is a rotation.
    square_px = (corners_px - middle) * np.array([1.0, 1.0 / camera.pixel_aspect])
    found: list[TagPose] = []
    for roll_rad in ROLLS_RAD:
        found = [pose for pose in _solved(points, square_px, camera.focal_px, roll_rad) if _is_finite(pose)]
        if found:
            break
    return tuple(sorted(found, key=lambda pose: pose.error_px))


def _solved(
    points_m: FloatArray, square_px: FloatArray, focal_px: float, roll_rad: float
) -> Iterator[TagPose]:
    c, s = math.cos(roll_rad), math.sin(roll_rad)
    roll = np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])
    turned = square_px @ roll[:2, :2].T
    matrix = np.diag([focal_px, focal_px, 1.0])
    result = cv2.solvePnPGeneric(
        points_m, turned.reshape(4, 1, 2), matrix, np.zeros(4), flags=cv2.SOLVEPNP_IPPE_SQUARE
    )
    # The number of solutions comes first in every generation, then rotations, translations, errors.
    _, rotations, translations, errors = result[:4]
    for rotation, translation, error in zip(rotations, translations, np.asarray(errors).ravel()):
        turn = roll.T @ cv2.Rodrigues(rotation)[0]
        right, _, forward = (float(value) for value in roll.T @ np.asarray(translation).ravel())
        # The outward normal is the tag's +z axis; the camera's x is right, its z forward.
        normal = turn[:, 2]
        yield TagPose(forward, -right, math.atan2(-float(normal[0]), float(normal[2])), float(error))


def _is_finite(pose: TagPose) -> bool:
    return all(map(math.isfinite, (pose.x_m, pose.y_m, pose.facing_rad, pose.error_px)))


def tag_facings(corners_px: FloatArray, camera: CameraConfig) -> tuple[Facing, ...]:
    """Where its face looks by the one or two poses that fit, the better fitting first; its size does not matter."""
    return tuple(Facing(pose.facing_rad, pose.error_px) for pose in tag_poses(corners_px, 1.0, camera)[:2])
