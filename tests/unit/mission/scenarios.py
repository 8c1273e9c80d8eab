"""A small mission, and scenario files for it written by tests."""

from __future__ import annotations

from pathlib import Path
from textwrap import dedent, indent

from target_nav.mission.scenario_file import read_scenarios
from target_nav.mission.scenario_model import Scenario
from target_nav.mission.scenario_run import ScenarioResult, run_scenario
from tests.unit.mission.scripted import document

MISSION = document(
    """
    <WhileDoElse name="On request">
      <MissionRequested/>
      <Sequence name="Mission">
        <TurnSearch reason="{why}"/>
        <NavigateToTarget reason="{why}"/>
        <Arrived reason="{why}"/>
      </Sequence>
      <Idle/>
    </WhileDoElse>
    """
)


def write(folder: Path, scenarios: str, top: str = "") -> Path:
    """A folder with the mission and a file of scenarios; `scenarios` is the YAML below that key."""
    (folder / "mission.xml").write_text(MISSION, encoding="utf-8")
    path = folder / "scenarios" / "some.yaml"
    path.parent.mkdir(exist_ok=True)
    text = f"mission: ../mission.xml\n{dedent(top)}scenarios:\n{indent(dedent(scenarios).strip(), '  ')}\n"
    path.write_text(text, encoding="utf-8")
    return path


def one(folder: Path, parts: str, top: str = "") -> Scenario:
    """The only scenario of a file; `parts` is what it has besides its name."""
    (scenario,) = read_scenarios(write(folder, f"- name: it\n{indent(dedent(parts).strip(), '  ')}", top))
    return scenario


def run(folder: Path, parts: str, top: str = "") -> ScenarioResult:
    return run_scenario(one(folder, parts, top))
