"""Where a pin's two red neck stripes may be: the only thing about it that no white wall has.

Red blobs are paired one over the other; far away both run into one. Each find proposes an axis and a height, and
`pin_fit` decides.
"""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np

from target_nav.detectors.detector import ImageBgr
from target_nav.utils import bowling_pin

REDNESS_MIN = 45
"""Grey levels by which red exceeds the larger of green and blue; cardboard has about 30."""
BLOB_AREA_MIN_PX = 4
BLOBS_MAX = 48
"""A picture with more red spots than this is not made of pins; the largest are tried."""
BORDER_PX = 2

(_LOWER, _THICKNESS), (_UPPER, _) = bowling_pin.STRIPES
STRIPE_GAP = _UPPER - _LOWER
"""Of the pin's height, middle to middle."""
STRIPES_SPAN = STRIPE_GAP + _THICKNESS
STRIPES_MIDDLE = 0.5 * (_UPPER + _LOWER)
NECK_WIDTH = 0.113
"""The stripes' width, of the pin's height, for one 3.5 times as high as wide."""
PAIR_GAP_TO_WIDTH = (0.45, 1.25)
SINGLE_HEIGHT_TO_WIDTH = (0.7, 2.0)
WIDTHS_ALIKE = 1.7
PIN_HEIGHT_MIN_PX = 16.0
PIN_HEIGHT_MAX_PX = 1100.0
"""From about 9 m down to 0.14 m for a 0.28 m pin and a 60 degree camera."""
RUN_TOGETHER_BELOW_PX = 90.0
"""The gap between the stripes is 4 % of the height: it shows from 3 or 4 pixels on."""


@dataclass(frozen=True)
class StripeFind:
    """A proposal: the middle of both stripes, and the height of the pin that would wear them, pixels.

    `sideways` says that the picture's border cuts them, so the axis is a guess.
    """

    u_px: float
    v_px: float
    pin_height_px: float
    sideways: bool


@dataclass(frozen=True)
class _Blob:
    left: int
    right: int
    width: int
    height: int
    u: float
    v: float
    at_border: bool


def find_stripes(image_bgr: ImageBgr) -> list[StripeFind]:
    """All proposals in a picture, uint8 (height, width, 3); pairs first, the largest first among their kind."""
    blobs = _red_blobs(image_bgr)
    pairs = [
        (upper, lower) for upper in blobs for lower in blobs if upper.v < lower.v and _is_pair(upper, lower)
    ]
    in_pairs = {id(blob) for pair in pairs for blob in pair}
    width = image_bgr.shape[1]
    from_pairs = [_from_pair(upper, lower, width) for upper, lower in pairs]
    singles = [_from_single(blob, width) for blob in blobs if id(blob) not in in_pairs and _is_both(blob)]
    return [
        *(find for find in from_pairs if PIN_HEIGHT_MIN_PX <= find.pin_height_px <= PIN_HEIGHT_MAX_PX),
        *(find for find in singles if PIN_HEIGHT_MIN_PX <= find.pin_height_px <= RUN_TOGETHER_BELOW_PX),
    ]


def _red_blobs(image_bgr: ImageBgr) -> list[_Blob]:
    blue, green, red = cv2.split(image_bgr)
    redness = cv2.subtract(red, cv2.max(blue, green))
    _, mask = cv2.threshold(redness, REDNESS_MIN, 255, cv2.THRESH_BINARY)
    if cv2.countNonZero(mask) < BLOB_AREA_MIN_PX:
        return []
    _, _, stats, centroids = cv2.connectedComponentsWithStats(mask, connectivity=8, ltype=cv2.CV_32S)
    areas = stats[1:, cv2.CC_STAT_AREA]
    order = np.argsort(-areas, kind="stable")[:BLOBS_MAX] + 1
    blobs = []
    for label in order:
        left, _, width, height, area = (int(value) for value in stats[label])
        if area < BLOB_AREA_MIN_PX:
            break
        right = left + width
        at_border = left <= BORDER_PX or right >= image_bgr.shape[1] - BORDER_PX
        u, v = (float(value) + 0.5 for value in centroids[label])
        blobs.append(_Blob(left, right, width, height, u, v, at_border))
    return blobs


def _is_pair(upper: _Blob, lower: _Blob) -> bool:
    width = max(upper.width, lower.width)
    if width > WIDTHS_ALIKE * min(upper.width, lower.width) + 1 or abs(upper.u - lower.u) > 0.35 * width + 1:
        return False
    low, high = PAIR_GAP_TO_WIDTH
    if upper.at_border or lower.at_border:
        high *= 3.0
    gap = lower.v - upper.v
    return low * width - 1.0 <= gap <= high * width + 1.0


def _is_both(blob: _Blob) -> bool:
    low, high = SINGLE_HEIGHT_TO_WIDTH
    return low * blob.width - 1.0 <= blob.height <= high * blob.width + 1.0


def _from_pair(upper: _Blob, lower: _Blob, picture_width: int) -> StripeFind:
    height_px = (lower.v - upper.v) / STRIPE_GAP
    return _find(upper, lower, 0.5 * (upper.v + lower.v), height_px, picture_width)


def _from_single(blob: _Blob, picture_width: int) -> StripeFind:
    # A threshold at less than half of the stripes' redness widens the blob by about a pixel.
    return _find(blob, blob, blob.v, max(blob.height - 1.0, 1.5) / STRIPES_SPAN, picture_width)


def _find(upper: _Blob, lower: _Blob, v_px: float, height_px: float, picture_width: int) -> StripeFind:
    half_neck_px = 0.5 * NECK_WIDTH * height_px
    left, right = min(upper.left, lower.left), max(upper.right, lower.right)
    if left <= BORDER_PX:
        return StripeFind(right - half_neck_px, v_px, height_px, True)
    if right >= picture_width - BORDER_PX:
        return StripeFind(left + half_neck_px, v_px, height_px, True)
    return StripeFind(0.5 * (upper.u + lower.u), v_px, height_px, False)
