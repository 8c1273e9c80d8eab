"""AprilTags that hang on walls: where their corners are, and what a reader makes of them without a picture.

A flat square seen from afar has two poses that fit its corners. A reader tells both, here with the errors that a real
one has (`detectors/apriltag_pose.py`): corners by noise, and of the false pose also what it cannot explain, that
the nearer of the two upright edges is the longer one.
"""

from __future__ import annotations

import math

import numpy as np

from target_nav.config import CameraConfig
from target_nav.sim.arena_types import PlacedObject
from target_nav.sim.objects import TAG_CELLS, TAG_MARGIN_CELLS, TAG_MIDDLE_M, TAG_SIDE_M
from target_nav.sim.world import RayCaster
from target_nav.state.types import Facing, FloatArray, Pose2D, RawDetection
from target_nav.utils.frames import to_child, wrap_angle

CORNER_SIGMA_PX = 0.15
"""Of OpenCV's subpixel refinement in the renderer's pictures."""
LEAST_SIDE_PX = 14.0
"""Of the shorter side: fewer than two pixels a cell are not read."""
LARGEST_TURN_RAD = math.radians(75.0)
BORDER_PX = 2.0
SCORE = 0.95
UNEXPLAINED = 0.35
"""Share of the difference between the upright edges that the false pose leaves, as a root mean square over corners."""
NEAREST_M = 0.05
_WALL_M = 0.02


def tag_corners_m(tag: PlacedObject, with_margin: bool = False) -> FloatArray:
    """Upper left, upper right, lower right, lower left as seen from the front, shape (4, 3), in the world."""
    half = 0.5 * TAG_SIDE_M
    if with_margin:
        half *= 1.0 + 2.0 * TAG_MARGIN_CELLS / TAG_CELLS
    # Who stands in front of it looks against the normal: his right is the normal turned to the left.
    right = -math.sin(tag.yaw_rad), math.cos(tag.yaw_rad)
    return np.array(
        [
            (tag.x_m + side * half * right[0], tag.y_m + side * half * right[1], TAG_MIDDLE_M + up * half)
            for side, up in ((-1.0, 1.0), (1.0, 1.0), (1.0, -1.0), (-1.0, -1.0))
        ]
    )


def project_corners(
    corners_m: FloatArray, camera_in_world: Pose2D, camera: CameraConfig, focal_px: float
) -> FloatArray | None:
    """Picture coordinates, shape (4, 2), of points (4, 3); None if one is not well in front of the camera."""
    points = []
    for x_m, y_m, z_m in corners_m.tolist():
        depth_m, left_m = to_child(camera_in_world, x_m, y_m)
        if depth_m < NEAREST_M:
            return None
        scale = focal_px / depth_m
        points.append(
            (0.5 * camera.width_px - scale * left_m, 0.5 * camera.height_px - scale * (z_m - camera.z_m))
        )
    return np.array(points)


def turned_rad(tag: PlacedObject, camera_in_world: Pose2D) -> float:
    """Angle between the tag's normal and the way to the camera; 0 is seen from straight ahead."""
    to_camera = math.atan2(camera_in_world.y_m - tag.y_m, camera_in_world.x_m - tag.x_m)
    return wrap_angle(tag.yaw_rad - to_camera)


class TagReader:
    """What the camera process's tag detector would say, from the true geometry and noise."""

    def __init__(
        self, camera: CameraConfig, focal_px: float, caster: RayCaster, rng: np.random.Generator
    ) -> None:
        self._camera, self._focal_px, self._caster, self._rng = camera, focal_px, caster, rng

    def read(self, tag: PlacedObject, camera_in_world: Pose2D) -> RawDetection | None:
        """None: too far off, too much from the side, not wholly in the picture, hidden, or missed."""
        camera, rng = self._camera, self._rng
        turned = turned_rad(tag, camera_in_world)
        range_m = math.hypot(tag.x_m - camera_in_world.x_m, tag.y_m - camera_in_world.y_m)
        if abs(turned) > LARGEST_TURN_RAD or range_m > camera.max_range_m:
            return None
        corners = project_corners(tag_corners_m(tag), camera_in_world, camera, self._focal_px)
        if corners is None or not self._is_readable(corners) or self._is_hidden(tag, camera_in_world):
            return None
        if float(rng.random()) < camera.miss_probability:
            return None
        sigma_px = CORNER_SIGMA_PX * camera.noise_scale
        noisy = corners + sigma_px * rng.standard_normal((4, 2))
        heights = noisy[[3, 2], 1] - noisy[[0, 1], 1]
        u_px, v_px = (float(value) for value in noisy.mean(axis=0))
        facings = self._facings(tag, camera_in_world, turned, float(heights.mean()), sigma_px)
        return RawDetection(
            tag.class_name, SCORE, u_px, v_px, float(np.ptp(noisy[:, 0])), float(heights.mean()), *facings
        )

    def _is_readable(self, corners_px: FloatArray) -> bool:
        camera = self._camera
        size = float(np.ptp(corners_px[:, 0])), float(np.ptp(corners_px[:, 1]))
        inside = (corners_px >= BORDER_PX).all() and (
            corners_px <= (camera.width_px - BORDER_PX, camera.height_px - BORDER_PX)
        ).all()
        return bool(inside) and min(size) >= LEAST_SIDE_PX

    def _is_hidden(self, tag: PlacedObject, camera_in_world: Pose2D) -> bool:
        """Whether anything stands before its middle or one of its sides."""
        corners = tag_corners_m(tag)
        ends = np.array([corners[0, :2], corners[1, :2], (tag.x_m, tag.y_m)])
        way = ends - (camera_in_world.x_m, camera_in_world.y_m)
        away_m = np.hypot(way[:, 0], way[:, 1])
        origin = np.full(3, camera_in_world.x_m), np.full(3, camera_in_world.y_m)
        met_m = self._caster.cast(*origin, way[:, 0] / away_m, way[:, 1] / away_m)
        return bool((met_m < away_m - _WALL_M / max(math.cos(turned_rad(tag, camera_in_world)), 0.2)).any())

    def _facings(
        self, tag: PlacedObject, camera_in_world: Pose2D, turned: float, height_px: float, sigma_px: float
    ) -> tuple[Facing, Facing]:
        """The true pose and its mirror image about the line of sight, the better fitting first."""
        rng = self._rng
        by_width = height_px * math.sin(turned)
        by_edges = 0.5 * height_px**2 / self._focal_px * math.cos(turned)
        off_rad = sigma_px / math.hypot(by_width, by_edges) * float(rng.standard_normal())
        seen_rad = turned + min(max(off_rad, -0.5), 0.5)
        to_camera_rad = wrap_angle(tag.yaw_rad - turned - camera_in_world.yaw_rad)
        noise = 0.5 * sigma_px * rng.standard_normal(2)
        edges_px = height_px**2 / self._focal_px * abs(math.sin(turned))
        true_pose = Facing(wrap_angle(to_camera_rad + seen_rad), abs(float(noise[0])))
        mirrored = Facing(wrap_angle(to_camera_rad - seen_rad), abs(UNEXPLAINED * edges_px + float(noise[1])))
        first, second = sorted((true_pose, mirrored), key=lambda facing: facing.error_px)
        return first, second
