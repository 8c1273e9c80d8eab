"""The corpus of broken missions: each file in `broken/` says at its end, line by line, what must be said of it."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from target_nav.errors import MissionError
from target_nav.mission import load_mission
from target_nav.mission.check import check_file
from tests.unit.mission.vocabulary import registry

FOLDER = Path(__file__).parent / "broken"
FILES = sorted(path.name for path in FOLDER.glob("*.xml"))
EXPECTED = re.compile(r"<!-- expect (.*?) -->\n")


@pytest.mark.parametrize("name", FILES)
def test_the_message(name: str) -> None:
    expected = EXPECTED.findall((FOLDER / name).read_text(encoding="utf-8"))
    assert expected, "a broken file says what is to be said of it"
    assert [
        str(problem).replace(f"{FOLDER}/", "") for problem in check_file(FOLDER / name, registry())
    ] == expected


@pytest.mark.parametrize("name", FILES)
def test_a_mission_with_errors_is_not_loaded_and_all_errors_are_told(name: str) -> None:
    errors = [
        str(problem) for problem in check_file(FOLDER / name, registry()) if problem.severity == "error"
    ]
    with pytest.raises(MissionError) as caught:
        load_mission(FOLDER / name, registry())
    assert str(caught.value).splitlines() == errors


def test_there_are_enough_of_them() -> None:
    assert len(FILES) >= 60


def test_a_file_that_is_not_there() -> None:
    with pytest.raises(MissionError, match=r"^nowhere/mission.xml:1:1: error: there is no such file$"):
        load_mission("nowhere/mission.xml", registry())
