"""What the route planner remembers beyond what the view still holds.

The view's obstacles end at their radius and forget after seconds what is hidden behind something nearer. A planner that
forgets a wall as soon as a box hides it sees a way through it. So points are remembered for longer here, unless they are
in plain sight of the view and no longer there.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from target_nav.state.types import FloatArray

_CELL_M = 0.05
_STRIDE = 1 << 24
_MEMORY_S = 60.0
_FORGET_BEYOND_M = 5.0
_SECTORS = 120
_HIDDEN_BEHIND_M = 0.15


class RouteMemory:
    """Points in odom, one a cell, each with the time it was last in the view."""

    def __init__(self, radius_m: float) -> None:
        """`radius_m`: how far from the robot the view's obstacles reach."""
        self._radius_m = radius_m
        self.clear()

    def clear(self) -> None:
        self._keys: NDArray[np.int64] = np.empty(0, dtype=np.int64)
        self._points_m: FloatArray = np.empty((0, 2))
        self._seen_s: FloatArray = np.empty(0)

    def update(self, now_s: float, robot_m: tuple[float, float], points_in_odom_m: FloatArray) -> FloatArray:
        """Take the view's points, shape (N, 2), and return all that are remembered, shape (M, 2)."""
        keep = self._hidden(robot_m, points_in_odom_m) & (now_s - self._seen_s < _MEMORY_S)
        cells = np.floor(points_in_odom_m / _CELL_M).astype(np.int64)
        keys = np.concatenate([cells[:, 0] * _STRIDE + cells[:, 1], self._keys[keep]])
        points = np.concatenate([points_in_odom_m, self._points_m[keep]])
        seen = np.concatenate([np.full(len(cells), now_s), self._seen_s[keep]])
        # np.unique keeps the first of equal keys: the newest.
        self._keys, first = np.unique(keys, return_index=True)
        self._points_m, self._seen_s = points[first], seen[first]
        return self._points_m

    def _hidden(self, robot_m: tuple[float, float], points_in_odom_m: FloatArray) -> NDArray[np.bool_]:
        """Which remembered points the view cannot speak for: out of its reach, or behind something in it."""
        sector, range_m = _polar(self._points_m, robot_m)
        hidden = range_m > self._radius_m
        if len(points_in_odom_m):
            view_sector, view_range_m = _polar(points_in_odom_m, robot_m)
            nearest = np.full(_SECTORS, math.inf)
            np.minimum.at(nearest, view_sector, view_range_m)
            hidden |= nearest[sector] < range_m - _HIDDEN_BEHIND_M
        return hidden & (range_m < _FORGET_BEYOND_M)


def _polar(points_m: FloatArray, centre_m: tuple[float, float]) -> tuple[NDArray[np.intp], FloatArray]:
    """Sector and range of each point as seen from the centre."""
    dx, dy = points_m[:, 0] - centre_m[0], points_m[:, 1] - centre_m[1]
    sector = (
        np.floor((np.arctan2(dy, dx) + math.pi) * (_SECTORS / (2.0 * math.pi))).astype(np.intp) % _SECTORS
    )
    return sector, np.hypot(dx, dy)
