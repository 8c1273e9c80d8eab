"""Finds AprilTags of the family 36h11 (Olson, *AprilTag: a robust and flexible visual fiducial system*, ICRA 2011).

By OpenCV's aruco, of either generation: 4.6 has functions where later ones have a class, and 5.0 returns ids as (N,)
where 4.x returns (N, 1).
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import cv2
import numpy as np

from target_nav.config import CameraConfig
from target_nav.detectors.apriltag_pose import tag_facings
from target_nav.detectors.detector import ImageBgr, check_picture
from target_nav.errors import ConfigError, DeviceError
from target_nav.state.types import FloatArray, RawDetection
from target_nav.utils.distance import Box

FAMILY_SIZE = 587
NEAR_SQUARES = 0.02
"""Of a square's side: squares nearer to each other than this are one. With 4.6's own 0.05 the edge of a tag's white
margin swallows the tag."""
REFINED_PX = 2
"""Half the window in which 4.6 refines a corner. Later ones fit it to the tag's cells; 4.6's own 5 pixels take in the
cells of a far tag, and its corners are 1.6 pixels off."""
SCORE = 0.95
"""A tag carries eleven bits against errors: what is read at all is right."""


@dataclass(frozen=True, eq=False)
class TagCorners:
    """`corners_px` (4, 2): upper left, upper right, lower right, lower left of the tag, in picture coordinates."""

    tag_id: int
    corners_px: FloatArray


class AprilTagFinder:
    """Corners of all tags in a picture, refined to a part of a pixel."""

    def __init__(self) -> None:
        """Raises:
        DeviceError: this OpenCV has no aruco (before 4.7 it is one of the contributed modules).
        """
        cv2.setNumThreads(1)
        if not hasattr(cv2, "aruco"):
            raise DeviceError(
                f"OpenCV {cv2.__version__} has no aruco: take 4.7 or later, or one with contrib modules"
            )
        # The functions of 4.6 are unknown to the types of later ones.
        aruco: Any = cv2.aruco
        self._dictionary = aruco.getPredefinedDictionary(aruco.DICT_APRILTAG_36h11)
        modern = hasattr(aruco, "ArucoDetector")
        self._parameters = aruco.DetectorParameters() if modern else aruco.DetectorParameters_create()
        self._parameters.cornerRefinementMethod = aruco.CORNER_REFINE_SUBPIX
        self._parameters.minMarkerDistanceRate = NEAR_SQUARES
        if not modern:
            self._parameters.cornerRefinementWinSize = REFINED_PX
        self._detector: Any = aruco.ArucoDetector(self._dictionary, self._parameters) if modern else None

    def find(self, image_bgr: ImageBgr) -> list[TagCorners]:
        """Raises:
        ValueError: the picture is not uint8 of shape (height, width, 3).
        """
        check_picture(image_bgr)
        grey = cv2.cvtColor(image_bgr, cv2.COLOR_BGR2GRAY)
        if self._detector is not None:
            corners, ids, _ = self._detector.detectMarkers(grey)
        else:
            functions: Any = cv2.aruco
            corners, ids, _ = functions.detectMarkers(grey, self._dictionary, parameters=self._parameters)
        if ids is None or len(ids) == 0:
            return []
        # OpenCV counts from the middle of the first pixel, we from its edge.
        return [
            TagCorners(int(tag_id), np.asarray(quad, np.float64).reshape(4, 2) + 0.5)
            for tag_id, quad in zip(np.asarray(ids).ravel(), corners)
        ]


class AprilTagDetector:
    """A `Detector` for one tag. Its box is as high as the tag's upright edges, as wide as its corners."""

    def __init__(self, tag_id: int, label: str, camera: CameraConfig | None = None) -> None:
        """Without `camera` it does not say where the tag's face looks.

        Raises:
            ConfigError: the family has no such tag.
        """
        if not 0 <= tag_id < FAMILY_SIZE:
            raise ConfigError(f"tag {tag_id} is not of the family 36h11, which has 0 ... {FAMILY_SIZE - 1}")
        self._tag_id, self._label, self._camera = tag_id, label, camera
        self._finder = AprilTagFinder()

    @property
    def class_names(self) -> tuple[str, ...]:
        return (self._label,)

    def detect(self, image_bgr: ImageBgr) -> tuple[RawDetection, ...]:
        """The tag wherever it is seen, the largest first. A tag turned sideways is as high as it ever was.

        Raises:
            ValueError: the picture is not uint8 of shape (height, width, 3).
        """
        found = []
        for tag in self._finder.find(image_bgr):
            if tag.tag_id == self._tag_id:
                box = upright_box(tag.corners_px)
                facings = tag_facings(tag.corners_px, self._camera) if self._camera is not None else ()
                found.append(
                    RawDetection(
                        self._label, SCORE, box.u_px, box.v_px, box.width_px, box.height_px, *facings
                    )
                )
        return tuple(sorted(found, key=lambda d: -d.height_px))


def upright_box(corners_px: FloatArray) -> Box:
    """Corners to a box whose height is the mean of the two upright edges: their mean is the height at the middle."""
    ordered = corners_px[np.argsort(corners_px[:, 0])]
    left, right = ordered[:2], ordered[2:]
    heights = np.ptp(left[:, 1]), np.ptp(right[:, 1])
    # Projected sizes go with 1 / depth, and so does their mean's depth: the harmonic mean would be for depths.
    height = 0.5 * float(heights[0] + heights[1])
    u, v = (float(value) for value in corners_px.mean(axis=0))
    return Box(u, v, float(np.ptp(corners_px[:, 0])), height)
