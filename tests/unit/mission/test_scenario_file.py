"""Everything wrong in a scenario file, all of it at once, each with its line."""

from __future__ import annotations

from pathlib import Path

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from target_nav.errors import MissionError
from target_nav.mission.scenario_file import read_scenarios
from target_nav.mission.scenario_find import find_scenario_files, shipped
from target_nav.state.types import CommandKind
from tests.unit.mission.scenarios import MISSION, one, write


def problems(path: Path) -> list[tuple[int, str]]:
    with pytest.raises(MissionError) as told:
        read_scenarios(path)
    found = []
    for line in str(told.value).splitlines():
        place, text = line.split(": error: ", 1)
        assert place.startswith(f"{path}:"), line
        found.append((int(place.rsplit(":", 1)[1]), text))
    return found


def test_a_scenario_is_what_it_says(tmp_path: Path) -> None:
    scenario = one(
        tmp_path,
        """
        robot: stands
        script:
          - {at: 2, say: [STOP, GO]}
        expect:
          - {at: 3, leaf: Idle}
        """,
    )
    assert (scenario.name, scenario.drives, scenario.lasts_s) == ("it", False, 3.0)
    assert scenario.script[0].words == (CommandKind.STOP, CommandKind.GO)
    assert scenario.mission == tmp_path / "scenarios" / ".." / "mission.xml"
    assert str(scenario.place).endswith("some.yaml:3")


EXPECT = "expect: [{at: 1, leaf: Idle}]"


@pytest.mark.parametrize(
    ("parts", "line", "words"),
    [
        ("expect: [{leaf: Idle}]", 4, "does not say when"),
        ("expect: [{at: 1, from: 2, leaf: Idle}]", 4, "says at and from"),
        ("expect: [{after: 1, leaf: Idle}]", 4, "after with within_s or within_ticks"),
        ("expect: [{within_s: 1, leaf: Idle}]", 4, "says within_s"),
        ("expect: [{at: 1}]", 4, "expects nothing"),
        ("expect: [{at: 1, leaf: Idle, states: [IDLE]}]", 4, "a trace and something else"),
        ("expect: [{at: 1, laef: Idle}]", 4, "did you mean 'leaf'?"),
        ("expect: [{at: soon, leaf: Idle}]", 4, "at is 'soon'; it must be a number in s"),
        ("expect: [{at: 3601, leaf: Idle}]", 4, "0 ... 3600 s"),
        ("expect: [{from: 2, to: 1, leaf: Idle}]", 4, "ends at 1 s, before it begins at 2 s"),
        ("expect: [{after: 1, within_ticks: 0, leaf: Idle}]", 4, "a whole number from 1 on"),
        ("expect: [{after: 1, within_ticks: 1.5, leaf: Idle}]", 4, "a whole number from 1 on"),
        ("expect: [{at: 1, state: IDEL}]", 4, 'did you mean "IDLE"'),
        ("expect: [{at: 1, outcome: done}]", 4, "it must be one of succeeded, failed, none"),
        ("expect: [{at: 1, moves: fast}]", 4, "true or false"),
        ("expect: [{at: 1, status: {Idle: RUNING}}]", 4, 'did you mean "RUNNING"'),
        ("expect: [{at: 1, status: [Idle]}]", 4, "must be a mapping"),
        ("expect: [{at: 1, message: {Idle: 3}}]", 4, "must be a word"),
        ("expect: [{at: 1, board: {trak: none}}]", 4, 'did you mean "track"'),
        ("expect: [{at: 1, board: {track: {above: x}}}]", 4, "above is 'x'"),
        ("expect: [{at: 1, not: {}}]", 4, "not has no conditions"),
        ("expect: [{at: 1, not: {not: {leaf: Idle}}}]", 4, "not has no key 'not'"),
        ("expect: [{at: 1, states: [IDLE, FLYING]}]", 4, "there is no state 'FLYING'"),
        ("expect: [{at: 0, leaf: Idle}]", 3, "names no time"),
        ("expect: []", 4, "expect is empty"),
        (f"script: [{{say: GO}}]\n{EXPECT}", 4, "lacks at"),
        (f"script: [{{at: 1, say: HALT}}]\n{EXPECT}", 4, "the words are GO, STOP, PAUSE, RESUME, STEP"),
        (f"script: [{{at: 1, trak: none}}]\n{EXPECT}", 4, 'did you mean "track"'),
        (f"script: [{{at: 1, request: none}}]\n{EXPECT}", 4, "a script can only expect it"),
        (f"script: [{{at: -1, say: GO}}]\n{EXPECT}", 4, "0 ... 3600 s"),
        (f"lasts_s: 0.5\n{EXPECT}", 4, "lasts_s is 0.5 s, but it names 1 s"),
        (f"robot: flies\n{EXPECT}", 4, "drives or stands"),
        (f"mocks: {{Idle: SUCESS}}\n{EXPECT}", 4, "SUCCESS, FAILURE, RUNNING"),
        (f"mocks: {{Idle: [RUNNING x 0]}}\n{EXPECT}", 4, "RUNNING x 3"),
        (f"mocks: {{Idle: {{return: SUCCESS}}}}\n{EXPECT}", 4, "did you mean 'returns'?"),
        (f"mocks: {{Idle: {{after_s: -1}}}}\n{EXPECT}", 4, "after_s is -1 s"),
        (f"mocks: {{Idle: {{twist: {{x: 1}}}}}}\n{EXPECT}", 4, "twist has no 'x'"),
        (f"nmae: x\n{EXPECT}", 4, "did you mean 'name'?"),
        ("lasts_s: 2", 3, "lacks expect"),
    ],
)
def test_one_mistake(tmp_path: Path, parts: str, line: int, words: str) -> None:
    lines = parts.splitlines()
    text = "- name: it\n" + "\n".join(f"  {each}" for each in lines)
    found = problems(write(tmp_path, text))
    assert len(found) == 1, found
    assert found[0][0] == line
    assert words in found[0][1]


