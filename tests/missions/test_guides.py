"""What the guides show works: their missions load without a warning, their scenarios pass, their code runs.

A fenced block with a file's name behind its language is that file, in a folder beside the subtrees that come along.
"""

from __future__ import annotations

import re
import shutil
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest

from target_nav.app.virtual import run_virtual
from target_nav.mission.check import check_file
from target_nav.mission.scenario_file import read_scenarios
from target_nav.mission.scenario_find import is_scenario_file
from target_nav.mission.scenario_run import run_scenario
from target_nav.sim.arena import load_arena

pytest_plugins = ["pytester"]

ROOT = Path(__file__).parents[2]
DOCS = ROOT / "docs"
GUIDES = ("tutorial-new-target", "scenarios", "cookbook")
BLOCK = re.compile(r"^```(\w+)(?: (\S+))?\n(.*?)^```$", re.MULTILINE | re.DOTALL)

pytestmark = pytest.mark.skipif(not DOCS.is_dir(), reason="docs/ is not installed with the package")


def blocks(guide: str) -> list[tuple[str, str, str]]:
    """(language, file's name or nothing, text)."""
    return BLOCK.findall((DOCS / f"{guide}.md").read_text(encoding="utf-8"))


@pytest.fixture
def files(request: pytest.FixtureRequest, tmp_path: Path) -> Iterator[dict[str, Path]]:
    """The guide's files by name, written as it says, beside the missions that come along."""
    trees = Path(
        shutil.copytree(ROOT / "trees", tmp_path / "trees", ignore=shutil.ignore_patterns("scenarios"))
    )
    found: dict[str, Path] = {}
    for _, name, text in blocks(request.param):
        if name:
            found[name] = trees / name
            found[name].parent.mkdir(exist_ok=True)
            found[name].write_text(text, encoding="utf-8")
    sys.path.insert(0, str(trees))
    yield found
    sys.path.remove(str(trees))
    for name in found:
        sys.modules.pop(Path(name).stem, None)


@pytest.mark.parametrize("files", GUIDES, indirect=True)
def test_its_missions_have_nothing_wrong(files: dict[str, Path]) -> None:
    missions = [path for name, path in files.items() if name.endswith(".xml")]
    assert [str(problem) for path in missions for problem in check_file(path)] == []


@pytest.mark.parametrize("files", GUIDES, indirect=True)
def test_its_scenarios_pass(files: dict[str, Path]) -> None:
    scenarios = [each for path in files.values() if is_scenario_file(path) for each in read_scenarios(path)]
    assert scenarios
    results = [run_scenario(scenario) for scenario in scenarios]
    assert [result.explain() for result in results if not result.passed] == []


@pytest.mark.parametrize("files", ["cookbook"], indirect=True)
def test_every_pattern_of_the_cookbook_has_a_mission_and_a_scenario(files: dict[str, Path]) -> None:
    patterns = re.findall(r"^## (\d+)\. ", (DOCS / "cookbook.md").read_text(encoding="utf-8"), re.MULTILINE)
    assert patterns == [str(number) for number in range(1, 12)]
    missions = {Path(name).stem for name in files if name.endswith(".xml")}
    assert missions == {path.stem for path in files.values() if is_scenario_file(path)}
    assert len(missions) == 11


@pytest.mark.parametrize("files", ["cookbook"], indirect=True)
def test_the_leaf_has_twenty_lines(files: dict[str, Path]) -> None:
    code = [line for line in files["my_leaves.py"].read_text(encoding="utf-8").splitlines() if line.strip()]
    assert len(code) <= 20


@pytest.mark.parametrize("files", ["tutorial-new-target"], indirect=True)
def test_the_tutorials_mission_arrives_in_its_arena(files: dict[str, Path]) -> None:
    arena = load_arena(str(files["bottle_arena.yaml"]))
    result = run_virtual(arena, files["bottle.xml"], seed=1)
    assert result.as_expected, result


@pytest.mark.parametrize("files", ["tutorial-new-target"], indirect=True)
def test_the_tutorial_is_right_about_what_goes_wrong(files: dict[str, Path]) -> None:
    path = files["bottle.xml"]
    text = path.read_text(encoding="utf-8")
    for right, wrong in (("SetTarget", "SetTraget"), ("stand_off_m=", "stand_off="), ('"0.25"', '"25"')):
        path.write_text(text.replace(right, wrong), encoding="utf-8")
        assert check_file(path), wrong
    path.write_text(text.replace('stand_off_m="0.15"', 'stand_off_m="0.25"'), encoding="utf-8")
    scenarios = read_scenarios(files["scenarios/bottle.yaml"])
    assert [run_scenario(scenario).passed for scenario in scenarios] == [True, False, True]


def test_the_python_of_the_scenarios_page_runs(pytester: pytest.Pytester) -> None:
    (code,) = [text for language, name, text in blocks("scenarios") if name.endswith(".py")]
    shutil.copytree(ROOT / "trees", pytester.path / "trees", ignore=shutil.ignore_patterns("scenarios"))
    pytester.makepyfile(test_my_mission=code)
    pytester.runpytest("-p", "target_nav.testing.plugin", "-p", "no:cacheprovider").assert_outcomes(passed=1)


@pytest.mark.parametrize("guide", [*GUIDES, "watching"])
def test_links_lead_somewhere(guide: str) -> None:
    for target in re.findall(r"\]\(([^)#]+)\)", (DOCS / f"{guide}.md").read_text(encoding="utf-8")):
        assert (DOCS / target).exists(), target


@pytest.mark.parametrize("guide", [*GUIDES, "watching"])
def test_commands_of_target_nav_are_there(guide: str) -> None:
    from target_nav.app.cli import COMMANDS

    text = (DOCS / f"{guide}.md").read_text(encoding="utf-8")
    assert set(re.findall(r"target-nav (\w+)", text)) <= set(COMMANDS)
