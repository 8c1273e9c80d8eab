"""The grid that routes are planned on: what it costs to be where, for a body and the obstacles round it.

Centred on the robot anew for each plan, axes as odom's. Cells are counted as (column, row) from its corner.
"""

from __future__ import annotations

import math
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from target_nav.config import AvoidConfig, RobotConfig
from target_nav.nav.footprint import Footprint
from target_nav.nav.lidar_noise import range_sigma_m
from target_nav.nav.wavefront import Discs, dilate, inner, to_bits, to_grid
from target_nav.state.types import FloatArray

CELL_M = 0.05
NEAR_SPOT_CELLS = 4
_COMFORT_M = 0.12
"""Wider than the turning body by this: keeping it costs nothing, less costs double."""
_FREE, _NEAR, _CLOSE, _TIGHT = 1, 2, 3, 5
"""Cost of a cell: free; the body can turn there; it can just turn there; it only fits with its front along the way."""
_DOUBT_SIGMAS, _DOUBTS_M = 2.0, (0.0, 0.01, 0.02, 0.03, 0.04)
"""Benefit of the doubt for a gap that is seen from afar."""
_LOST_TO_CELLS_M = 0.5 * CELL_M
"""A point may lie half a cell from its cell's centre."""
_SLACK_M = 0.01
"""A gap with five centimetres to spare holds a single row of cells, and points that wander by half a centimetre close
it every other plan; the robot would turn to and fro in front of it. VFH+ and the limiter keep the whole clearance."""
_START_M = 0.30
"""So near to the robot a cell counts as passable if it is no nearer to an obstacle than the robot already is."""
_SIGHT_M = 1.5

CellPath = NDArray[np.intp]
"""Columns and rows of neighbouring cells, shape (V, 2)."""
Steps = list[tuple[int, int]]
"""Classes of cells as (cost, bits)."""
CostGrid = NDArray[np.uint8]
"""Row by column; 0 is blocked."""


@lru_cache(maxsize=8)
def route_grid(robot: RobotConfig, avoid: AvoidConfig, side: int) -> RouteGrid:
    """One grid for all skills of a process: its tables take 5 ms, and a skill begins within a tick."""
    return RouteGrid(robot, avoid, side)


