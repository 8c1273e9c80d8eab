"""A way round what is known: a small cost-to-go plan over obstacle points, and the next point to steer for.

VFH alone is trapped by a box that is wider than its look-ahead and cannot prefer one side to the other for good. This
planner looks sixteen metres across, several times a second, and hands the avoidance a point that it can see.
Everything is in odom; the grid is centred on the robot anew for each plan.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from target_nav.config import Config
from target_nav.nav.footprint import Footprint
from target_nav.nav.lidar_noise import range_sigma_m
from target_nav.nav.wavefront import Discs, dilate, inner, spread, to_bits, to_grid
from target_nav.state.types import FloatArray

CELL_M = 0.05
_SIDE = 321
_HALF = _SIDE // 2
_CENTRE = _HALF * _SIDE + _HALF
_NEAR_SPOT_CELLS = 4
_BAND_CELLS = 16
"""Ways to many spots are only compared, so 0.8 m is fine enough."""
_COMFORT_M = 0.12
"""Wider than the turning body by this: keeping it costs nothing, less costs double."""
_FREE, _NEAR, _CLOSE, _TIGHT = 1, 2, 4, 8
"""Cost of a cell: free; the body can turn there; it can just turn there; it only fits with its front along the way."""
_DOUBT_SIGMAS, _DOUBTS_M = 2.0, (0.0, 0.01, 0.02, 0.03, 0.04)
"""Benefit of the doubt for a gap that is seen from afar."""
_LOST_TO_CELLS_M = 0.5 * CELL_M
"""A point may lie half a cell from its cell's centre."""
_START_M = 0.30
"""So near to the robot a cell counts as passable if it is no nearer to an obstacle than the robot already is."""
_SIGHT_M = 1.5
_SAME_WAY_M = 0.35
_DOUBTS = 2
"""So many plans in a row must find the present way blocked before another side is taken: one may be noise."""
_SWITCH_SHARE = 0.8
"""Another way round must be this much cheaper than the present one, or two equal ways would alternate."""

CellPath = NDArray[np.intp]
"""Columns and rows of neighbouring cells, shape (V, 2)."""


@dataclass(frozen=True, eq=False)
class Route:
    """Points in odom, shape (V, 2), from the robot to a goal; its cost counts tight places several times."""

    points_m: FloatArray
    cost_m: float
    length_m: float
    sight: int
    """Index of the farthest point that can be steered for in a straight line."""

    @property
    def next_m(self) -> tuple[float, float]:
        return float(self.points_m[self.sight, 0]), float(self.points_m[self.sight, 1])


