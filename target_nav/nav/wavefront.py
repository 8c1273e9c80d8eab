"""Cost to go on a small grid, by a wavefront of whole-number costs (Dial's algorithm) on bit sets.

A grid is one Python integer, a bit a cell: dilating an obstacle or moving the whole front by one cell is a handful of
shifts and ORs, so a plan over some ten thousand cells takes well under a millisecond without a compiled library.
Distance is octagonal: fronts grow by four neighbours and by eight in turn, which is at most 6 % off (Rosenfeld and
Pfaltz 1968). Bit `row * side + column` is the cell at x = column, y = row.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from target_nav.state.types import FloatArray

BoolGrid = NDArray[np.bool_]
_PARTS = 8
_NEVER = int(np.iinfo(np.int64).max)


def to_bits(grid: BoolGrid) -> int:
    return int.from_bytes(np.packbits(grid.reshape(-1), bitorder="little").tobytes(), "little")


def to_grid(bits: int, side: int) -> BoolGrid:
    cells = side * side
    raw = np.frombuffer(bits.to_bytes((cells + 7) // 8, "little"), dtype=np.uint8)
    return np.unpackbits(raw, count=cells, bitorder="little").reshape(side, side).astype(np.bool_)


def inner(side: int, border: int = 1) -> int:
    """All cells but a border, which keeps shifts from running over into the next row."""
    row = ((1 << (side - 2 * border)) - 1) << border
    bits = 0
    for index in range(border, side - border):
        bits |= row << (index * side)
    return bits


def dilate(bits: int, side: int, radii_cells: Sequence[float]) -> list[int]:
    """`bits` grown by a disc of each radius. Cells nearer to the border than the radius may run over: keep it free."""
    wide = [bits]
    for width in range(1, math.floor(max(radii_cells, default=0.0)) + 1):
        wide.append(wide[-1] | bits << width | bits >> width)
    grown: list[int] = []
    for radius in radii_cells:
        if radius < 0.0:
            grown.append(0)
            continue
        out = wide[math.floor(radius)]
        for dy in range(1, math.floor(radius) + 1):
            row = wide[math.floor(math.sqrt(radius * radius - dy * dy))]
            out |= row << (dy * side) | row >> (dy * side)
        grown.append(out)
    return grown


class Discs:
    """Grows points by a disc, to a fraction of a cell: a gap is as wide as it is, however the grid lies.

    Unlike with `dilate` points need not lie in the middle of a cell. What a disc covers is looked up by where in its
    cell the point lies, to an eighth of a cell, and by radius.
    """

    def __init__(self, radii_cells: Sequence[float], side: int) -> None:
        self._side = side
        reach = math.ceil(max(radii_cells))
        self.reach_cells = reach
        """Points so near to the grid's border may run over: keep them off it."""
        down, across = (index.reshape(-1) for index in np.mgrid[-reach : reach + 1, -reach : reach + 1])
        parts = (np.arange(_PARTS) + 0.5) / _PARTS - 0.5
        stencils = [
            np.flatnonzero((down - y) ** 2 + (across - x) ** 2 <= radius**2)
            for radius in radii_cells
            for y in parts
            for x in parts
        ]
        offsets = down * side + across
        longest = max(1, *(len(cells) for cells in stencils))
        self._table = np.array(
            [np.resize(offsets[cells] if len(cells) else [0], longest) for cells in stencils], dtype=np.int32
        )

    def of(self, points_cells: FloatArray, radius: NDArray[np.intp]) -> BoolGrid:
        """Cells whose middle lies in a disc, shape (side, side), for points (N, 2) as column and row, in cells.

        `radius` (N,) is the index of each point's radius.
        """
        grid: BoolGrid = np.zeros(self._side * self._side, dtype=np.bool_)
        middle = np.rint(points_cells)
        part = np.clip(((points_cells - middle + 0.5) * _PARTS).astype(np.intp), 0, _PARTS - 1)
        stencil = (radius * _PARTS + part[:, 1]) * _PARTS + part[:, 0]
        cell = (middle[:, 1] * self._side + middle[:, 0]).astype(np.int32)
        grid[(cell[:, None] + self._table[stencil]).reshape(-1)] = True
        return grid.reshape(self._side, self._side)


