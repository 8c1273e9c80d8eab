"""Who belongs to whom, at the least total cost: the assignment problem for the handful of boxes in a picture.

Shortest augmenting paths with potentials (Jonker and Volgenant, "A shortest augmenting path algorithm for dense and
sparse linear assignment problems", Computing 38, 1987). SciPy has it too, for 60 MB of memory in a process that has 30.
"""

from __future__ import annotations

import math
from collections.abc import Sequence


def assign(costs: Sequence[Sequence[float]], unmatched: float) -> list[int | None]:
    """For each row its column, or None, so that the sum of costs is least; leaving a row out costs `unmatched`.

    `costs` are rows of equal length; inf forbids a pair, and no pair dearer than `unmatched` is made.
    """
    rows = len(costs)
    columns = len(costs[0]) if rows else 0
    # Each row has a place of its own beyond the real columns, at the price of staying alone.
    width = columns + rows
    own = [
        [*(min(c, math.inf) for c in row), *(unmatched if k == i else math.inf for k in range(rows))]
        for i, row in enumerate(costs)
    ]
    row_of = [-1] * width
    row_price, column_price = [0.0] * rows, [0.0] * width
    for start in range(rows):
        _augment(start, own, row_of, row_price, column_price)
    found: list[int | None] = [None] * rows
    for column in range(columns):
        if row_of[column] >= 0:
            found[row_of[column]] = column
    return found


def _augment(
    start: int,
    costs: Sequence[Sequence[float]],
    row_of: list[int],
    row_price: list[float],
    column_price: list[float],
) -> None:
    """Give row `start` a column, moving others along the cheapest path (Dijkstra over reduced costs)."""
    width = len(row_of)
    distance, before, done = [math.inf] * width, [-1] * width, [False] * width
    row, reached, last = start, 0.0, -1
    visited: list[int] = []
    while True:
        for column in range(width):
            if not done[column]:
                reduced = reached + costs[row][column] - row_price[row] - column_price[column]
                if reduced < distance[column]:
                    distance[column], before[column] = reduced, row
        last = min((c for c in range(width) if not done[c]), key=distance.__getitem__)
        reached = distance[last]
        if row_of[last] < 0:
            break
        done[last] = True
        visited.append(last)
        row = row_of[last]
    row_price[start] += reached
    for column in visited:
        row_price[row_of[column]] += reached - distance[column]
        column_price[column] -= reached - distance[column]
    column = last
    while True:
        owner = before[column]
        row_of[column], next_column = owner, _column_of(owner, row_of, column)
        if owner == start:
            return
        column = next_column


def _column_of(row: int, row_of: list[int], but: int) -> int:
    """The column a row had before it was given `but`; -1 for none."""
    return next((c for c, owner in enumerate(row_of) if owner == row and c != but), -1)
