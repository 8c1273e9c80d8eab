"""Finds a bowling pin in the pixels: white, pin-shaped, two red stripes round its neck. No network, no training.

It takes the trained detector's place where there is none, and it is what the simulator's pictures are looked at with.
The stripes propose, the outline decides: a white wall has no stripes, a red can no white body, a bottle no pin's
profile.
"""

from __future__ import annotations

import cv2

from target_nav.detectors.detector import ImageBgr, check_picture
from target_nav.detectors.pin_fit import PinFit, fit_pin
from target_nav.detectors.red_stripes import find_stripes
from target_nav.state.types import RawDetection
from target_nav.utils import bowling_pin
from target_nav.utils.distance import Box

LOWEST_SCORE = 0.3
FITS_MAX = 6
OVERLAP_MAX = 0.5
MIN_SIDE_PX = 2.0


class PinPixelDetector:
    """A `Detector` for one class, `bowling_pin`."""

    def __init__(self, label: str = bowling_pin.CLASS_NAME) -> None:
        """`label` is the class name its boxes carry."""
        cv2.setNumThreads(1)
        self._label = label

    @property
    def class_names(self) -> tuple[str, ...]:
        return (self._label,)

    def detect(self, image_bgr: ImageBgr) -> tuple[RawDetection, ...]:
        """Pins in a picture, best score first; scores under `LOWEST_SCORE` are left out.

        Raises:
            ValueError: the picture is not uint8 of shape (height, width, 3).
        """
        check_picture(image_bgr)
        fits = [fit_pin(image_bgr, find) for find in find_stripes(image_bgr)[:FITS_MAX]]
        good = sorted((fit for fit in fits if fit is not None and fit.score >= LOWEST_SCORE), key=_by_score)
        kept: list[tuple[PinFit, Box]] = []
        for fit in good:
            box = _visible_box(fit, image_bgr.shape[1], image_bgr.shape[0])
            if box is not None and all(_overlap(box, other) <= OVERLAP_MAX for _, other in kept):
                kept.append((fit, box))
        return tuple(
            RawDetection(self._label, fit.score, box.u_px, box.v_px, box.width_px, box.height_px)
            for fit, box in kept
        )


def _by_score(fit: PinFit) -> float:
    return -fit.score


def _visible_box(fit: PinFit, picture_width: int, picture_height: int) -> Box | None:
    left = max(fit.u_px - 0.5 * fit.width_px, 0.0)
    right = min(fit.u_px + 0.5 * fit.width_px, float(picture_width))
    top, bottom = max(fit.top_px, 0.0), min(fit.bottom_px, float(picture_height))
    if right - left < MIN_SIDE_PX or bottom - top < MIN_SIDE_PX:
        return None
    return Box.from_edges(left, top, right, bottom)


def _overlap(first: Box, second: Box) -> float:
    """Intersection over union."""
    a, b = first.edges, second.edges
    width = min(a[2], b[2]) - max(a[0], b[0])
    height = min(a[3], b[3]) - max(a[1], b[1])
    if width <= 0.0 or height <= 0.0:
        return 0.0
    common = width * height
    return common / (first.width_px * first.height_px + second.width_px * second.height_px - common)