@dataclass(frozen=True)
class Wave:
    """A finished search: `fronts[cost]` are the cells that are `cost` steps away from the nearest goal."""

    side: int
    fronts: tuple[int, ...]
    step_cost: tuple[tuple[int, int], ...]

    @property
    def cost(self) -> int:
        """Cost of the last front: that of the cell the search ran until."""
        return len(self.fronts) - 1

    def costs_near(
        self, rows: NDArray[np.intp], columns: NDArray[np.intp], reach: int, band: int = 1
    ) -> NDArray[np.int64]:
        """The lowest cost at each cell, and half of and all of `reach` beside it; -1 where the wave did not come.

        Rounded down to a multiple of `band`, which is quicker.
        """
        costs = self.costs(band)
        nearest = np.full(len(rows), _NEVER)
        steps = sorted({-reach, -(reach // 2), 0, reach // 2, reach})
        for down in steps:
            for across in steps:
                row = np.clip(rows + down, 0, self.side - 1)
                np.minimum(nearest, costs[row, np.clip(columns + across, 0, self.side - 1)], out=nearest)
        return np.where(nearest == _NEVER, -1, nearest)

    def costs(self, band: int = 1) -> NDArray[np.int64]:
        """Cost of each cell, row by column; the largest whole number where the wave did not come."""
        grid = np.full((self.side, self.side), _NEVER)
        flat = grid.reshape(-1)
        for begin in range(0, len(self.fronts), band):
            cells = 0
            for front in self.fronts[begin : begin + band]:
                cells |= front
            if cells:
                first = ((cells & -cells).bit_length() - 1) // 8
                raw = (cells >> (8 * first)).to_bytes((cells.bit_length() + 7) // 8 - first, "little")
                bits = np.unpackbits(np.frombuffer(raw, dtype=np.uint8), bitorder="little")
                flat[np.flatnonzero(bits) + 8 * first] = begin
        return grid

    def descend(self, cell: int) -> list[int]:
        """Cells from `cell` (where the wave ended) down to a goal, both included; straight on where it can choose."""
        side, fronts, cost = self.side, self.fronts, self.cost
        path = [cell]
        last = 0
        while True:
            found = self._before(cell, cost, last)
            if found is None:
                return path
            cell, cost = found
            last = cell - path[-1]
            path.append(cell)
            if len(path) > side * side or not fronts:
                return path

    def _before(self, cell: int, cost: int, last: int) -> tuple[int, int] | None:
        """The neighbour this cell was reached from, and its cost."""
        own = next((charge for charge, cells in self.step_cost if cells >> cell & 1), 1)
        before = cost - own
        if before < 0:
            return None
        front = self.fronts[before]
        for offset in _by_turn(self.side, last):
            if (abs(offset) == 1 or abs(offset) == self.side or before & 1) and front >> (cell + offset) & 1:
                return cell + offset, before
        return None


def _by_turn(side: int, last: int) -> list[int]:
    """Eight neighbours, the one straight on first, then by how far they turn, left and right alternating."""
    around = [1, side + 1, side, side - 1, -1, -side - 1, -side, -side + 1]
    start = around.index(last) if last in around else 0
    return [around[(start + turn) % 8] for turn in (0, 1, -1, 2, -2, 3, -3, 4)]


def spread(
    side: int, step_cost: Sequence[tuple[int, int]], goals: Sequence[tuple[int, int]], until: int, limit: int
) -> tuple[Wave, bool]:
    """Run the wave from `goals` until it reaches a cell of `until`, has nowhere left to go, or costs `limit`.

    `step_cost` is (cost of entering, cells) with disjoint cells, all else is blocked; `goals` is (cost at the
    start, cells). Blocked goals do not count. Returns the wave, and whether it reached `until`.
    """
    open_cells = 0
    for _, cells in step_cost:
        open_cells |= cells
    pending: dict[int, int] = {}
    for cost, cells in goals:
        pending[cost] = pending.get(cost, 0) | (cells & open_cells)
    fronts: list[int] = []
    for cost in range(limit + 1):
        front = pending.pop(cost, 0) & open_cells
        fronts.append(front)
        if front & until:
            return Wave(side, tuple(fronts), tuple(step_cost)), True
        if not front:
            if not pending:
                break
            continue
        open_cells &= ~front
        across = front | front << 1 | front >> 1
        grown = across | (across << side | across >> side if cost & 1 else front << side | front >> side)
        grown &= open_cells
        for charge, cells in step_cost:
            reached = grown & cells
            if reached:
                pending[cost + charge] = pending.get(cost + charge, 0) | reached
    return Wave(side, tuple(fronts), tuple(step_cost)), False
