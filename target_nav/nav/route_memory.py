"""What the route planner remembers beyond what the view still holds.

The view's obstacles end at their radius and forget after seconds what is hidden behind something nearer. A planner
that forgets a wall as soon as a box hides it sees a way through it. So points are remembered for longer here, unless
the view looks through them or shows them a little elsewhere.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from target_nav.nav.sight_lines import nearest_by_direction_m
from target_nav.state.types import FloatArray

_CELL_M = 0.05
_STRIDE = 1 << 24
_MEMORY_S = 240.0
_UNSEEN_S = 10.0
"""In a direction without any return nothing speaks against a point but its age."""
_FORGET_BEYOND_M = 11.0
_REACH_SLACK_M = 0.1
_SECTORS = 120
_THROUGH_M = 0.10
"""A view whose nearest point lies so much farther off has looked through."""
_HIDDEN_BEHIND_M = 0.15
_SAME_M = 0.10
"""A point this near to one in view is the same surface, drawn a little elsewhere by odometry's drift."""
_OLD_S = 15.0
"""A point older than this is superseded by one in view up to a cell farther off, hidden or not: after some metres drift
draws the sides of a passage elsewhere, and old and new together shut it."""
_LEFT_OUT_M = 0.35
"""More than the tracker's gate and the target's radius."""
_GRID = round(2.0 * (_FORGET_BEYOND_M + 1.0) / _SAME_M)


class RouteMemory:
    """Points in odom, one a cell, each with the time it was last in the view."""

    def __init__(self, least_m: float, most_m: float) -> None:
        """The view's obstacles reach at least and at most so far from the robot; how far, their points show."""
        self._most_m = most_m
        self.reach_m = least_m
        """So far off the view has shown obstacles: where it shows none within, there are none."""
        self.clear()

    def clear(self) -> None:
        self._keys: NDArray[np.int64] = np.empty(0, dtype=np.int64)
        self._points_m: FloatArray = np.empty((0, 2))
        self._seen_s: FloatArray = np.empty(0)

    def update(
        self,
        now_s: float,
        robot_m: tuple[float, float],
        points_in_odom_m: FloatArray,
        target_m: tuple[float, float] | None = None,
    ) -> FloatArray:
        """Take the view's points, shape (N, 2), and return all that are remembered, shape (M, 2).

        Round `target_m` the view leaves out the target's points, and others with them: there it speaks against nothing.
        """
        if len(points_in_odom_m):
            away = np.hypot(points_in_odom_m[:, 0] - robot_m[0], points_in_odom_m[:, 1] - robot_m[1])
            self.reach_m = min(max(self.reach_m, float(away.max()) - _REACH_SLACK_M), self._most_m)
            points_in_odom_m = points_in_odom_m[away < _FORGET_BEYOND_M]
        keep = self._still_hold(now_s, robot_m, points_in_odom_m)
        if target_m is not None and len(keep):
            near = (
                np.hypot(self._points_m[:, 0] - target_m[0], self._points_m[:, 1] - target_m[1]) < _LEFT_OUT_M
            )
            keep |= near & (now_s - self._seen_s < _MEMORY_S)
        cells = np.floor(points_in_odom_m / _CELL_M).astype(np.int64)
        keys = np.concatenate([cells[:, 0] * _STRIDE + cells[:, 1], self._keys[keep]])
        points = np.concatenate([points_in_odom_m, self._points_m[keep]])
        seen = np.concatenate([np.full(len(cells), now_s), self._seen_s[keep]])
        # np.unique keeps the first of equal keys: the newest.
        self._keys, first = np.unique(keys, return_index=True)
        self._points_m, self._seen_s = points[first], seen[first]
        return self._points_m

    def _still_hold(
        self, now_s: float, robot_m: tuple[float, float], view_in_odom_m: FloatArray
    ) -> NDArray[np.bool_]:
        """Which remembered points nothing speaks against."""
        age_s = now_s - self._seen_s
        sector, range_m = _polar(self._points_m, robot_m)
        dx, dy = view_in_odom_m[:, 0] - robot_m[0], view_in_odom_m[:, 1] - robot_m[1]
        nearest = nearest_by_direction_m(dx, dy, _SECTORS, turn=0.5)
        around = np.minimum(nearest, np.minimum(np.roll(nearest, 1), np.roll(nearest, -1)))[sector]
        limit_s = np.where(np.isfinite(around), _MEMORY_S, _UNSEEN_S)
        looked_through = (around > range_m + _THROUGH_M) & np.isfinite(around) & (range_m < self.reach_m)
        limit_s[range_m >= self.reach_m] = _MEMORY_S
        valid = (age_s < limit_s) & ~looked_through & (range_m < _FORGET_BEYOND_M)
        hidden = around < range_m - _HIDDEN_BEHIND_M
        again, near = self._drawn_again(robot_m, view_in_odom_m)
        superseded = near & (age_s > _OLD_S)
        hold: NDArray[np.bool_] = valid & (hidden | ~again) & ~superseded
        return hold

    def _drawn_again(
        self, robot_m: tuple[float, float], view_in_odom_m: FloatArray
    ) -> tuple[NDArray[np.bool_], NDArray[np.bool_]]:
        """Which remembered points are beside one in view, and which are as near to one as drift may put them."""
        beside = np.zeros((_GRID, _GRID), dtype=np.bool_)
        beside[_grid_cells(view_in_odom_m, robot_m)] = True
        beside = _grown(beside)
        cells = _grid_cells(self._points_m, robot_m)
        return beside[cells], _grown(beside)[cells]


def _grown(cells: NDArray[np.bool_]) -> NDArray[np.bool_]:
    """By one cell to all eight sides."""
    wide = cells.copy()
    wide[1:] |= cells[:-1]
    wide[:-1] |= cells[1:]
    grown = wide.copy()
    grown[:, 1:] |= wide[:, :-1]
    grown[:, :-1] |= wide[:, 1:]
    return grown


def _grid_cells(
    points_m: FloatArray, centre_m: tuple[float, float]
) -> tuple[NDArray[np.intp], NDArray[np.intp]]:
    index = np.floor((points_m - np.array(centre_m)) / _SAME_M).astype(np.intp) + _GRID // 2
    index = np.clip(index, 0, _GRID - 1)
    return index[:, 1], index[:, 0]


def _polar(points_m: FloatArray, centre_m: tuple[float, float]) -> tuple[NDArray[np.intp], FloatArray]:
    """Sector and range of each point as seen from the centre."""
    dx, dy = points_m[:, 0] - centre_m[0], points_m[:, 1] - centre_m[1]
    sector = (
        np.floor((np.arctan2(dy, dx) + math.pi) * (_SECTORS / (2.0 * math.pi))).astype(np.intp) % _SECTORS
    )
    return sector, np.hypot(dx, dy)
