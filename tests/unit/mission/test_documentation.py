"""The missions in docs/mission-language.md are some, and the page tells of every node there is and is not."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from target_nav.mission import NodeRegistry, load_mission
from target_nav.mission.btcpp import NOT_HERE
from tests.unit.mission.scripted import document

PAGE = Path(__file__).parents[3] / "docs" / "mission-language.md"

pytestmark = pytest.mark.skipif(not PAGE.is_file(), reason="docs/ is not installed with the package")


def examples() -> list[str]:
    return re.findall(r"```xml\n(.*?)```", PAGE.read_text(encoding="utf-8"), flags=re.DOTALL)


def test_the_example_loads(tmp_path: Path) -> None:
    path = tmp_path / "mission.xml"
    path.write_text(examples()[0], encoding="utf-8")
    assert load_mission(path).main_tree == "Main"


@pytest.mark.parametrize("number", [1, 2])
def test_the_pieces_of_missions_load(number: int, tmp_path: Path) -> None:
    path = tmp_path / "mission.xml"
    path.write_text(document(f"<Sequence>{examples()[number]}</Sequence>"), encoding="utf-8")
    assert load_mission(path).root.children
    assert len(examples()) == 3


def test_every_built_in_is_in_the_table() -> None:
    table = PAGE.read_text(encoding="utf-8").split("## Nodes")[1].split("## Values")[0]
    for name in NodeRegistry().names():
        assert f"`{name}`" in table, name


def test_what_is_no_node_here_is_told() -> None:
    page = PAGE.read_text(encoding="utf-8")
    for name in NOT_HERE:
        assert f"`{name}`" in page, name


def test_the_python_runs(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> None:
    (code,) = re.findall(r"```python\n(.*?)```", PAGE.read_text(encoding="utf-8"), flags=re.DOTALL)
    monkeypatch.chdir(PAGE.parents[1])
    exec(code, {})
    assert "Bowling pin" in capsys.readouterr().out
