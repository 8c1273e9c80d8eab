"""How well a pin's outline fits at a place in the picture, and where it fits best.

Template matching on edges: the profile's outline is laid over the gradient of a patch, and the mean gradient across
it is what a pose of the outline is worth (as in Borgefors, *Hierarchical chamfer matching*, PAMI 10(6), 1988, with
gradients in place of distances). The patch is scaled so that the pin is always `PATCH_PIN_PX` tall: near and far cost
the same.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from target_nav.detectors.detector import ImageBgr
from target_nav.detectors.red_stripes import STRIPES_MIDDLE, StripeFind
from target_nav.state.types import FloatArray
from target_nav.utils import bowling_pin

PATCH_PIN_PX = 128.0
PATCH_WIDTH = 112
PATCH_HEIGHT = 224
ANCHOR = (0.5 * PATCH_WIDTH, 76.0)
"""Where the middle of the stripes lies in the patch: room for a pin 40 % larger than proposed."""

ASPECT = 80.0 / 280.0
"""Width to height of the outline that is laid over; the width is measured afterwards."""
EDGE_CAP = 24.0
"""Grey levels a patch pixel: a stronger edge is worth no more, or one background edge would outvote the outline."""
EDGE_SEEN = 5.0
"""Grey levels a pixel (of the picture, where the patch is larger) that make an edge."""

COARSE_SCALES = np.geomspace(0.68, 1.45, 33)
COARSE_SHIFTS = np.array([-0.02, 0.0, 0.02])
UPRIGHT_SHIFTS = np.array([-0.008, 0.0, 0.008])
"""The stripes' middle is known better upwards than sideways, where shading moves it."""
SIDEWAYS_SHIFTS = np.linspace(-0.12, 0.12, 13)
FINE_SCALES = np.linspace(0.97, 1.03, 13)
FINE_SHIFTS = np.linspace(-0.012, 0.012, 5)
WIDTH_FACTORS = np.linspace(0.7, 1.4, 29)
INSIDE_MIN = 0.4
"""Share of the outline that must lie in the picture to be judged."""

SUPPORT_RAMP, WHITE_RAMP, RED_RAMP = (0.28, 0.80), (0.70, 0.95), (0.30, 0.70)
"""Shares that are worth nothing, and everything: between what pins and what red things beside white ones reach."""
HOPELESSLY_COLOURED = 0.3
"""Less white than this at the place proposed is not worth a search."""
WHITE_SPREAD_MAX = 40
WHITE_LEVEL_MIN = 130
RED_MIN = 30


def _outline() -> tuple[FloatArray, FloatArray]:
    """Points (2 n, 2) and outward normals of both sides and the head, the anchor at (0, 0), v down, height 1."""
    heights = np.concatenate([np.linspace(0.02, 0.90, 30), 0.90 + 0.10 * np.sin(np.linspace(0.1, 1.5, 7))])
    half = 0.5 * ASPECT * bowling_pin.width_at(heights)
    step = 0.01
    slope = (
        0.5
        * ASPECT
        * (bowling_pin.width_at(np.minimum(heights + step, 1.0)) - bowling_pin.width_at(heights - step))
    ) / (np.minimum(heights + step, 1.0) - heights + step)
    slope[heights < 2 * step] = slope[heights >= 2 * step][0]
    length = np.sqrt(1.0 + slope**2)
    points = np.stack([half, STRIPES_MIDDLE - heights], axis=1)
    normals = np.stack([1.0 / length, slope / length], axis=1)
    mirror = np.array([-1.0, 1.0])
    foot_half = 0.5 * ASPECT * float(bowling_pin.width_at(np.array([0.0]))[0])
    foot = np.stack([np.linspace(-0.8, 0.8, 6) * foot_half, np.full(6, STRIPES_MIDDLE)], axis=1)
    foot_normals = np.tile(np.array([0.0, 1.0]), (6, 1))
    return (
        np.concatenate([points, points * mirror, foot]),
        np.concatenate([normals, normals * mirror, foot_normals]),
    )


def _inner(heights: FloatArray) -> FloatArray:
    """Points inside the body at these heights, relative to the anchor."""
    across = np.array([-0.6, -0.25, 0.25, 0.6])
    half = 0.5 * ASPECT * bowling_pin.width_at(heights)
    u = (half[:, None] * across).ravel()
    return np.stack([u, np.repeat(STRIPES_MIDDLE - heights, across.size)], axis=1)


