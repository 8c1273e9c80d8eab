"""Finds things by their colour: one blob, or two of them side by side whose distance is the scale.

A colour is its share of the light (red over red + green + blue), which shadows and exposure change little, or a range
of hue, saturation and value. Two boxes of one colour with a gap between them make a target that needs no network: the
gap tells how far off it is, its middle where it is.
"""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from target_nav.detectors.detector import ImageBgr, check_picture
from target_nav.errors import ConfigError
from target_nav.state.types import RawDetection
from target_nav.utils.distance import Box

Mask = NDArray[np.uint8]
SMOOTH_PX = 5
"""Side of the square over which colours are averaged first: single pixels are noise."""
BRIGHT_MIN = 90
"""Sum of the three channels; below it a share says nothing."""
SHARE_CHANNELS = {"blue": 0, "green": 1, "red": 2}
SHARE_MIN = 0.45
"""A third is grey; wood and skin reach 0.42 in red."""
SHARE_SURE = 0.65
HUES: dict[str, tuple[tuple[int, int], ...]] = {
    "red": ((0, 8), (172, 179)), "orange": ((9, 20),), "yellow": ((21, 34),), "green": ((38, 85),), "cyan": ((86, 98),),
    "blue": ((99, 128),), "magenta": ((135, 171),),
}  # fmt: skip
"""OpenCV counts hue from 0 to 179."""
SATURATION_MIN, VALUE_MIN = 110, 50
AREA_MIN_PX = 60
BLOBS_MAX = 32
FILL_MIN = 0.5
"""Of its bounding box: a blob that fills less is no box and no ball."""
PAIR_SIZES_ALIKE = 1.6
PAIR_LEVEL = 0.35
"""Of their height: how much higher one may stand in the picture than the other."""
PAIR_GAP_TO_HEIGHT = (0.8, 8.0)
"""Middle to middle, of their height."""


@dataclass(frozen=True)
class _Blob:
    left: int
    top: int
    right: int
    bottom: int
    u: float
    v: float
    strength: float

    @property
    def width(self) -> int:
        return self.right - self.left

    @property
    def height(self) -> int:
        return self.bottom - self.top


