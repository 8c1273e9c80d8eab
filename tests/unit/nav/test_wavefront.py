"""Bit-set wavefronts, held against plain searches over small grids."""

from __future__ import annotations

import heapq
from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from target_nav.nav.wavefront import Discs, dilate, inner, spread, to_bits, to_grid

SIDE = 16
grids = st.lists(st.integers(0, 5), min_size=SIDE * SIDE, max_size=SIDE * SIDE).map(
    lambda cells: np.array(cells).reshape(SIDE, SIDE)
)


def classes(grid: np.ndarray) -> list[tuple[int, int]]:
    """0 and 3 to 5 are free (cost 1), 1 blocked, 2 costs 3; the border is blocked."""
    within = inner(SIDE)
    free = to_bits((grid != 1) & (grid != 2)) & within
    dear = to_bits(grid == 2) & within
    return [(1, free), (3, dear)]


def plain_costs(grid: np.ndarray, goal: tuple[int, int]) -> dict[tuple[int, int], int]:
    """The same metric by Dijkstra: eight neighbours may be entered from an odd cost, four from an even one."""
    charge = np.where(grid == 2, 3, 1)
    charge[grid == 1] = 0
    charge[[0, -1], :] = charge[:, [0, -1]] = 0
    costs: dict[tuple[int, int], int] = {}
    queue = [(0, goal)] if charge[goal] else []
    while queue:
        cost, (row, column) = heapq.heappop(queue)
        if (row, column) in costs:
            continue
        costs[row, column] = cost
        for dr in (-1, 0, 1):
            for dc in (-1, 0, 1):
                if (dr or dc) and (cost & 1 or dr == 0 or dc == 0):
                    cell = (row + dr, column + dc)
                    if charge[cell] and cell not in costs:
                        heapq.heappush(queue, (cost + int(charge[cell]), cell))
    return costs


def test_bits_and_grid_are_the_same_thing() -> None:
    grid = np.zeros((SIDE, SIDE), dtype=np.bool_)
    grid[3, 5] = grid[15, 15] = True
    bits = to_bits(grid)
    assert bits == 1 << (3 * SIDE + 5) | 1 << (SIDE * SIDE - 1)
    assert (to_grid(bits, SIDE) == grid).all()


@pytest.mark.parametrize("radius", [0.0, 1.0, 1.5, 3.2])
def test_dilation_is_a_disc(radius: float) -> None:
    grid = np.zeros((SIDE, SIDE), dtype=np.bool_)
    grid[8, 7] = True
    rows, columns = np.mgrid[:SIDE, :SIDE]
    disc = (rows - 8) ** 2 + (columns - 7) ** 2 <= radius**2
    assert (to_grid(dilate(to_bits(grid), SIDE, [radius])[0], SIDE) == disc).all()


@given(st.lists(st.tuples(st.floats(4.0, SIDE - 5.0), st.floats(4.0, SIDE - 5.0)), max_size=6), st.booleans())
def test_discs_are_the_cells_within_the_radius_to_a_sixteenth_of_a_cell(
    centres: list[tuple[float, float]], wide: bool
) -> None:
    radii = (1.3, 3.4)
    rows, columns = np.mgrid[:SIDE, :SIDE]
    level = np.full(len(centres), int(wide), dtype=np.intp)
    found = Discs(radii, SIDE).of(np.array(centres).reshape(-1, 2), level)
    least, most = np.zeros((2, SIDE, SIDE), dtype=np.bool_)
    for x, y in centres:
        away = np.hypot(columns - x, rows - y)
        least |= away <= radii[wide] - 0.09
        most |= away <= radii[wide] + 0.09
    assert (found >= least).all()
    assert (found <= most).all()


def test_nothing_grown_by_a_negative_radius_remains() -> None:
    assert dilate(1 << 100, SIDE, [-0.5]) == [0]


@settings(max_examples=40)
@given(grids)
def test_costs_are_those_of_a_plain_search(grid: np.ndarray) -> None:
    steps = classes(grid)
    wave, _ = spread(SIDE, steps, [(0, 1 << (7 * SIDE + 7))], 0, 400)
    plain = plain_costs(grid, (7, 7))
    rows, columns = (index.reshape(-1) for index in np.mgrid[:SIDE, :SIDE])
    cells = list(zip(rows.tolist(), columns.tolist()))
    assert wave.costs_near(rows, columns, 0).tolist() == [plain.get(cell, -1) for cell in cells]
    rounded = [4 * (plain[cell] // 4) if cell in plain else -1 for cell in cells]
    assert wave.costs_near(rows, columns, 0, 4).tolist() == rounded
    beside = [
        min(
            (plain[(r, c)] for r in range(a - 1, a + 2) for c in range(b - 1, b + 2) if (r, c) in plain),
            default=-1,
        )
        for a, b in cells
    ]
    assert wave.costs_near(rows, columns, 1).tolist() == beside


@settings(max_examples=40)
@given(grids)
def test_a_path_is_connected_open_and_ends_at_a_goal(grid: np.ndarray) -> None:
    steps = classes(grid)
    start, goal = 3 * SIDE + 3, 12 * SIDE + 11
    wave, reached = spread(SIDE, steps, [(0, 1 << goal)], 1 << start, 400)
    assert reached == ((3, 3) in plain_costs(grid, (12, 11)))
    if not reached:
        return
    path = wave.descend(start)
    assert path[0] == start
    assert path[-1] == goal
    open_cells = steps[0][1] | steps[1][1]
    for one, other in pairwise(path):
        assert max(abs(one // SIDE - other // SIDE), abs(one % SIDE - other % SIDE)) == 1
        assert open_cells >> other & 1


def test_a_goal_that_costs_extra_is_taken_when_it_is_nearer_all_the_same() -> None:
    steps = [(1, inner(SIDE))]
    start = 8 * SIDE + 2
    near, far = 8 * SIDE + 5, 8 * SIDE + 13
    wave, _ = spread(SIDE, steps, [(2, 1 << near), (0, 1 << far)], 1 << start, 100)
    assert wave.descend(start)[-1] == near
    wave, _ = spread(SIDE, steps, [(20, 1 << near), (0, 1 << far)], 1 << start, 100)
    assert wave.descend(start)[-1] == far


def test_the_limit_bounds_the_search() -> None:
    steps = [(1, inner(SIDE))]
    wave, reached = spread(SIDE, steps, [(0, 1 << (8 * SIDE + 13))], 1 << (8 * SIDE + 2), 5)
    assert not reached
    assert wave.cost == 5