def test_all_mistakes_are_told_at_once_also_those_against_the_mission(tmp_path: Path) -> None:
    path = write(
        tmp_path,
        """
        - name: one
          script: [{at: x, say: GO}]
          expect: [{at: 1, leaf: Idel}]
        - name: two
          mocks: {TurnSerch: SUCCESS}
          expect: [{at: 1, state: SLEEPING}]
        """,
    )
    found = problems(path)
    assert [line for line, _ in found] == [4, 5, 7, 8]
    assert [text for _, text in found if "Idel" in text or "TurnSerch" in text] == [found[1][1], found[2][1]]


@pytest.mark.parametrize(
    ("text", "line", "words"),
    [
        ("", 1, "the file is empty; see docs/scenarios.md"),
        ("mission: ../mission.xml\n", 1, "lacks scenarios"),
        ("scenarios:\n  - name: x\n    expect: [{at: 1, leaf: Idle}]\n", 1, "lacks mission"),
        ("mission: gone.xml\nscenarios: []\n", 1, "there is no file"),
        ("mission: ../mission.xml\nscenarios: []\n", 2, "scenarios is empty"),
        ("mission: ../mission.xml\nscenarios: {a: 1}\n", 2, "must be a list"),
        ("mission: ../mission.xml\nscenarios: [a]\n", 2, "must be a mapping"),
        ("mission: ../mission.xml\nscenarios: [}\n", 2, "not YAML"),
        ("mission: ../mission.xml\nscenarios: [&a {}, *a]\n", 2, "alias"),
        ("mission: ../mission.xml\nextra: 1\nscenarios: [a]\n", 2, "no key 'extra'"),
        ("- a\n", 1, "must be a mapping"),
    ],
)
def test_files_that_are_none(tmp_path: Path, text: str, line: int, words: str) -> None:
    path = write(tmp_path, "")
    path.write_text(text, encoding="utf-8")
    found = problems(path)
    assert (line, True) in [(at, words in told) for at, told in found], found


def test_a_file_that_is_not_there(tmp_path: Path) -> None:
    with pytest.raises(MissionError, match="cannot be read"):
        read_scenarios(tmp_path / "none.yaml")


YAML_VALUES = st.recursive(
    st.none() | st.booleans() | st.integers() | st.floats() | st.text(max_size=8),
    lambda inner: (
        st.lists(inner, max_size=3)
        | st.dictionaries(
            st.sampled_from(
                ["at", "say", "track", "name", "expect", "script", "mocks", "leaf", "states", "board", "not"]
            ),
            inner,
            max_size=3,
        )
    ),
    max_leaves=12,
)


@settings(max_examples=150, suppress_health_check=[HealthCheck.function_scoped_fixture], deadline=None)
@given(st.lists(YAML_VALUES, max_size=2))
def test_whatever_a_file_holds_there_is_no_other_error(tmp_path: Path, scenarios: list[object]) -> None:
    import yaml

    path = write(tmp_path, "")
    path.write_text(yaml.safe_dump({"mission": "../mission.xml", "scenarios": scenarios}), encoding="utf-8")
    told = ": error: "
    try:
        read_scenarios(path)
    except MissionError as error:
        told = str(error)
    assert ": error: " in told


# -- which files -------------------------------------------------------------------------------------------------------


def test_a_mission_stands_for_the_scenarios_that_name_it(tmp_path: Path) -> None:
    path = write(tmp_path, "- {name: it, expect: [{at: 1, leaf: Idle}]}")
    other = tmp_path / "other.xml"
    other.write_text(MISSION, encoding="utf-8")
    path.with_name("other.yaml").write_text("mission: ../other.xml\nscenarios: []\n", encoding="utf-8")
    assert find_scenario_files([tmp_path / "mission.xml"]) == [path]
    assert find_scenario_files([path]) == [path]
    assert find_scenario_files([tmp_path]) == [path.with_name("other.yaml"), path]
    assert find_scenario_files([path, path]) == [path]


def test_other_yaml_in_a_folder_is_left_alone(tmp_path: Path) -> None:
    path = write(tmp_path, "- {name: it, expect: [{at: 1, leaf: Idle}]}")
    path.with_name("compose.yaml").write_text("services: {}\n", encoding="utf-8")
    assert find_scenario_files([path.parent]) == [path]


@pytest.mark.parametrize("name", ["gone.yaml", "gone"])
def test_what_is_not_there_is_told(tmp_path: Path, name: str) -> None:
    with pytest.raises(MissionError, match="there is no such file or folder"):
        find_scenario_files([tmp_path / name])


def test_a_mission_without_scenarios_is_told(tmp_path: Path) -> None:
    (tmp_path / "mission.xml").write_text(MISSION, encoding="utf-8")
    with pytest.raises(MissionError, match="no scenarios for it"):
        find_scenario_files([tmp_path / "mission.xml"])


def test_without_a_name_it_is_those_that_come_along() -> None:
    found = find_scenario_files([])
    assert found
    assert all(path.is_relative_to(shipped()) for path in found)
