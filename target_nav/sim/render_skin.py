"""What hangs on walls and is printed on boxes: one picture for all upright faces of one height, side by side.

Light and skirting are painted into it, so that drawing a wall is one look-up a pixel.
"""

from __future__ import annotations

from collections.abc import Sequence

import cv2
import numpy as np
from numpy.typing import NDArray

PIXELS_PER_M = 100.0
MAX_WIDTH_PX = 30000
"""cv2.remap takes no wider picture than 32767."""
GRAIN_SIGMA = 3.0
PATTERN_M = 0.35
PATTERN_DEPTH = 0.05
"""Faint upright stripes, as plaster and panels have them: a wall of one colour would be too easy."""

Rng = np.random.Generator
Bgr = tuple[float, float, float]
Picture = NDArray[np.float32]


class Skin:
    """`image_bgr`, and where in it each face's two sides begin: `starts_px` (faces, 2), front and back."""

    def __init__(
        self,
        lengths_m: Sequence[float],
        height_m: float,
        colours_bgr: Sequence[Bgr],
        shades: NDArray[np.float64],
        skirtings_m: Sequence[float],
        things_per_m: float,
        seed: int,
        skirting_shade: float,
    ) -> None:
        """`shades` (faces, 2) is the light on the front and on the back of each face."""
        total_m = 2.0 * sum(lengths_m)
        self.pixels_per_m = min(PIXELS_PER_M, MAX_WIDTH_PX / max(total_m, 1e-6))
        scale = self.pixels_per_m
        rows = max(round(height_m * scale), 2)
        self.starts_px = np.zeros((len(lengths_m), 2))
        parts: list[NDArray[np.uint8]] = []
        at = 0
        for k, length_m in enumerate(lengths_m):
            columns = max(round(length_m * scale), 2)
            for side in range(2):
                rng = np.random.default_rng([seed, k, side])
                face = _face(rng, rows, columns, scale, colours_bgr[k], things_per_m)
                if skirtings_m[k] > 0.0:
                    face[rows - max(round(skirtings_m[k] * scale), 1) :] = (
                        np.array(colours_bgr[k]) * skirting_shade
                    )
                parts.append(np.clip(face * float(shades[k, side]), 0.0, 255.0).astype(np.uint8))
                self.starts_px[k, side] = at
                at += columns
        self.image_bgr = np.ascontiguousarray(np.concatenate(parts, axis=1))


def _face(rng: Rng, rows: int, columns: int, scale: float, colour: Bgr, things_per_m: float) -> Picture:
    x_m = np.arange(columns) / scale
    face = np.tile(np.array(colour, np.float32), (rows, columns, 1))
    face *= (1.0 - PATTERN_DEPTH * (np.mod(x_m, 2.0 * PATTERN_M) < PATTERN_M)).astype(np.float32)[
        None, :, None
    ]
    coarse = rng.normal(0.0, GRAIN_SIGMA, (max(rows // 16, 2), max(columns // 16, 2))).astype(np.float32)
    face += cv2.resize(coarse, (columns, rows), interpolation=cv2.INTER_CUBIC)[:, :, None]
    for _ in range(int(rng.poisson(things_per_m * columns / scale))):
        _hang(rng, face, scale)
    return face


def _hang(rng: Rng, face: Picture, scale: float) -> None:
    """A framed picture, a door, a socket, a shelf with books, a label: nothing of it looks like a pin."""
    rows, columns = face.shape[:2]
    kind = int(rng.integers(4))
    width_m, height_m, bottom_m = (
        (rng.uniform(0.2, 0.9), rng.uniform(0.2, 0.8), rng.uniform(0.1, 1.4)),
        (rng.uniform(0.7, 1.0), 2.0, 0.0),
        (0.08, 0.08, rng.uniform(0.2, 0.4)),
        (rng.uniform(0.4, 1.2), 0.25, rng.uniform(0.2, 1.6)),
    )[kind]
    if height_m * scale > rows or width_m * scale > columns:
        shrink = 0.6 * min(rows / (height_m * scale), columns / (width_m * scale))
        width_m, height_m, bottom_m = width_m * shrink, height_m * shrink, min(bottom_m, 0.3 * rows / scale)
    w, h = max(int(width_m * scale), 2), max(int(height_m * scale), 2)
    x, y = int(rng.integers(0, max(columns - w, 1))), max(rows - int(bottom_m * scale) - h, 0)
    colour = rng.uniform(30.0, 235.0) + rng.normal(0.0, 25.0, 3)
    face[y : y + h, x : x + w] = colour
    if kind == 0:
        inner = rng.uniform(0.0, 255.0, (4, 5, 3)).astype(np.float32)
        edge = max(int(0.03 * scale), 1)
        if w > 2 * edge + 2 and h > 2 * edge + 2:
            size = (w - 2 * edge, h - 2 * edge)
            face[y + edge : y + edge + size[1], x + edge : x + edge + size[0]] = cv2.resize(inner, size)
    elif kind == 3:
        at = x
        while at < x + w:
            wide = int(rng.integers(2, 7))
            tall = int(h * rng.uniform(0.5, 0.9))
            face[y + h - tall : y + h, at : min(at + wide, x + w)] = rng.uniform(20.0, 230.0, 3)
            at += wide
    np.clip(face, 0.0, 255.0, out=face)