class RoutePlanner:
    """Keeps the present route, so that a new plan does not change sides for nothing."""

    def __init__(self, config: Config) -> None:
        body = Footprint.of(config.robot)
        self._fits_m = fits_m = config.robot.half_width_m + config.avoid.stop_clearance_m
        just_turns_m = body.circumscribed_radius_m + config.avoid.stop_clearance_m
        self._fits, self._just_turns = (
            Discs([max(radius_m - doubt_m, 0.0) / CELL_M for doubt_m in _DOUBTS_M], _SIDE)
            for radius_m in (fits_m, just_turns_m)
        )
        self._turns_m = body.circumscribed_radius_m + config.avoid.margin_m + _LOST_TO_CELLS_M
        self._comfort_m = self._turns_m + _COMFORT_M
        self._pad = math.ceil(self._comfort_m / CELL_M) + 1
        self._inner = inner(_SIDE)
        self._window_m = (_HALF - self._pad) * CELL_M
        self.route: Route | None = None
        self._doubts = 0

    def reset(self) -> None:
        self.route = None
        self._doubts = 0

    def plan(
        self, points_in_odom_m: FloatArray, start_m: tuple[float, float], goals_m: FloatArray, limit_m: float
    ) -> Route | None:
        """The cheapest way from `start_m` to any goal, at most `limit_m` in cost; also kept in `route`.

        `goals_m` has shape (M, 3): x, y, and a cost for ending there. Goals outside the window are stood for by the
        window's rim. None: no way.
        """
        start = np.array(start_m)
        steps, cost_grid = self._costs(
            points_in_odom_m - start if len(points_in_odom_m) else points_in_odom_m
        )
        goals = self._goal_bits(goals_m, start)
        wave, reached = spread(_SIDE, steps, goals, 1 << _CENTRE, int(limit_m / CELL_M))
        if not reached:
            self.route = None
            return None
        cells = np.array(wave.descend(_CENTRE))
        path = np.column_stack([cells % _SIDE, cells // _SIDE])
        chosen = self._choose(path, cost_grid, goals, start)
        if chosen is None:
            return self.route
        path = chosen
        points = (path - _HALF) * CELL_M + start
        length = float(_step_lengths(path).sum()) * CELL_M
        cost = float(_so_far(path, cost_grid)[-1]) * CELL_M
        self.route = Route(points, cost, length, _sight(path, cost_grid))
        return self.route

    def cost_grid(self, points_in_odom_m: FloatArray, start_m: tuple[float, float]) -> NDArray[np.uint8]:
        """The cost of each cell round `start_m`, 0 where the body does not fit; row is y, column is x."""
        return self._costs(points_in_odom_m - np.array(start_m))[1]

    def costs_to(
        self, points_in_odom_m: FloatArray, start_m: tuple[float, float], spots_m: FloatArray, limit_m: float
    ) -> FloatArray:
        """What it costs to come near to each spot, shape (K,) for (K, 2); infinite if there is no way.

        Of a spot outside the window nothing is known: it costs `limit_m`.
        """
        start = np.array(start_m)
        steps, _ = self._costs(points_in_odom_m - start if len(points_in_odom_m) else points_in_odom_m)
        wave, _ = spread(_SIDE, steps, [(0, 1 << _CENTRE)], 0, int(limit_m / CELL_M))
        index = _cells(spots_m - start)
        inside = _within(index, self._pad)
        costs = np.full(len(spots_m), limit_m)
        near = wave.costs_near(index[inside, 1], index[inside, 0], _NEAR_SPOT_CELLS, _BAND_CELLS)
        costs[inside] = np.where(near >= 0, near * CELL_M, math.inf)
        return costs

    def _costs(self, points_m: FloatArray) -> tuple[list[tuple[int, int]], NDArray[np.uint8]]:
        """The grid's cost classes as bits and as numbers (0: blocked), for points relative to the robot."""
        occupied = np.zeros((_SIDE, _SIDE), dtype=np.bool_)
        nearest_m = math.inf
        near = points_m
        if len(points_m):
            near = points_m[np.abs(points_m).max(axis=1) < self._window_m]
            index = _cells(near)
            occupied[index[:, 1], index[:, 0]] = True
            nearest_m = float(np.hypot(points_m[:, 0], points_m[:, 1]).min())
        radii = [self._turns_m, self._comfort_m]
        inside = nearest_m < self._fits_m + CELL_M
        if inside:
            radii.append(nearest_m - 2.0 * CELL_M)
        grown = dilate(to_bits(occupied), _SIDE, [radius / CELL_M for radius in radii])
        level = self._doubt_levels(near)
        at = near / CELL_M + _HALF
        blocked, close = (to_bits(discs.of(at, level)) for discs in (self._fits, self._just_turns))
        if inside:
            about = dilate(1 << (_HALF * _SIDE + _HALF), _SIDE, [_START_M / CELL_M])[0]
            blocked &= ~(about & ~grown[2])
        free = self._inner & ~grown[1] & ~blocked
        near_bits = grown[1] & ~grown[0] & ~blocked & self._inner
        inside_bits = grown[0] & ~blocked & self._inner
        steps = [
            (_FREE, free),
            (_NEAR, near_bits),
            (_CLOSE, inside_bits & ~close),
            (_TIGHT, inside_bits & close),
        ]
        grid = np.zeros((_SIDE, _SIDE), dtype=np.uint8)
        for cost, cells in steps:
            grid[to_grid(cells, _SIDE)] = cost
        return steps, grid

    def _doubt_levels(self, points_m: FloatArray) -> NDArray[np.intp]:
        """Index into `_DOUBTS_M` of how much nearer to each point base_link may come; points relative to the robot."""
        # Noise makes a far gap look narrower than it is. Going nearer shows; closing it for that would be for good.
        sigma_m = range_sigma_m(np.hypot(points_m[:, 0], points_m[:, 1]))
        return np.searchsorted(_DOUBTS_M[1:], _DOUBT_SIGMAS * sigma_m, side="right")

    def _goal_bits(self, goals_m: FloatArray, start: FloatArray) -> list[tuple[int, int]]:
        """Goals as (extra cost, cells)."""
        index = _cells(goals_m[:, :2] - start)
        extra = np.rint(goals_m[:, 2] / CELL_M).astype(np.intp)
        inside = _within(index, self._pad)
        if not inside.any():
            return self._rim(goals_m, start)
        grouped: dict[int, int] = {}
        for (column, row), cost in zip(index[inside].tolist(), extra[inside].tolist()):
            grouped[cost] = grouped.get(cost, 0) | 1 << (row * _SIDE + column)
        return list(grouped.items())

    def _rim(self, goals_m: FloatArray, start: FloatArray) -> list[tuple[int, int]]:
        """For goals out of the window: a circle inside it, each point charged with its distance to the nearest goal."""
        angle = np.linspace(-math.pi, math.pi, 180, endpoint=False)
        radius = self._window_m - 0.05
        ring = radius * np.column_stack([np.cos(angle), np.sin(angle)])
        to_goal = np.hypot(*(goals_m[None, :, :2] - start - ring[:, None, :]).transpose(2, 0, 1)).min(axis=1)
        # Twice, for the wave's own metric is a few percent off and would pull towards the diagonals.
        extra = 2.0 * (to_goal - to_goal.min())
        keep = extra < 2.0 * radius
        local = np.column_stack([ring[keep] + start, extra[keep]])
        return self._goal_bits(local, start)

    def _choose(
        self, path: CellPath, cost_grid: NDArray[np.uint8], goals: list[tuple[int, int]], start: FloatArray
    ) -> CellPath | None:
        """`path`, or the rest of the present route if that is another way and nearly as good.

        None: the present route, another way, seems blocked all of a sudden; wait and see for a moment.
        """
        if self.route is None or len(self.route.points_m) < 2:
            return path
        offsets = self.route.points_m - start
        first = int(np.hypot(offsets[:, 0], offsets[:, 1]).argmin())
        rest = _cells(offsets[first:])
        if len(rest) < 2 or rest.min() < 1 or rest.max() >= _SIDE - 1:
            return path
        apart = np.abs(rest[::3, None, :] - path[None, ::3, :]).max(axis=2).min(axis=1).max() * CELL_M
        if apart < _SAME_WAY_M:
            self._doubts = 0
            return path
        if not cost_grid[rest[:, 1], rest[:, 0]].all() or not _near_goal(rest[-1], goals):
            self._doubts += 1
            return None if self._doubts <= _DOUBTS else path
        self._doubts = 0
        joined: CellPath = np.vstack([np.full((1, 2), _HALF, dtype=np.intp), rest])
        mine, other = _so_far(joined, cost_grid)[-1], _so_far(path, cost_grid)[-1]
        return path if other < _SWITCH_SHARE * mine - 2.0 else joined


def _cells(offsets_m: FloatArray) -> CellPath:
    """Column and row of points relative to the robot; what is far out of the grid stays out of it."""
    index: CellPath = np.rint(np.clip(offsets_m / CELL_M, -2.0 * _SIDE, 2.0 * _SIDE)).astype(np.intp) + _HALF
    return index


def _within(index: CellPath, border: int) -> NDArray[np.bool_]:
    """Which cells lie off the grid's border by so much."""
    within: NDArray[np.bool_] = (np.min(index, axis=1) >= border) & (np.max(index, axis=1) < _SIDE - border)
    return within


def _step_lengths(path: CellPath) -> FloatArray:
    steps: FloatArray = np.hypot(*np.diff(path, axis=0).T) if len(path) > 1 else np.zeros(0)
    return steps


def _so_far(path: CellPath, cost_grid: NDArray[np.uint8]) -> FloatArray:
    """Cost in cells from the path's start to each of its cells."""
    charge = cost_grid[path[1:, 1], path[1:, 0]]
    return np.concatenate([[0.0], np.cumsum(charge * _step_lengths(path))])


def _sight(path: CellPath, cost_grid: NDArray[np.uint8]) -> int:
    """Index of the farthest cell whose straight line from the robot costs no more than the path there."""
    so_far = _so_far(path, cost_grid)
    away = np.hypot(path[:, 0] - _HALF, path[:, 1] - _HALF) * CELL_M
    beyond = np.flatnonzero(away > _SIGHT_M)
    last = int(beyond[0]) if len(beyond) else len(path) - 1
    for index in range(last, 1, -3):
        if _line_cost(path[index], cost_grid) <= 1.02 * so_far[index] + 0.5:
            return index
    return min(1, last)


def _window(column: int, row: int, reach: int) -> int:
    """The square of cells within `reach` of one."""
    line = ((1 << (2 * reach + 1)) - 1) << max(column - reach, 0)
    cells = 0
    for at in range(max(row - reach, 0), row + reach + 1):
        cells |= line << (at * _SIDE)
    return cells


def _near_goal(cell: NDArray[np.intp], goals: list[tuple[int, int]]) -> bool:
    window = _window(int(cell[0]), int(cell[1]), _NEAR_SPOT_CELLS)
    return any(cells & window for _, cells in goals)


def _line_cost(cell: NDArray[np.intp], cost_grid: NDArray[np.uint8]) -> float:
    """Cost in cells of the straight line from the robot, infinite if it is blocked."""
    dx, dy = float(cell[0] - _HALF), float(cell[1] - _HALF)
    length = math.hypot(dx, dy)
    count = max(int(2.0 * length), 1)
    share = (np.arange(count) + 1.0) / count
    columns = np.rint(_HALF + share * dx).astype(np.intp)
    rows = np.rint(_HALF + share * dy).astype(np.intp)
    charge = cost_grid[rows, columns]
    return float(charge.sum()) * length / count if charge.all() else math.inf
