"""The pinhole camera, both ways: a box in the picture to a range and a bearing on the ground, and back.

The camera is level and looks along its own x axis, so a thing that stands upright is `focal * height / depth` pixels
tall wherever it stands in the picture (Hartley and Zisserman, *Multiple View Geometry*, 6.1). Picture coordinates are
continuous: column i covers i to i + 1, and a box's edges lie between pixels. Pictures are straightened before, so the
lens does not appear here.
Ranges are measured on the ground from the camera to the thing's axis; bearings are left positive, in the camera's
frame.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

from target_nav.config import CameraConfig, DetectorConfig

MIN_DEPTH_M = 1e-3
"""A thing this near to the image plane, or behind it, has no projection."""


@dataclass(frozen=True)
class Box:
    """An upright rectangle in picture coordinates, pixels; (u_px, v_px) is its centre."""

    u_px: float
    v_px: float
    width_px: float
    height_px: float

    @classmethod
    def from_edges(cls, left_px: float, top_px: float, right_px: float, bottom_px: float) -> Box:
        return cls(
            0.5 * (left_px + right_px), 0.5 * (top_px + bottom_px), right_px - left_px, bottom_px - top_px
        )

    @property
    def edges(self) -> tuple[float, float, float, float]:
        """(left, top, right, bottom)."""
        half_width, half_height = 0.5 * self.width_px, 0.5 * self.height_px
        return (
            self.u_px - half_width, self.v_px - half_height, self.u_px + half_width, self.v_px + half_height
        )  # fmt: skip


@dataclass(frozen=True)
class Clipping:
    """Which of the picture's borders a box touches: what lies beyond them is not in the box."""

    left: bool
    top: bool
    right: bool
    bottom: bool

    @property
    def sideways(self) -> bool:
        return self.left or self.right

    @property
    def upright(self) -> bool:
        return self.top or self.bottom

    @property
    def any(self) -> bool:
        return self.sideways or self.upright


def bearing_from_u(camera: CameraConfig, u_px: float) -> float:
    """Direction of a picture column, rad, left positive."""
    return math.atan2(camera.center_u_px - u_px, camera.focal_px)


def u_from_bearing(camera: CameraConfig, bearing_rad: float) -> float:
    """The picture column of a direction in front of the camera (|bearing| < 90 degrees)."""
    return camera.center_u_px - camera.focal_px * math.tan(bearing_rad)


def range_from_height(camera: CameraConfig, height_m: float, height_px: float, bearing_rad: float) -> float:
    """Ground range in metres of an upright thing: depth = focal * height / pixels, and the range is its slant."""
    return camera.focal_y_px * height_m / (height_px * math.cos(bearing_rad))


def range_from_width(camera: CameraConfig, width_m: float, width_px: float, bearing_rad: float) -> float:
    """Ground range in metres of a round thing by its width; off the axis a sphere or cylinder is drawn wider."""
    return camera.focal_px * width_m / (width_px * math.cos(bearing_rad) ** 2)


def range_sigma(detector: DetectorConfig, range_m: float, height_px: float) -> float:
    """Standard deviation of `range_from_height`, m.

    A share of the range (focal length, box habits of the detector) and an edge error in pixels, which weighs more the
    smaller the box is. With the defaults 4.0 % at 1 m and 4.3 % at 7 m for a 0.28 m pin, as measured.
    """
    return range_m * math.hypot(detector.range_sigma, detector.edge_sigma_px / height_px)


def bearing_sigma(detector: DetectorConfig) -> float:
    """Standard deviation of `bearing_from_u`, rad: the detector's own and what calibration leaves of the mount's."""
    return math.hypot(detector.bearing_sigma_rad, detector.mount_sigma_rad)


def project(
    camera: CameraConfig, range_m: float, bearing_rad: float, height_m: float, width_m: float
) -> Box | None:
    """The box of an upright thing that stands on the floor, not clipped; None behind the image plane."""
    cos = math.cos(bearing_rad)
    depth_m = range_m * cos
    if depth_m < MIN_DEPTH_M:
        return None
    scale, scale_y = camera.focal_px / depth_m, camera.focal_y_px / depth_m
    height_px = scale_y * height_m
    bottom_px = camera.center_v_px + scale_y * camera.z_m
    return Box(
        u_from_bearing(camera, bearing_rad), bottom_px - 0.5 * height_px, scale * width_m / cos, height_px
    )


def clip_box(camera: CameraConfig, box: Box) -> Box | None:
    """The part of a box that is in the picture, or None."""
    left, top, right, bottom = box.edges
    left, right = max(left, 0.0), min(right, float(camera.width_px))
    top, bottom = max(top, 0.0), min(bottom, float(camera.height_px))
    if right <= left or bottom <= top:
        return None
    return Box.from_edges(left, top, right, bottom)


def clipping_of(camera: CameraConfig, box: Box, border_px: float) -> Clipping:
    """Which borders a box comes within `border_px` of."""
    left, top, right, bottom = box.edges
    return Clipping(
        left=left <= border_px,
        top=top <= border_px,
        right=right >= camera.width_px - border_px,
        bottom=bottom >= camera.height_px - border_px,
    )