OUTLINE, NORMALS = _outline()
BELLY = np.flatnonzero(np.abs(OUTLINE[:, 0]) > 0.35 * ASPECT)
WHITE_POINTS = _inner(np.concatenate([np.linspace(0.06, 0.58, 12), np.linspace(0.80, 0.94, 4)]))
RED_POINTS = _inner(np.array([center for center, _ in bowling_pin.STRIPES]))


@dataclass(frozen=True)
class PinFit:
    """The outline at its best place, in the picture: axis, middle of the stripes, height and width, pixels.

    `support` is the share of the outline that lies on an edge, `white` and `red` the shares of the body and of the
    stripes that have their colour. All count only what lies inside of the picture.
    """

    u_px: float
    anchor_v_px: float
    height_px: float
    width_px: float
    support: float
    white: float
    red: float

    @property
    def top_px(self) -> float:
        return self.anchor_v_px - (1.0 - STRIPES_MIDDLE) * self.height_px

    @property
    def bottom_px(self) -> float:
        return self.anchor_v_px + STRIPES_MIDDLE * self.height_px

    @property
    def score(self) -> float:
        """0 to 1. A product, so that nothing makes up for what is missing."""
        shares = ((self.support, SUPPORT_RAMP), (self.white, WHITE_RAMP), (self.red, RED_RAMP))
        return math.prod(min(max((share - low) / (high - low), 0.0), 1.0) for share, (low, high) in shares)


class _Patch:
    """The neighbourhood of a proposal: its gradient, and which of it lies in the picture."""

    def __init__(self, image_bgr: ImageBgr, find: StripeFind) -> None:
        self.scale = PATCH_PIN_PX / find.pin_height_px
        self._origin = np.array([find.u_px, find.v_px])
        # Pixel middles lie at .5 in continuous coordinates, at whole numbers in warpAffine's.
        shift = np.array(ANCHOR) - 0.5 - self.scale * (self._origin - 0.5)
        matrix = np.array([[self.scale, 0.0, shift[0]], [0.0, self.scale, shift[1]]])
        self.bgr = cv2.warpAffine(
            image_bgr,
            matrix,
            (PATCH_WIDTH, PATCH_HEIGHT),
            flags=cv2.INTER_LINEAR,
            borderMode=cv2.BORDER_REPLICATE,
        )
        blue, green, red = cv2.split(self.bgr)
        whiteness = cv2.GaussianBlur(cv2.min(cv2.min(blue, green), red), (5, 5), 1.0)
        self.gradient_u = cv2.Sobel(whiteness, cv2.CV_32F, 1, 0, ksize=3, scale=0.125)
        self.gradient_v = cv2.Sobel(whiteness, cv2.CV_32F, 0, 1, ksize=3, scale=0.125)
        rows, columns = image_bgr.shape[:2]
        corners = np.array([[0.0, 0.0], [columns, rows]])
        self._low, self._high = (corners - self._origin) * self.scale + np.array(ANCHOR)

    def lookup(self, points: FloatArray) -> tuple[NDArray[np.int32], NDArray[np.int32], NDArray[np.bool_]]:
        """Rows, columns and "inside of picture and patch" for patch points (..., 2)."""
        u, v = points[..., 0], points[..., 1]
        inside = (u >= max(self._low[0], 0.0)) & (u < min(self._high[0], PATCH_WIDTH))
        inside &= (v >= max(self._low[1], 0.0)) & (v < min(self._high[1], PATCH_HEIGHT))
        columns = np.clip(u, 0, PATCH_WIDTH - 1).astype(np.int32)
        rows = np.clip(v, 0, PATCH_HEIGHT - 1).astype(np.int32)
        return rows, columns, inside

    def edges(self, points: FloatArray, normals: FloatArray) -> tuple[FloatArray, NDArray[np.bool_]]:
        """The capped gradient across the outline at patch points (..., n, 2), and which of them are inside."""
        rows, columns, inside = self.lookup(points)
        across = (
            self.gradient_u[rows, columns] * normals[:, 0] + self.gradient_v[rows, columns] * normals[:, 1]
        )
        return np.minimum(np.abs(across), EDGE_CAP), inside

    def worth(self, points: FloatArray, normals: FloatArray) -> FloatArray:
        """Mean edge of each pose (..., n, 2) over what is inside; 0 where too little is."""
        edge, inside = self.edges(points, normals)
        count = inside.sum(axis=-1)
        mean = (edge * inside).sum(axis=-1) / np.maximum(count, 1)
        return np.where(count >= INSIDE_MIN * points.shape[-2], mean, 0.0)

    def to_picture(self, u: float, v: float) -> tuple[float, float]:
        u_px, v_px = self._origin + (np.array([u, v]) - np.array(ANCHOR)) / self.scale
        return float(u_px), float(v_px)


