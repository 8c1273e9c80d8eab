"""Least-cost assignment, held against trying everything."""

from __future__ import annotations

import itertools
import math

from hypothesis import given
from hypothesis import strategies as st

from target_nav.detectors.assignment import assign

COST = st.one_of(st.integers(0, 40).map(float), st.just(math.inf))
UNMATCHED = 25.0


def total(costs: list[list[float]], chosen: tuple[int | None, ...] | list[int | None]) -> float:
    return sum(UNMATCHED if column is None else costs[row][column] for row, column in enumerate(chosen))


def best(costs: list[list[float]]) -> float:
    rows, columns = len(costs), len(costs[0])
    places: list[int | None] = [*range(columns), *([None] * rows)]
    return min(total(costs, choice) for choice in set(itertools.permutations(places, rows)))


@st.composite
def matrices(draw: st.DrawFn) -> list[list[float]]:
    rows, columns = draw(st.integers(1, 4)), draw(st.integers(1, 4))
    return [[draw(COST) for _ in range(columns)] for _ in range(rows)]


@given(matrices())
def test_no_other_assignment_is_cheaper(costs: list[list[float]]) -> None:
    chosen = assign(costs, UNMATCHED)
    assert total(costs, chosen) == best(costs)


@given(matrices())
def test_no_column_is_given_twice_and_no_forbidden_pair_made(costs: list[list[float]]) -> None:
    chosen = assign(costs, UNMATCHED)
    given_ = [column for column in chosen if column is not None]
    assert len(set(given_)) == len(given_)
    assert all(costs[row][column] <= UNMATCHED for row, column in enumerate(chosen) if column is not None)


def test_the_greedy_choice_is_not_always_the_best() -> None:
    assert assign([[1.0, 2.0], [2.0, 24.0]], UNMATCHED) == [1, 0]


def test_nothing_to_assign() -> None:
    assert assign([], UNMATCHED) == []
    assert assign([[], []], UNMATCHED) == [None, None]
    assert assign([[math.inf], [3.0]], UNMATCHED) == [None, 0]


def test_many_boxes_are_no_burden() -> None:
    costs = [[float((7 * i + 3 * k) % 20) for k in range(64)] for i in range(64)]
    chosen = assign(costs, UNMATCHED)
    assert sorted(c for c in chosen if c is not None) == list(range(64))
