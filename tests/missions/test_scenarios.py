"""The missions that come along, each against its scenarios."""

from __future__ import annotations

from pathlib import Path

import pytest

from target_nav.mission.scenario_file import read_scenarios
from target_nav.mission.scenario_find import find_scenario_files, shipped
from target_nav.mission.scenario_model import Scenario
from target_nav.mission.scenario_run import run_scenario

SCENARIOS = [
    pytest.param(scenario, id=f"{path.stem}: {scenario.name}")
    for path in find_scenario_files([])
    for scenario in read_scenarios(path)
]


@pytest.mark.parametrize("scenario", SCENARIOS)
def test_scenario(scenario: Scenario) -> None:
    result = run_scenario(scenario)
    assert result.passed, f"\n{result.explain()}"


def test_every_mission_has_scenarios() -> None:
    covered = {param.values[0].mission.resolve() for param in SCENARIOS}
    missions = {path.resolve() for kind in ("*.xml", "*.yaml") for path in shipped().parent.glob(kind)}
    assert missions <= covered, f"without scenarios: {sorted(path.name for path in missions - covered)}"
    assert all(isinstance(path, Path) for path in covered)