def fit_pin(image_bgr: ImageBgr, find: StripeFind) -> PinFit | None:
    """The best pin near a proposal; None if too little of it would be in the picture or it is nowhere near white."""
    patch = _Patch(image_bgr, find)
    pose = (*ANCHOR, PATCH_PIN_PX)
    if _share_white(patch, pose) < HOPELESSLY_COLOURED:
        return None
    u_shifts = SIDEWAYS_SHIFTS if find.sideways else COARSE_SHIFTS
    pose = _best(patch, pose, COARSE_SCALES, u_shifts, UPRIGHT_SHIFTS)
    pose = _best(patch, pose, FINE_SCALES, FINE_SHIFTS, 0.5 * UPRIGHT_SHIFTS)
    u, v, height = pose
    points = np.array([u, v]) + OUTLINE * height
    edge, inside = patch.edges(points, NORMALS)
    if inside.sum() < INSIDE_MIN * inside.size:
        return None
    u_px, v_px = patch.to_picture(u, v)
    return PinFit(
        u_px=u_px,
        anchor_v_px=v_px,
        height_px=height / patch.scale,
        width_px=_width(patch, pose) / patch.scale,
        support=float((edge[inside] > EDGE_SEEN / max(patch.scale, 1.0)).mean()),
        white=_share_white(patch, pose),
        red=_share_red(patch, pose),
    )


def _best(
    patch: _Patch,
    pose: tuple[float, float, float],
    scales: FloatArray,
    u_shifts: FloatArray,
    v_shifts: FloatArray,
) -> tuple[float, float, float]:
    """The pose (u, v, height) of the grid round `pose` that is worth most; shifts are shares of the height."""
    u, v, height = pose
    heights, shift_u, shift_v = (grid.ravel() for grid in np.meshgrid(height * scales, u_shifts, v_shifts))
    origins = np.stack([u + shift_u * height, v + shift_v * height], axis=1)
    worth = patch.worth(origins[:, None, :] + OUTLINE * heights[:, None, None], NORMALS)
    best = int(np.argmax(worth))
    return float(origins[best, 0]), float(origins[best, 1]), float(heights[best])


def _width(patch: _Patch, pose: tuple[float, float, float]) -> float:
    """The width at which the belly's sides lie on edges, with axis and height as they are."""
    u, v, height = pose
    belly = OUTLINE[BELLY] * height
    poses = np.stack([belly * np.array([factor, 1.0]) for factor in WIDTH_FACTORS]) + np.array([u, v])
    worth = patch.worth(poses, NORMALS[BELLY])
    return float(WIDTH_FACTORS[int(np.argmax(worth))] * ASPECT * height)


def _colours(patch: _Patch, pose: tuple[float, float, float], points: FloatArray) -> NDArray[np.int16]:
    u, v, height = pose
    rows, columns, inside = patch.lookup(np.array([u, v]) + points * height)
    return patch.bgr[rows[inside], columns[inside]].astype(np.int16)


def _share_white(patch: _Patch, pose: tuple[float, float, float]) -> float:
    colours = _colours(patch, pose, WHITE_POINTS)
    if colours.size == 0:
        return 0.0
    low, high = colours.min(axis=1), colours.max(axis=1)
    return float(((high - low <= WHITE_SPREAD_MAX) & (high >= WHITE_LEVEL_MIN)).mean())


def _share_red(patch: _Patch, pose: tuple[float, float, float]) -> float:
    colours = _colours(patch, pose, RED_POINTS)
    if colours.size == 0:
        return 0.0
    return float((colours[:, 2] - np.maximum(colours[:, 0], colours[:, 1]) >= RED_MIN).mean())