class ColourDetector:
    """A `Detector` for one colour: each blob of it is a box. `kind` is `share` or `hsv`."""

    def __init__(self, colour: str, label: str, kind: str = "share") -> None:
        """Raises:
        ConfigError: there is no such colour for that kind.
        """
        known = SHARE_CHANNELS if kind == "share" else HUES
        if kind not in ("share", "hsv") or colour not in known:
            raise ConfigError(
                f"no colour {colour!r} by {kind!r}; share knows {', '.join(SHARE_CHANNELS)}, hsv {', '.join(HUES)}"
            )
        self._colour, self._label, self._kind = colour, label, kind

    @property
    def class_names(self) -> tuple[str, ...]:
        return (self._label,)

    def detect(self, image_bgr: ImageBgr) -> tuple[RawDetection, ...]:
        """Blobs, the surest first.

        Raises:
            ValueError: the picture is not uint8 of shape (height, width, 3).
        """
        found = [
            self._raw(blob.left, blob.top, blob.right, blob.bottom, blob.strength)
            for blob in self.blobs(image_bgr)
        ]
        return tuple(sorted(found, key=lambda d: -d.score))

    def blobs(self, image_bgr: ImageBgr) -> list[_Blob]:
        """The largest blobs that fill their boxes."""
        check_picture(image_bgr)
        mask, strength = self._share(image_bgr) if self._kind == "share" else self._hsv(image_bgr)
        _, labels, stats, middles = cv2.connectedComponentsWithStats(mask, connectivity=8, ltype=cv2.CV_32S)
        areas = stats[1:, cv2.CC_STAT_AREA]
        blobs = []
        for k in np.argsort(-areas, kind="stable")[:BLOBS_MAX] + 1:
            left, top, width, height, area = (int(value) for value in stats[k])
            if area < AREA_MIN_PX:
                break
            if area < FILL_MIN * width * height:
                continue
            region = (slice(top, top + height), slice(left, left + width))
            sure = float(strength[region][labels[region] == k].mean())
            u, v = (float(value) + 0.5 for value in middles[k])
            blobs.append(_Blob(left, top, left + width, top + height, u, v, sure))
        return blobs

    def _share(self, image_bgr: ImageBgr) -> tuple[Mask, NDArray[np.float32]]:
        smooth = cv2.blur(image_bgr, (SMOOTH_PX, SMOOTH_PX)).astype(np.float32)
        total = smooth.sum(axis=2)
        share = smooth[:, :, SHARE_CHANNELS[self._colour]] / np.maximum(total, 1.0)
        mask = ((share >= SHARE_MIN) & (total >= BRIGHT_MIN)).astype(np.uint8)
        sure = 0.5 + 0.5 * np.clip((share - SHARE_MIN) / (SHARE_SURE - SHARE_MIN), 0.0, 1.0)
        return mask, sure.astype(np.float32)

    def _hsv(self, image_bgr: ImageBgr) -> tuple[Mask, NDArray[np.float32]]:
        hsv = cv2.cvtColor(cv2.blur(image_bgr, (SMOOTH_PX, SMOOTH_PX)), cv2.COLOR_BGR2HSV)
        mask = np.zeros(hsv.shape[:2], np.uint8)
        for low, high in HUES[self._colour]:
            mask |= cv2.inRange(hsv, (low, SATURATION_MIN, VALUE_MIN), (high, 255, 255))
        sure = 0.5 + 0.5 * np.clip(
            (hsv[:, :, 1].astype(np.float32) - SATURATION_MIN) / (255 - SATURATION_MIN), 0.0, 1.0
        )
        return (mask > 0).astype(np.uint8), sure.astype(np.float32)

    def _raw(self, left: float, top: float, right: float, bottom: float, score: float) -> RawDetection:
        box = Box.from_edges(left, top, right, bottom)
        return RawDetection(self._label, score, box.u_px, box.v_px, box.width_px, box.height_px)


class TwoBoxDetector(ColourDetector):
    """Pairs of equal blobs side by side, nothing of the colour between them.

    A pair's box is as wide as the *gap from middle to middle* and as high as the boxes: `width_m` of the mission is the
    gap, and the range comes from it.
    """

    def detect(self, image_bgr: ImageBgr) -> tuple[RawDetection, ...]:
        blobs = sorted(self.blobs(image_bgr), key=lambda blob: blob.u)
        pairs = []
        for i, first in enumerate(blobs):
            for second in blobs[i + 1 :]:
                if _is_pair(first, second) and not any(_is_between(first, other, second) for other in blobs):
                    top, bottom = 0.5 * (first.top + second.top), 0.5 * (first.bottom + second.bottom)
                    pairs.append(
                        self._raw(first.u, top, second.u, bottom, min(first.strength, second.strength))
                    )
        return tuple(sorted(pairs, key=lambda d: -d.score))


def _is_pair(first: _Blob, second: _Blob) -> bool:
    for a, b in ((first.width, second.width), (first.height, second.height)):
        if max(a, b) > PAIR_SIZES_ALIKE * min(a, b) + 2:
            return False
    height = max(first.height, second.height)
    low, high = PAIR_GAP_TO_HEIGHT
    return (
        abs(first.v - second.v) <= PAIR_LEVEL * height + 1.0
        and low * height <= second.u - first.u <= high * height
    )


def _is_between(first: _Blob, other: _Blob, second: _Blob) -> bool:
    return first.u < other.u < second.u and _is_pair_level(first, other)


def _is_pair_level(first: _Blob, other: _Blob) -> bool:
    return abs(first.v - other.v) <= PAIR_LEVEL * max(first.height, other.height) + 1.0
