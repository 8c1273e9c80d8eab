"""`target-nav test`: which scenarios are run, what is printed, which exit code."""

from __future__ import annotations

from pathlib import Path

import pytest
from click.testing import CliRunner, Result

from target_nav.app.commands.test import command
from target_nav.errors import MissionError
from tests.unit.mission.scenarios import write

GOOD = "- {name: waits for GO, expect: [{at: 1, leaf: Idle}]}"
BAD = "- {name: searches at once, expect: [{at: 1, leaf: TurnSearch}]}"
BROKEN = "- {name: misspelt, expect: [{at: 1, laef: Idle}]}"
NOT_OF_THE_MISSION = "- {name: no such leaf, expect: [{at: 1, leaf: Idel}]}"


def run(path: Path | str, *options: str) -> Result:
    return CliRunner().invoke(command, [str(path), *options])


def test_all_passed_is_0(tmp_path: Path) -> None:
    result = run(write(tmp_path, GOOD))
    assert result.exit_code == 0
    assert "ok      some.yaml: waits for GO  (1 s)" in result.stdout
    assert "1 scenario: 1 passed in " in result.stdout
    assert "what happened" not in result.stdout


def test_one_that_failed_is_1_and_explained(tmp_path: Path) -> None:
    result = run(write(tmp_path, f"{GOOD}\n{BAD}"))
    assert result.exit_code == 1
    assert "FAILED  some.yaml: searches at once" in result.stdout
    assert "some.yaml:4: expected at 1 s: leaf is TurnSearch" in result.stdout
    assert "at 1.00 s leaf is Idle, not TurnSearch" in result.stdout
    assert "2 scenarios: 1 passed, 1 failed in " in result.stdout


@pytest.mark.parametrize("broken", [BROKEN, NOT_OF_THE_MISSION])
def test_one_that_cannot_be_run_is_2_and_the_other_files_are_run_all_the_same(
    tmp_path: Path, broken: str
) -> None:
    path = write(tmp_path, broken)
    path.rename(path.with_name("broken.yaml"))
    result = run(write(tmp_path, GOOD).parent)
    assert result.exit_code == 2
    assert "broken.yaml:3: error: " in result.stderr
    assert "1 scenario: 1 passed, 1 broken in " in result.stdout


def test_one_is_chosen_by_its_name(tmp_path: Path) -> None:
    path = write(tmp_path, f"{GOOD}\n{BAD}")
    assert run(path, "-k", "WAITS").exit_code == 0
    assert run(path, "-k", "searches*once").exit_code == 1
    nothing = run(path, "-k", "nothing")
    assert (nothing.exit_code, "0 scenarios" in nothing.stdout) == (2, True)


def test_it_stops_at_the_first_that_fails_if_told_to(tmp_path: Path) -> None:
    result = run(write(tmp_path, f"{BAD}\n{GOOD}"), "-x")
    assert result.exit_code == 1
    assert "waits for GO" not in result.stdout


def test_what_happened_is_shown_on_request(tmp_path: Path) -> None:
    assert "0.00 s  IDLE           Idle" in run(write(tmp_path, GOOD), "-v").stdout


def test_a_mission_stands_for_its_scenarios(tmp_path: Path) -> None:
    write(tmp_path, GOOD)
    assert run(tmp_path / "mission.xml").exit_code == 0


def test_the_name_of_a_shipped_mission_stands_for_its_scenarios() -> None:
    result = run("there_and_back", "-k", "STOP on the way home")
    assert (result.exit_code, result.stdout.splitlines()[-1][:20]) == (0, "1 scenario: 1 passed")


def test_what_is_not_there_is_told(tmp_path: Path) -> None:
    result = run(tmp_path / "gone.yaml")
    assert isinstance(result.exception, MissionError)
    assert "there is no such file or folder" in str(result.exception)
