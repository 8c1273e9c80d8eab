"""The camera's picture as JPEG: encoded once for all viewers, and only while somebody looks."""

from __future__ import annotations

import math

import cv2
import numpy as np
from numpy.typing import NDArray

QUALITY = 70
PERIOD_S = 0.095
"""Ten a second at most: what the detector gives."""
WIDEST_PX = 800
PAST_PERIOD_S = 2.0
PAST_WIDTH_PX = 320
PAST_QUALITY = 45


def jpeg(image_bgr: NDArray[np.uint8], widest_px: int = WIDEST_PX, quality: int = QUALITY) -> bytes:
    """A picture no wider than `widest_px`."""
    height, width = image_bgr.shape[:2]
    if width > widest_px:
        size = (widest_px, max(1, round(height * widest_px / width)))
        image_bgr = cv2.resize(image_bgr, size, interpolation=cv2.INTER_AREA).astype(np.uint8, copy=False)
    done, encoded = cv2.imencode(".jpg", image_bgr, [cv2.IMWRITE_JPEG_QUALITY, quality])
    if not done:
        raise ValueError(f"a picture of shape {image_bgr.shape} cannot be encoded as JPEG")
    return encoded.tobytes()


class Rate:
    """Lets something happen at most once in `period_s`, in step with what comes faster than that."""

    def __init__(self, period_s: float) -> None:
        self._period_s = period_s
        self._next_s = -math.inf

    def due(self, now_s: float) -> bool:
        if now_s < self._next_s:
            return False
        self._next_s = now_s + self._period_s
        return True
