"""What is remembered of obstacles: what is hidden stays, what was looked through goes."""

from __future__ import annotations

import numpy as np

from target_nav.nav.route_memory import RouteMemory
from target_nav.state.types import FloatArray
from tests.unit.nav.views import NO_POINTS, points, wall

HERE = (0.0, 0.0)
BOX = wall(1.0, -0.3, 1.0, 0.3)
BEHIND = wall(2.0, -0.4, 2.0, 0.4)


def holds(known: FloatArray, thing: FloatArray) -> float:
    """Share of a thing's points that have a known one within 6 cm."""
    if len(known) == 0:
        return 0.0
    away = np.hypot(*(thing[:, None, :] - known[None, :, :]).transpose(2, 0, 1)).min(axis=1)
    return float((away < 0.06).mean())


def test_what_is_hidden_behind_something_nearer_stays() -> None:
    memory = RouteMemory(4.0, 4.0)
    memory.update(0.0, HERE, BEHIND)
    for step in range(20):
        known = memory.update(0.3 * (step + 1), HERE, BOX)
    assert holds(known, BEHIND) > 0.9
    assert holds(known, BOX) == 1.0


def test_what_the_view_looks_through_goes() -> None:
    memory = RouteMemory(4.0, 4.0)
    memory.update(0.0, HERE, np.vstack([BOX, BEHIND]))
    known = memory.update(0.3, HERE, np.vstack([BEHIND, wall(2.0, -0.8, 2.0, 0.8)]))
    assert holds(known, BOX) == 0.0


def test_beyond_the_reach_of_the_view_it_stays() -> None:
    memory = RouteMemory(1.5, 1.5)
    memory.update(0.0, HERE, BEHIND)
    known = memory.update(0.3, HERE, NO_POINTS)
    assert holds(known, BEHIND) == 1.0


def test_a_direction_without_returns_is_no_free_space_for_a_while() -> None:
    memory = RouteMemory(4.0, 4.0)
    memory.update(0.0, HERE, BOX)
    assert holds(memory.update(5.0, HERE, NO_POINTS), BOX) == 1.0
    assert holds(memory.update(11.0, HERE, NO_POINTS), BOX) == 0.0


def test_nothing_is_remembered_for_ever() -> None:
    memory = RouteMemory(4.0, 4.0)
    memory.update(0.0, HERE, BEHIND)
    assert holds(memory.update(241.0, HERE, BOX), BEHIND) == 0.0


def test_a_wall_that_drifts_is_drawn_once() -> None:
    memory = RouteMemory(4.0, 4.0)
    for step in range(10):
        known = memory.update(0.3 * step, HERE, BOX + np.array([0.008 * step, 0.0]))
    assert known[:, 0].min() > 1.05


def test_round_the_target_the_view_does_not_speak_against_points() -> None:
    memory = RouteMemory(4.0, 4.0)
    beside = points((1.2, 0.2))
    farther = wall(2.0, -1.0, 2.0, 1.0)
    memory.update(0.0, HERE, np.vstack([beside, farther]))
    assert holds(memory.update(0.3, HERE, farther, (1.1, 0.1)), beside) == 1.0
    assert holds(memory.update(0.6, HERE, farther), beside) == 0.0


def test_clear_forgets() -> None:
    memory = RouteMemory(4.0, 4.0)
    memory.update(0.0, HERE, BOX)
    memory.clear()
    assert len(memory.update(0.1, HERE, NO_POINTS)) == 0


def test_how_far_the_view_reaches_is_learnt_from_its_points() -> None:
    memory = RouteMemory(1.2, 4.0)
    memory.update(0.0, HERE, points((1.5, 0.0)))
    assert memory.reach_m == 1.4
    memory.update(0.0, HERE, points((0.3, 0.0), (9.0, 0.0)))
    assert memory.reach_m == 4.0


def test_behind_the_points_of_a_near_wall_nothing_grows_old_sooner() -> None:
    """Between two points a cell apart there is no direction without returns."""
    memory = RouteMemory(4.0, 4.0)
    memory.update(0.0, HERE, BEHIND)
    near = wall(0.25, -1.5, 0.25, 1.5, step=0.05)
    for step in range(50):
        known = memory.update(0.3 * (step + 1), HERE, near)
    assert holds(known, BEHIND) == 1.0


def test_an_old_copy_of_a_wall_in_view_goes_even_where_it_is_hidden() -> None:
    """Drift draws a wall elsewhere after some metres, and behind itself."""
    memory = RouteMemory(4.0, 4.0)
    copy, other = BOX + np.array([0.18, 0.0]), BEHIND
    memory.update(0.0, HERE, np.vstack([copy, other]))
    known = memory.update(5.0, HERE, BOX)
    assert holds(known, copy) == 1.0, "at first both may be"
    known = memory.update(20.0, HERE, BOX)
    assert holds(known, copy) == 0.0
    assert holds(known, other) == 1.0
