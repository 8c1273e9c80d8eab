"""A way round what is known: a small cost-to-go plan over obstacle points, and the next point to steer for.

VFH alone is trapped by a box that is wider than its look-ahead and cannot prefer one side to the other for good. This
planner looks sixteen metres across, several times a second, and hands the avoidance a point that it can see.
Everything is in odom; the grid is centred on the robot anew for each plan.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from target_nav.config import Config
from target_nav.nav.route_grid import (
    CELL_M,
    NEAR_SPOT_CELLS,
    CellPath,
    CostGrid,
    RouteGrid,
    Steps,
    so_far,
    step_lengths,
)
from target_nav.nav.wavefront import spread
from target_nav.state.types import FloatArray

_SIDES = (161, 321)
"""Eight metres across, and sixteen where the goals are farther off or there is no way within eight."""
_BAND_CELLS = 16
"""Ways to many spots are only compared, so 0.8 m is fine enough."""
_SAME_WAY_M = 0.35
_DOUBTS = 2
"""So many plans in a row must find the present way blocked before another side is taken: one may be noise."""
_SWITCH_SHARE = 0.8
"""Another way round must be this much cheaper than the present one, or two equal ways would alternate."""


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
        self._grids = tuple(RouteGrid(config, side) for side in _SIDES)
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
        points = points_in_odom_m - start if len(points_in_odom_m) else points_in_odom_m
        *smaller, largest = self._grids
        for grid in smaller:
            if self._holds(grid, goals_m, start) and self._plan_on(grid, points, start, goals_m, limit_m):
                return self.route
        if not self._plan_on(largest, points, start, goals_m, limit_m):
            self.route = None
        return self.route

    def _holds(self, grid: RouteGrid, goals_m: FloatArray, start: FloatArray) -> bool:
        """Whether the goals, and the present route, lie well within the grid."""
        spots = [goals_m[:, :2]] if self.route is None else [goals_m[:, :2], self.route.points_m]
        return all(bool(grid.within(grid.cells(each - start)).all()) for each in spots)

    def _plan_on(
        self, grid: RouteGrid, points_m: FloatArray, start: FloatArray, goals_m: FloatArray, limit_m: float
    ) -> bool:
        """Whether there is a way on this grid; `route` is it then."""
        steps, cost_grid = grid.costs(points_m)
        goals = grid.goal_bits(goals_m, start)
        wave, reached = spread(grid.side, steps, goals, 1 << grid.centre, int(limit_m / CELL_M))
        if not reached:
            return False
        cells = np.array(wave.descend(grid.centre))
        path = self._choose(
            grid, np.column_stack([cells % grid.side, cells // grid.side]), cost_grid, goals, start
        )
        if path is not None:
            points = (path - grid.half) * CELL_M + start
            length = float(step_lengths(path).sum()) * CELL_M
            cost = float(so_far(path, cost_grid)[-1]) * CELL_M
            self.route = Route(points, cost, length, grid.sight(path, cost_grid))
        return True

    def cost_grid(self, points_in_odom_m: FloatArray, start_m: tuple[float, float]) -> CostGrid:
        """The cost of each cell round `start_m`, 0 where the body does not fit; row is y, column is x."""
        return self._grids[0].costs(points_in_odom_m - np.array(start_m))[1]

    def costs_to(
        self, points_in_odom_m: FloatArray, start_m: tuple[float, float], spots_m: FloatArray, limit_m: float
    ) -> FloatArray:
        """What it costs to come near to each spot, shape (K,) for (K, 2); infinite if there is no way.

        Of a spot outside the window nothing is known: it costs `limit_m`.
        """
        start, grid = np.array(start_m), self._grids[-1]
        steps, _ = grid.costs(points_in_odom_m - start if len(points_in_odom_m) else points_in_odom_m)
        wave, _ = spread(grid.side, steps, [(0, 1 << grid.centre)], 0, int(limit_m / CELL_M))
        index = grid.cells(spots_m - start)
        inside = grid.within(index)
        costs = np.full(len(spots_m), limit_m)
        near = wave.costs_near(index[inside, 1], index[inside, 0], NEAR_SPOT_CELLS, _BAND_CELLS)
        costs[inside] = np.where(near >= 0, near * CELL_M, math.inf)
        return costs

    def _choose(
        self, grid: RouteGrid, path: CellPath, cost_grid: CostGrid, goals: Steps, start: FloatArray
    ) -> CellPath | None:
        """`path`, or the rest of the present route if that is another way and nearly as good.

        None: the present route, another way, seems blocked all of a sudden; wait and see for a moment.
        """
        if self.route is None or len(self.route.points_m) < 2:
            return path
        offsets = self.route.points_m - start
        first = int(np.hypot(offsets[:, 0], offsets[:, 1]).argmin())
        rest = grid.cells(offsets[first:])
        if len(rest) < 2 or rest.min() < 1 or rest.max() >= grid.side - 1:
            return path
        apart = np.abs(rest[::3, None, :] - path[None, ::3, :]).max(axis=2).min(axis=1).max() * CELL_M
        if apart < _SAME_WAY_M:
            self._doubts = 0
            return path
        if not cost_grid[rest[:, 1], rest[:, 0]].all() or not grid.near_goal(rest[-1], goals):
            self._doubts += 1
            return None if self._doubts <= _DOUBTS else path
        self._doubts = 0
        joined: CellPath = np.vstack([np.full((1, 2), grid.half, dtype=np.intp), rest])
        mine, other = so_far(joined, cost_grid)[-1], so_far(path, cost_grid)[-1]
        return path if other < _SWITCH_SHARE * mine - 2.0 else joined
