"""What the route planner remembers beyond what the view still holds.

The view's obstacles end a little beyond the look-ahead and forget after seconds what is hidden. A planner that forgets a
wall it has just turned away from drives back to it. So cells are remembered for longer here; within the look-ahead the
view is the authority, and what it no longer holds is dropped.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from target_nav.state.types import FloatArray

_CELL_M = 0.05
_STRIDE = 1 << 24
_MEMORY_S = 30.0
_FORGET_BEYOND_M = 4.0


class RouteMemory:
    """Points in odom, one a cell, each with the time it was last in the view."""

    def __init__(self, authority_m: float) -> None:
        """`authority_m`: within this distance of the robot the view is complete."""
        self._authority_m = authority_m
        self.clear()

    def clear(self) -> None:
        self._keys: NDArray[np.int64] = np.empty(0, dtype=np.int64)
        self._points_m: FloatArray = np.empty((0, 2))
        self._seen_s: FloatArray = np.empty(0)

    def update(self, now_s: float, robot_m: tuple[float, float], points_in_odom_m: FloatArray) -> FloatArray:
        """Take the view's points, shape (N, 2), and return all that are remembered, shape (M, 2)."""
        away = np.hypot(self._points_m[:, 0] - robot_m[0], self._points_m[:, 1] - robot_m[1])
        keep = (away > self._authority_m) & (away < _FORGET_BEYOND_M) & (now_s - self._seen_s < _MEMORY_S)
        cells = np.floor(points_in_odom_m / _CELL_M).astype(np.int64)
        keys = np.concatenate([cells[:, 0] * _STRIDE + cells[:, 1], self._keys[keep]])
        points = np.concatenate([points_in_odom_m, self._points_m[keep]])
        seen = np.concatenate([np.full(len(cells), now_s), self._seen_s[keep]])
        # np.unique keeps the first of equal keys: the newest.
        self._keys, first = np.unique(keys, return_index=True)
        self._points_m, self._seen_s = points[first], seen[first]
        return self._points_m

    def forget_near(self, robot_m: tuple[float, float], radius_m: float) -> None:
        """Drop what lies within `radius_m` of a point: for recoveries, in case it was never there."""
        away = np.hypot(self._points_m[:, 0] - robot_m[0], self._points_m[:, 1] - robot_m[1])
        keep = away > radius_m if math.isfinite(radius_m) else np.zeros(len(away), dtype=np.bool_)
        self._keys, self._points_m, self._seen_s = self._keys[keep], self._points_m[keep], self._seen_s[keep]
