"""What it costs to get to a goal from each place round the robot, counting room beside the body.

Dijkstra's algorithm over a grid, from the goals outwards. Cells that the body does not fit in are not walls but very
dear: so the field leads out again from a place that is too near to something, and its gradient is there for whatever
looks a little ahead. Whether there is a way at all is asked separately. What the LiDAR has not seen counts as free.
"""

from __future__ import annotations

import math
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import label
from scipy.sparse import csr_matrix
from scipy.sparse.csgraph import dijkstra

from target_nav.nav.nearest_point import NearestPoint
from target_nav.state.types import FloatArray

_TIGHT, _SNUG = 5.0, 2.0
"""Cost of a metre where the body only just fits, and where it can just turn; 1 where there is comfort."""
_TOO_TIGHT = 100.0
_WALL_M = 0.03
"""Nearer to a point than this is the thing itself."""
_START_M = 1.5
"""So many times the fitting radius round the robot counts as passable: it is there, so it can leave."""
_STEEPEST = 6.0
"""Between neighbouring cells the field is taken to rise by so much a metre at most, when it is interpolated."""


class CostField:
    """A window round the robot, in odom. `at` gives the cost to go in metres."""

    def __init__(
        self,
        points_m: FloatArray,
        robot_m: tuple[float, float],
        goals_m: FloatArray,
        *,
        half_m: float,
        cell_m: float,
        fits_m: float,
        turns_m: float,
        comfort_m: float,
    ) -> None:
        """`points_m` (N, 2) and `goals_m` (M, 3: x, y, extra cost) are in odom.

        `fits_m` < `turns_m` < `comfort_m` are distances from the body's middle to the nearest point: it fits
        lengthways, it can turn on the spot, it has room. Goals outside of the window are stood for by its rim.
        """
        self._near = NearestPoint(points_m, robot_m, half_m, cell_m)
        self._cell_m, self._side = cell_m, self._near.side
        room = self._near.distances_m()[1:-1, 1:-1]
        rate = np.interp(room, [fits_m, turns_m, comfort_m], [_TIGHT, _SNUG, 1.0])
        passable = room >= fits_m
        x, y = (grid[1:-1, 1:-1] for grid in self._near.centres())
        at_start = np.hypot(x - robot_m[0], y - robot_m[1]) < _START_M * fits_m
        rate[~passable] = _TOO_TIGHT
        rate[room < _WALL_M] = math.inf
        sources = self._sources(goals_m, x, y, passable)
        self._cost = self._spread(rate, sources)
        regions, _ = label(passable | (at_start & (room >= _WALL_M)), structure=np.ones((3, 3)))
        middle = self._near.half_cells
        reached = [regions.flat[cell] for cell, _ in sources]
        self.has_way = bool(regions[middle, middle] and regions[middle, middle] in reached)
        """Whether the body fits all the way to a goal, as far as is known."""

    def _sources(
        self, goals_m: FloatArray, x: FloatArray, y: FloatArray, passable: NDArray[np.bool_]
    ) -> list[tuple[int, float]]:
        """Cells to begin from, with what is left to pay there."""
        column, row = self._near.cells(goals_m[:, 0], goals_m[:, 1])
        inside = (column > 0) & (column <= self._side) & (row > 0) & (row <= self._side)
        found = [
            (int((r - 1) * self._side + c - 1), float(extra))
            for c, r, extra in zip(column[inside], row[inside], goals_m[inside, 2])
        ]
        if found:
            return found
        rim = np.zeros_like(passable)
        rim[0], rim[-1], rim[:, 0], rim[:, -1] = True, True, True, True
        cells = np.flatnonzero(rim & passable)
        away = np.hypot(x.flat[cells][:, None] - goals_m[:, 0], y.flat[cells][:, None] - goals_m[:, 1])
        left = (away + goals_m[:, 2]).min(axis=1)
        return list(zip(cells.tolist(), left.tolist()))

    def _spread(self, rate: FloatArray, sources: list[tuple[int, float]]) -> FloatArray:
        """Cost to go for each cell, shape (side, side); infinite inside of things."""
        count = self._side * self._side
        if not sources:
            return np.full((self._side, self._side), math.inf)
        here, there, length, starts = _edges(self._side)
        flat = rate.ravel()
        weight = 0.5 * self._cell_m * length * (flat[here] + flat[there])
        # one more node, joined to all sources, is where the search begins
        cells = np.array([cell for cell, _ in sources])
        left = np.array([max(cost, 1e-6) for _, cost in sources])
        graph = csr_matrix(
            (
                np.concatenate([weight, left]),
                np.concatenate([there, cells]),
                np.append(starts, len(there) + len(cells)),
            ),
            shape=(count + 1, count + 1),
        )
        costs: FloatArray = dijkstra(graph, indices=count)
        return costs[:count].reshape(self._side, self._side)

    def at(self, x_m: FloatArray, y_m: FloatArray) -> FloatArray:
        """Cost to go at places, of any shape: interpolated between cells; outside of the window as at its rim."""
        origin_x, origin_y = self._near._origin
        u = np.clip((x_m - origin_x) / self._cell_m, 0.0, self._side - 1.001)
        v = np.clip((y_m - origin_y) / self._cell_m, 0.0, self._side - 1.001)
        column, row = u.astype(np.intp), v.astype(np.intp)
        fu, fv = u - column, v - row
        nearest = self._cost[np.rint(v).astype(np.intp), np.rint(u).astype(np.intp)]
        step = _STEEPEST * self._cell_m
        low, high = nearest - step, nearest + step
        with np.errstate(invalid="ignore"):
            f00, f01, f10, f11 = (
                np.clip(self._cost[row + a, column + b], low, high) for a in (0, 1) for b in (0, 1)
            )
            value = (1 - fv) * ((1 - fu) * f00 + fu * f01) + fv * ((1 - fu) * f10 + fu * f11)
        return np.where(np.isfinite(nearest), value, math.inf)


Edges = tuple[NDArray[np.intp], NDArray[np.intp], FloatArray, NDArray[np.intp]]


@lru_cache(maxsize=4)
def _edges(side: int) -> Edges:
    """Of a grid with eight neighbours: from, to, length in cells, and where each cell's edges begin."""
    index = np.arange(side * side).reshape(side, side)
    pairs = []
    for down, right in ((0, 1), (1, 0), (1, 1), (1, -1)):
        here = index[: side - down, max(-right, 0) : side - max(right, 0)].ravel()
        there = index[down:, max(right, 0) : side + min(right, 0)].ravel()
        pairs.append((here, there, np.full(len(here), math.hypot(down, right))))
    here = np.concatenate([p[0] for p in pairs] + [p[1] for p in pairs])
    there = np.concatenate([p[1] for p in pairs] + [p[0] for p in pairs])
    length = np.concatenate([p[2] for p in pairs] * 2)
    order = np.lexsort((there, here))
    here, there, length = here[order], there[order], length[order]
    return here, there, length, np.searchsorted(here, np.arange(side * side + 1))