class RouteGrid:
    """A square of `side` cells, an odd number. It remembers nothing between two plans."""

    def __init__(self, robot: RobotConfig, avoid: AvoidConfig, side: int) -> None:
        body = Footprint.of(robot)
        self.side, self.half = side, side // 2
        self.centre = self.half * side + self.half
        """Index of the robot's cell."""
        self._fits_m = robot.half_width_m + avoid.stop_clearance_m
        just_turns_m = body.circumscribed_radius_m + avoid.stop_clearance_m
        self._fits, self._just_turns = (
            Discs([max(radius_m - doubt_m, 0.0) / CELL_M for doubt_m in _DOUBTS_M], side)
            for radius_m in (self._fits_m - _SLACK_M, just_turns_m)
        )
        self._turns_m = body.circumscribed_radius_m + avoid.margin_m + _LOST_TO_CELLS_M
        self._comfort_m = self._turns_m + _COMFORT_M
        self.pad = math.ceil(self._comfort_m / CELL_M) + 1
        """Cells so near to the border are not used: discs must not run over."""
        self._inner = inner(side)
        self.window_m = (self.half - self.pad) * CELL_M

    def costs(self, points_m: FloatArray) -> tuple[Steps, CostGrid]:
        """The grid's cost classes as bits and as numbers (0: blocked), for points relative to the robot."""
        occupied = np.zeros((self.side, self.side), dtype=np.bool_)
        nearest_m = math.inf
        near = points_m
        if len(points_m):
            near = points_m[np.abs(points_m).max(axis=1) < self.window_m]
            index = self.cells(near)
            occupied[index[:, 1], index[:, 0]] = True
            nearest_m = float(np.hypot(points_m[:, 0], points_m[:, 1]).min())
        radii = [self._turns_m, self._comfort_m]
        inside = nearest_m < self._fits_m + CELL_M
        if inside:
            radii.append(nearest_m - 2.0 * CELL_M)
        grown = dilate(to_bits(occupied), self.side, [radius / CELL_M for radius in radii])
        level = self._doubt_levels(near)
        at = near / CELL_M + self.half
        blocked, close = (to_bits(discs.of(at, level)) for discs in (self._fits, self._just_turns))
        if inside:
            about = dilate(1 << self.centre, self.side, [_START_M / CELL_M])[0]
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
        grid = np.zeros((self.side, self.side), dtype=np.uint8)
        for cost, cells in steps:
            # no cell is in two classes
            grid += to_grid(cells, self.side).view(np.uint8) * np.uint8(cost)
        return steps, grid

    def coarse(self, cost_grid: CostGrid, cells: int) -> Steps:
        """The cost classes with `cells` by `cells` made one, which costs the least of them.

        No wall gets a hole by that while a cell is smaller than half of what every obstacle was grown by.
        """
        side = -(-self.side // cells)
        padded = np.zeros((side * cells, side * cells), dtype=np.uint8)
        # what is blocked becomes the largest: 255
        padded[: self.side, : self.side] = cost_grid
        padded -= np.uint8(1)
        least = padded.reshape(side, cells, side, cells).min(axis=(1, 3)) + np.uint8(1)
        return [(cost, to_bits(least == cost)) for cost in (_FREE, _NEAR, _CLOSE, _TIGHT)]

    def _doubt_levels(self, points_m: FloatArray) -> NDArray[np.intp]:
        """Index into `_DOUBTS_M` of how much nearer to each point base_link may come; points relative to the robot."""
        # Noise makes a far gap look narrower than it is. Going nearer shows; closing it for that would be for good.
        sigma_m = range_sigma_m(np.hypot(points_m[:, 0], points_m[:, 1]))
        return np.searchsorted(_DOUBTS_M[1:], _DOUBT_SIGMAS * sigma_m, side="right")

    def goal_bits(self, goals_m: FloatArray, start: FloatArray) -> Steps:
        """Goals as (extra cost, cells)."""
        index = self.cells(goals_m[:, :2] - start)
        extra = np.rint(goals_m[:, 2] / CELL_M).astype(np.intp)
        inside = self.within(index)
        if not inside.any():
            return self._rim(goals_m, start)
        cells, costs = index[inside, 1] * self.side + index[inside, 0], extra[inside]
        order = np.argsort(costs, kind="stable")
        cells, costs = cells[order], costs[order]
        groups = np.split(cells, np.flatnonzero(np.diff(costs)) + 1)
        return [(cost, self._bits_of(group)) for cost, group in zip(sorted(set(costs.tolist())), groups)]

    def _bits_of(self, cells: NDArray[np.intp]) -> int:
        raw = bytearray((self.side * self.side + 7) // 8)
        for cell in set(cells.tolist()):
            raw[cell >> 3] |= 1 << (cell & 7)
        return int.from_bytes(raw, "little")

    def _rim(self, goals_m: FloatArray, start: FloatArray) -> Steps:
        """For goals out of the window: a circle inside it, each point charged with its distance to the nearest goal."""
        angle = np.linspace(-math.pi, math.pi, 180, endpoint=False)
        radius = self.window_m - 0.05
        ring = radius * np.column_stack([np.cos(angle), np.sin(angle)])
        to_goal = np.hypot(*(goals_m[None, :, :2] - start - ring[:, None, :]).transpose(2, 0, 1)).min(axis=1)
        # Twice, for the wave's own metric is a few percent off and would pull towards the diagonals.
        extra = 2.0 * (to_goal - to_goal.min())
        keep = extra < 2.0 * radius
        local = np.column_stack([ring[keep] + start, extra[keep]])
        return self.goal_bits(local, start)

    def cells(self, offsets_m: FloatArray) -> CellPath:
        """Column and row of points relative to the robot; what is far out of the grid stays out of it."""
        far = 2.0 * self.side
        index: CellPath = np.rint(np.clip(offsets_m / CELL_M, -far, far)).astype(np.intp) + self.half
        return index

    def within(self, index: CellPath) -> NDArray[np.bool_]:
        """Which cells lie off the grid's border."""
        low, high = np.min(index, axis=1) >= self.pad, np.max(index, axis=1) < self.side - self.pad
        within: NDArray[np.bool_] = low & high
        return within

    def sight(self, path: CellPath, cost_grid: CostGrid) -> int:
        """Index of the farthest cell whose straight line from the robot costs no more than the path there."""
        by_now = so_far(path, cost_grid)
        away = np.hypot(path[:, 0] - self.half, path[:, 1] - self.half) * CELL_M
        beyond = np.flatnonzero(away > _SIGHT_M)
        last = int(beyond[0]) if len(beyond) else len(path) - 1
        for index in range(last, 1, -3):
            if self._line_cost(path[index], cost_grid) <= 1.02 * by_now[index] + 0.5:
                return index
        return min(1, last)

    def _window(self, column: int, row: int, reach: int) -> int:
        """The square of cells within `reach` of one."""
        line = ((1 << (2 * reach + 1)) - 1) << max(column - reach, 0)
        cells = 0
        for at in range(max(row - reach, 0), row + reach + 1):
            cells |= line << (at * self.side)
        return cells

    def near_goal(self, cell: NDArray[np.intp], goals: Steps) -> bool:
        window = self._window(int(cell[0]), int(cell[1]), NEAR_SPOT_CELLS)
        return any(cells & window for _, cells in goals)

    def _line_cost(self, cell: NDArray[np.intp], cost_grid: CostGrid) -> float:
        """Cost in cells of the straight line from the robot, infinite if it is blocked."""
        dx, dy = float(cell[0] - self.half), float(cell[1] - self.half)
        length = math.hypot(dx, dy)
        count = max(int(2.0 * length), 1)
        share = (np.arange(count) + 1.0) / count
        columns = np.rint(self.half + share * dx).astype(np.intp)
        rows = np.rint(self.half + share * dy).astype(np.intp)
        charge = cost_grid[rows, columns]
        return float(charge.sum()) * length / count if charge.all() else math.inf


def step_lengths(path: CellPath) -> FloatArray:
    steps: FloatArray = np.hypot(*np.diff(path, axis=0).T) if len(path) > 1 else np.zeros(0)
    return steps


def so_far(path: CellPath, cost_grid: CostGrid) -> FloatArray:
    """Cost in cells from the path's start to each of its cells."""
    charge = cost_grid[path[1:, 1], path[1:, 0]]
    return np.concatenate([[0.0], np.cumsum(charge * step_lengths(path))])
