"""Way-points on an Archimedean spiral, and the spots that stand for one of them."""

from __future__ import annotations

import math

import numpy as np

from target_nav.state.types import FloatArray

_STEP_SHARE = 0.75
"""Way-points are so far apart, as a share of the spiral's spacing."""
_FIRST_SHARE = 0.75
"""The first way-point is so many spacings off: nearer, it sees little that turning on the spot did not."""
_RINGS_M = ((0.0, 1, 0.0), (0.12, 8, 0.2), (0.24, 12, 0.5))
"""Spots that stand for a way-point: radius, how many, extra cost."""


def spiral(radius_m: float, spacing_m: float) -> list[tuple[float, float]]:
    """Way-points of r = spacing * angle / 2 pi, out to `radius_m`; the first straight ahead."""
    points: list[tuple[float, float]] = []
    per_rad = spacing_m / (2.0 * math.pi)
    start = angle = 2.0 * math.pi * _FIRST_SHARE
    while (r := per_rad * angle) <= radius_m + 1e-9:
        points.append((r * math.cos(angle - start), r * math.sin(angle - start)))
        angle += _STEP_SHARE * spacing_m / math.hypot(r, per_rad)
    return points or [(radius_m, 0.0)]


def spots_round(waypoint_m: tuple[float, float]) -> FloatArray:
    rows = [
        (
            waypoint_m[0] + r * math.cos(2.0 * math.pi * i / n),
            waypoint_m[1] + r * math.sin(2.0 * math.pi * i / n),
            extra,
        )
        for r, n, extra in _RINGS_M
        for i in range(n)
    ]
    return np.array(rows)
