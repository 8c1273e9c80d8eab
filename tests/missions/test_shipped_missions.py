"""The missions that come along, each in its arena, in virtual time: robot, tracker, limiter and simulator included."""

from __future__ import annotations

import math

import pytest

from target_nav.app.paths import mission_path
from target_nav.app.virtual import RunResult, run_virtual
from target_nav.sim.arena import load_arena

pytestmark = pytest.mark.slow


def run(mission: str, arena: str, seed: int) -> RunResult:
    return run_virtual(load_arena(arena), mission_path(mission), seed)


@pytest.mark.parametrize("seed", range(1, 4))
@pytest.mark.parametrize("mission", ["three_pins", "patrol", "there_and_back"])
def test_a_mission_ends_well_in_its_arena(mission: str, seed: int) -> None:
    result = run(mission, mission, seed)
    assert result.as_expected, result
    assert result.outcome == "succeeded"
    assert not result.collided


@pytest.mark.parametrize("seed", range(1, 3))
def test_there_and_back_comes_back_without_a_pin_too(seed: int) -> None:
    result = run("there_and_back", "no_pin", seed)
    assert (result.outcome, result.as_expected) == ("failed", True)
    assert "not found" in result.reason
    start = load_arena("no_pin").robot
    _, x_m, y_m, _ = result.trace[-1]
    farthest = max(math.dist((x, y), (start.x_m, start.y_m)) for _, x, y, _ in result.trace)
    assert farthest > 1.0
    assert math.dist((x_m, y_m), (start.x_m, start.y_m)) < 0.4


def test_patrol_without_a_pin_says_that_nothing_showed_up() -> None:
    result = run("patrol", "no_pin", 1)
    assert (result.outcome, result.collided) == ("failed", False)
    assert result.reason == "nothing showed up in two rounds"
