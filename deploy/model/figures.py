"""Things without an axis that might be taken for a pin: people, signs, red and white bars, pieces of pins."""

from __future__ import annotations

import math

import cv2
import numpy as np
from numpy.typing import NDArray

from deploy.model.bodies import Sprite

Rng = np.random.Generator
CANVAS = 160


def a_figure(rng: Rng) -> Sprite:
    """A cut-out of `CANVAS` pixels height, standing on its lower edge."""
    width = int(rng.integers(24, 120))
    colour = np.zeros((CANVAS, width, 3), np.float32)
    mask = np.zeros((CANVAS, width), np.uint8)
    (_person, _bars, _sign, _blob)[int(rng.integers(4))](rng, colour, mask)
    shade = np.linspace(rng.uniform(0.6, 1.1), rng.uniform(0.6, 1.1), width, dtype=np.float32)[None, :, None]
    colour = np.clip(colour * shade + rng.normal(0, 4, colour.shape), 0, 255)
    bgra = np.dstack([colour * (mask[:, :, None] / 255.0), mask]).astype(np.float32)
    levels = [np.rint(bgra).astype(np.uint8)]
    while min(levels[-1].shape[:2]) > 6:
        rows, columns = levels[-1].shape[:2]
        levels.append(cv2.resize(levels[-1], (columns // 2, rows // 2), interpolation=cv2.INTER_AREA))
    return Sprite(
        tuple(levels), (0.5 * width, float(CANVAS)), float(CANVAS), np.zeros((0, 2), np.float32), False
    )


def _any(rng: Rng) -> list[float]:
    kind = rng.random()
    if kind < 0.35:
        return (np.full(3, rng.uniform(190, 250)) + rng.normal(0, 6, 3)).tolist()
    if kind < 0.6:
        return [float(rng.uniform(20, 80)), float(rng.uniform(20, 80)), float(rng.uniform(140, 240))]
    return rng.uniform(0, 255, 3).tolist()


def _person(rng: Rng, colour: NDArray[np.float32], mask: NDArray[np.uint8]) -> None:
    width = mask.shape[1]
    u, head = width // 2, int(rng.integers(8, 16))
    shoulder, hip = 2 * head + int(rng.integers(0, 8)), int(rng.uniform(0.5, 0.65) * CANVAS)
    half = int(min(rng.uniform(0.9, 2.0) * head, 0.48 * width))
    waist = int(half * rng.uniform(0.6, 1.0))
    body = np.int32([(u - half, shoulder + 6), (u - half // 2, shoulder), (u + half // 2, shoulder),
                     (u + half, shoulder + 6), (u + waist, hip), (u - waist, hip)])  # fmt: skip
    for target, skin, shirt, legs in ((colour, _any(rng), _any(rng), _any(rng)), (mask, 255, 255, 255)):
        for side in (-1, 1):
            cv2.line(
                target, (u + side * waist // 2, hip), (u + side * half // 2, CANVAS), legs, max(waist // 2, 2)
            )
            if rng.random() < 0.8:
                cv2.line(
                    target, (u + side * half, shoulder + 6), (u + side * half, hip), shirt, max(half // 3, 2)
                )
        cv2.fillPoly(target, [body], shirt)
        cv2.ellipse(target, (u, head), (int(head * 0.8), head), 0, 0, 360, skin, -1)


def _bars(rng: Rng, colour: NDArray[np.float32], mask: NDArray[np.uint8]) -> None:
    """A pole, barrier or rolled banner with bands, level or aslant."""
    width = mask.shape[1]
    half = int(rng.uniform(0.08, 0.45) * width) + 1
    mask[int(rng.integers(0, 20)) :, width // 2 - half : width // 2 + half] = 255
    first, second = _any(rng), _any(rng)
    period, slant = rng.uniform(8, 80), rng.choice([0.0, 0.0, rng.uniform(-1.5, 1.5)])
    y, x = np.mgrid[0:CANVAS, 0:width]
    colour[:] = np.where((np.mod(y + slant * x, period) < 0.5 * period)[:, :, None], first, second)


def _sign(rng: Rng, colour: NDArray[np.float32], mask: NDArray[np.uint8]) -> None:
    """A disc, triangle or board on a post."""
    width = mask.shape[1]
    u, r = width // 2, int(0.45 * width)
    corners = np.int32([(u, 0), (u + r, 2 * r), (u - r, 2 * r)])
    kind = int(rng.integers(3))
    rim, face, post = _any(rng), _any(rng), _any(rng)
    for target, colours in ((colour, (post, rim, face)), (mask, (255, 255, 255))):
        cv2.line(target, (u, r), (u, CANVAS), colours[0], max(r // 6, 2))
        for share, c in ((1.0, colours[1]), (0.7, colours[2])):
            if kind == 0:
                cv2.circle(target, (u, r), int(r * share), c, -1)
            elif kind == 1:
                middle = corners.mean(axis=0)
                cv2.fillPoly(target, [np.int32(middle + share * (corners - middle))], c)
            else:
                reach = int(r * share)
                cv2.rectangle(target, (u - reach, r - reach), (u + reach, r + reach), c, -1)


def _blob(rng: Rng, colour: NDArray[np.float32], mask: NDArray[np.uint8]) -> None:
    """A soft shape of no name, plain or with one band."""
    width = mask.shape[1]
    angles = np.linspace(0, 2 * math.pi, 24, endpoint=False)
    reach = 1.0 + sum(rng.normal(0, 0.25 / k) * np.cos(k * angles + rng.uniform(0, 6.3)) for k in range(1, 6))
    reach = np.clip(reach / reach.max(), 0.1, 1)
    points = np.stack(
        [0.5 * width * (1 + reach * np.cos(angles)), 0.5 * CANVAS * (1 + reach * np.sin(angles))], 1
    )
    cv2.fillPoly(mask, [np.int32(points)], 255, cv2.LINE_AA)
    colour[:] = _any(rng)
    if rng.random() < 0.5:
        row = int(rng.integers(0, CANVAS))
        colour[row : row + int(rng.integers(4, 40))] = _any(rng)
