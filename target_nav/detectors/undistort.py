"""Straightens a lens's distortion, so that what follows may take the camera for a pinhole."""

from __future__ import annotations

import cv2
import numpy as np

from target_nav.detectors.detector import ImageBgr
from target_nav.state.snapshots import Calibration

_Key = tuple[float, ...]


class Undistorter:
    """Keeps the remapping tables of the last calibration; without distortion the picture passes as it is."""

    def __init__(self) -> None:
        self._key: _Key = ()
        self._maps: tuple[np.ndarray, np.ndarray] | None = None

    def apply(self, image_bgr: ImageBgr, calibration: Calibration | None) -> ImageBgr:
        """The picture that a pinhole camera of the same focal length and centre would have taken."""
        if calibration is None or not any(calibration.distortion):
            return image_bgr
        height, width = image_bgr.shape[:2]
        camera = (
            calibration.focal_x_px, calibration.focal_y_px, calibration.center_u_px, calibration.center_v_px
        )  # fmt: skip
        key = (*camera, *calibration.distortion, width, height)
        if key != self._key or self._maps is None:
            fx, fy, cu, cv = camera
            # OpenCV counts from the middle of the first pixel, we from its edge.
            matrix = np.array([[fx, 0.0, cu - 0.5], [0.0, fy, cv - 0.5], [0.0, 0.0, 1.0]])
            map_u, map_v = cv2.initUndistortRectifyMap(
                matrix, np.array(calibration.distortion), np.eye(3), matrix, (width, height), cv2.CV_16SC2
            )
            self._key, self._maps = key, (map_u, map_v)
        return np.asarray(cv2.remap(image_bgr, self._maps[0], self._maps[1], cv2.INTER_LINEAR), np.uint8)
