"""The mission in docs/mission-language.md is one, and the page tells of every node there is and is not."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from target_nav.mission import NodeRegistry, load_mission
from target_nav.mission.btcpp import NOT_YET

PAGE = Path(__file__).parents[3] / "docs" / "mission-language.md"

pytestmark = pytest.mark.skipif(not PAGE.is_file(), reason="docs/ is not installed with the package")


def test_the_example_loads(tmp_path: Path) -> None:
    (example,) = re.findall(r"```xml\n(.*?)```", PAGE.read_text(encoding="utf-8"), flags=re.DOTALL)
    path = tmp_path / "mission.xml"
    path.write_text(example, encoding="utf-8")
    assert load_mission(path).main_tree == "Main"


def test_every_built_in_is_in_the_table() -> None:
    table = PAGE.read_text(encoding="utf-8").split("## Nodes")[1].split("## Values")[0]
    for name in NodeRegistry().names():
        assert f"`{name}`" in table, name


def test_what_is_not_there_yet_is_told() -> None:
    section = PAGE.read_text(encoding="utf-8").split("## Not supported yet")[1]
    for name in set(NOT_YET) - {"ConsumeQueue", "PopFromQueue", "ManualSelector"}:
        shown = re.sub(r"^(Switch|Loop).*", r"\1", name)
        assert f"`{shown}" in section, name
