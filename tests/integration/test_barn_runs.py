"""A few of the BARN set's worlds, driven: the whole set is `target-nav barn FOLDER`. Skipped without the set's data."""

from __future__ import annotations

import pytest

from target_nav.app.barn import BarnOrder, barn_table, execute, reached_after_s
from target_nav.app.paths import mission_path
from target_nav.sim.arena_types import Goal
from target_nav.sim.barn import BarnName
from tests.unit.sim.test_barn import DATA, needs_data


def test_the_clock_runs_from_the_first_movement_to_the_radius() -> None:
    stands = [(0.05 * n, 0.0, 0.0, 0.0) for n in range(20)]
    drives = [(1.0 + 0.05 * n, 0.1 * n, 0.0, 0.0) for n in range(100)]
    assert reached_after_s(stands + drives, Goal(5.0, 0.0, 1.0)) == pytest.approx(2.0, abs=0.051)
    assert reached_after_s(stands, Goal(5.0, 0.0, 1.0)) is None
    assert reached_after_s([], Goal(5.0, 0.0, 1.0)) is None


@needs_data
@pytest.mark.slow
@pytest.mark.parametrize(("robot", "world"), [("jackal", 121), ("jackal", 289), ("own", 37)])
def test_a_world_is_passed_without_touching_anything(robot: str, world: int) -> None:
    run = execute(BarnOrder(BarnName(robot, world, DATA), 5, str(mission_path("go_to_point"))))
    assert run.succeeded, run.result
    assert run.score > 0.3
    assert run.as_json()["world"] == world
    table = barn_table([run], "one")
    assert table.row_count == 2
