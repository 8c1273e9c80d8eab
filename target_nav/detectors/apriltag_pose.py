"""How a tag stands: a square seen from afar has two poses that fit, and the robot's own heading tells which is true.

Both solutions of the planar pose problem (Collins and Bartoli, *Infinitesimal plane-based pose estimation*, IJCV 109,
2014) reproject almost equally well beyond a few metres. A tag that hangs on a wall keeps its direction in odom while
the robot turns and drives; of the two, only the true one does so.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import cv2
import numpy as np

from target_nav.config import CameraConfig
from target_nav.detectors.apriltag import TagCorners
from target_nav.state.types import FloatArray
from target_nav.utils.frames import wrap_angle

FORGET = 0.98
"""A frame: what was seen fifty frames ago counts for a third."""
MIN_ERROR_PX = 0.1
KEEP_MAX = 60
ROLL_RAD = 0.1
_ROLL = np.array(
    [
        [math.cos(ROLL_RAD), -math.sin(ROLL_RAD), 0.0],
        [math.sin(ROLL_RAD), math.cos(ROLL_RAD), 0.0],
        [0.0, 0.0, 1.0],
    ]
)
"""The picture is solved as if the camera were rolled by this much: with edges exactly upright, which a wall and a level
camera give, OpenCV 4.6 divides by next to nothing and is off by tens of pixels."""


@dataclass(frozen=True)
class TagPose:
    """One solution: the tag's middle in the camera's frame on the ground (x forward, y left), and where its face looks.

    `facing_rad` is the direction of the tag's outward normal in the camera's frame; pi is straight at the camera.
    """

    x_m: float
    y_m: float
    facing_rad: float
    error_px: float


def tag_poses(tag: TagCorners, side_m: float, camera: CameraConfig) -> tuple[TagPose, ...]:
    """The one or two poses that fit the corners, the better fitting first."""
    h = 0.5 * side_m
    points = np.array([(-h, h, 0.0), (h, h, 0.0), (h, -h, 0.0), (-h, -h, 0.0)])
    middle = np.array([0.5 * camera.width_px, 0.5 * camera.height_px])
    turned = (tag.corners_px - middle) @ _ROLL[:2, :2].T
    matrix = np.diag([camera.focal_px, camera.focal_px, 1.0])
    result = cv2.solvePnPGeneric(
        points, turned.reshape(4, 1, 2), matrix, np.zeros(4), flags=cv2.SOLVEPNP_IPPE_SQUARE
    )
    # The number of solutions comes first in every generation, then rotations, translations, errors.
    _, rotations, translations, errors = result[:4]
    found = []
    for rotation, translation, error in zip(rotations, translations, np.asarray(errors).ravel()):
        turn = _ROLL.T @ cv2.Rodrigues(rotation)[0]
        right, _, forward = (float(value) for value in _ROLL.T @ np.asarray(translation).ravel())
        # The outward normal is the tag's +z axis; the camera's x is right, its z forward.
        normal = turn[:, 2]
        found.append(TagPose(forward, -right, math.atan2(-float(normal[0]), float(normal[2])), float(error)))
    return tuple(sorted(found, key=lambda pose: pose.error_px))


class TagFacing:
    """Where one tag's face looks in odom, from all frames so far. `add` once a frame."""

    def __init__(self, sigma_rad: float = 0.12) -> None:
        self._sigma_rad = sigma_rad
        self._seen: list[tuple[float, float]] = []

    def add(self, poses: tuple[TagPose, ...], camera_yaw_in_odom_rad: float) -> TagPose | None:
        """The solution that agrees best with what was seen before; None if there is none."""
        if not poses:
            return None
        yaws = [wrap_angle(pose.facing_rad + camera_yaw_in_odom_rad) for pose in poses]
        weights = [1.0 / max(pose.error_px, MIN_ERROR_PX) for pose in poses]
        total = sum(weights)
        self._seen = [(yaw, weight * FORGET) for yaw, weight in self._seen[-KEEP_MAX:]]
        self._seen += [(yaw, weight / total) for yaw, weight in zip(yaws, weights)]
        return poses[max(range(len(poses)), key=lambda i: self._support(yaws[i]))]

    @property
    def facing_rad(self) -> float | None:
        """In odom: the direction with the most support, or None before the first frame."""
        if not self._seen:
            return None
        best = max((yaw for yaw, _ in self._seen), key=self._support)
        near = [(yaw, w) for yaw, w in self._seen if abs(wrap_angle(yaw - best)) < 2.0 * self._sigma_rad]
        turn = np.array([w * np.array([math.cos(yaw), math.sin(yaw)]) for yaw, w in near]).sum(axis=0)
        return math.atan2(float(turn[1]), float(turn[0]))

    def _support(self, yaw_rad: float) -> float:
        off: FloatArray = np.array([wrap_angle(yaw_rad - yaw) for yaw, _ in self._seen])
        weights = np.array([weight for _, weight in self._seen])
        return float((weights * np.exp(-0.5 * (off / self._sigma_rad) ** 2)).sum())
