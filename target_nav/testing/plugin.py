"""The pytest plugin. Installed with target_nav, pytest knows it by itself:

- `*.yaml` in a folder named `scenarios` is collected if it names a mission and scenarios; each scenario is a test;
- the fixture `scripted_mission` makes a `ScriptedMission`, and closes it at the test's end.

It costs nothing where neither is used: what it needs is imported with the first scenario or fixture.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Any

import pytest

if TYPE_CHECKING:
    from target_nav.mission.scenario_model import Scenario
    from target_nav.mission.scripted_mission import ScriptedMission

    MakeMission = Callable[..., ScriptedMission]

FOLDER = "scenarios"
SUFFIXES = (".yaml", ".yml")


def pytest_collect_file(file_path: Path, parent: pytest.Collector) -> ScenarioFile | None:
    if file_path.suffix not in SUFFIXES or FOLDER not in (folder.name for folder in file_path.parents):
        return None
    from target_nav.mission.scenario_find import is_scenario_file

    if not is_scenario_file(file_path):
        return None
    file: ScenarioFile = ScenarioFile.from_parent(parent, path=file_path)
    return file


class ScenarioFile(pytest.File):
    def collect(self) -> Iterable[pytest.Item]:
        from target_nav.errors import MissionError
        from target_nav.mission.scenario_file import read_scenarios

        try:
            scenarios = read_scenarios(self.path)
        except MissionError as error:
            raise self.CollectError(str(error)) from None
        for scenario in scenarios:
            yield ScenarioItem.from_parent(self, name=scenario.name, scenario=scenario)


class ScenarioItem(pytest.Item):
    """One scenario."""

    def __init__(self, *, scenario: Scenario, **rest: Any) -> None:
        super().__init__(**rest)
        self.scenario = scenario

    def runtest(self) -> None:
        from target_nav.mission.scenario_run import run_scenario

        result = run_scenario(self.scenario)
        if not result.passed:
            raise ScenarioFailed(result.explain())

    def repr_failure(self, excinfo: pytest.ExceptionInfo[BaseException], style: Any = None) -> Any:
        from target_nav.errors import TargetNavError

        if isinstance(excinfo.value, (ScenarioFailed, TargetNavError)):
            return str(excinfo.value)
        return super().repr_failure(excinfo, style)

    def reportinfo(self) -> tuple[Path, int | None, str]:
        return self.path, self.scenario.place.line - 1, f"{self.path.name}: {self.scenario.name}"


class ScenarioFailed(AssertionError):
    """An expectation was not met; the text is for a person."""


@pytest.fixture
def scripted_mission() -> Iterator[MakeMission]:
    """Makes a `ScriptedMission` (same arguments); the last one made is closed with the test.

    def test_it_goes_to_what_it_sees(scripted_mission):
        mission = scripted_mission("trees/bowling_pin.xml")
        mission.say("GO")
        mission.set(track={"range_m": 2.0})
        mission.run_for(0.5)
        assert mission.leaf == "NavigateToTarget"
    """
    from target_nav.mission.scripted_mission import ScriptedMission

    open_missions: list[ScriptedMission] = []

    def make(*arguments: Any, **options: Any) -> ScriptedMission:
        while open_missions:
            open_missions.pop().close()
        mission = ScriptedMission(*arguments, **options)
        open_missions.append(mission)
        return mission

    yield make
    for mission in open_missions:
        mission.close()
