"""The corpus of broken missions in YAML: each file in `broken_yaml/` says at its end what must be said of it.

An expectation that ends with `...` is the beginning of the message.
"""

from __future__ import annotations

from pathlib import Path

import pytest
import yaml

from target_nav.errors import MissionError
from target_nav.mission import load_mission, yaml_reader_nodes
from target_nav.mission.check import check_file
from tests.unit.mission.vocabulary import registry

FOLDER = Path(__file__).parent / "broken_yaml"
FILES = sorted(path.name for path in FOLDER.glob("*.yaml"))
READERS = [yaml.SafeLoader, *([yaml.CSafeLoader] if hasattr(yaml, "CSafeLoader") else [])]


def expected(name: str) -> list[str]:
    lines = (FOLDER / name).read_text(encoding="utf-8", errors="replace").splitlines()
    return [line.removeprefix("# expect ") for line in lines if line.startswith("# expect ")]


def found(name: str) -> list[str]:
    return [str(problem).replace(f"{FOLDER}/", "") for problem in check_file(FOLDER / name, registry())]


@pytest.mark.parametrize("reader", READERS)
@pytest.mark.parametrize("name", FILES)
def test_the_message(name: str, reader: type, monkeypatch: pytest.MonkeyPatch) -> None:
    """PyYAML has two readers; a mission gets the same words from both."""
    monkeypatch.setattr(yaml_reader_nodes, "_LOADER", reader)
    wanted, messages = expected(name), found(name)
    assert wanted, "a broken file says what is to be said of it"
    assert len(messages) == len(wanted), messages
    for message, words in zip(messages, wanted, strict=True):
        assert message.startswith(words.removesuffix("...")) if words.endswith("...") else message == words


@pytest.mark.parametrize("name", FILES)
def test_a_mission_with_errors_is_not_loaded_and_all_errors_are_told(name: str) -> None:
    with pytest.raises(MissionError) as caught:
        load_mission(FOLDER / name, registry())
    told = str(caught.value).replace(f"{FOLDER}/", "").splitlines()
    assert told == [message for message in found(name) if ": error: " in message]
