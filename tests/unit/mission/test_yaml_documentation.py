"""The missions in docs/missions-yaml.md are missions, and its table says what the reader does."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from target_nav.mission.check import check_file
from target_nav.mission.convert import convert
from target_nav.mission.notations import Notation

PAGE = Path(__file__).parents[3] / "docs" / "missions-yaml.md"

pytestmark = pytest.mark.skipif(not PAGE.is_file(), reason="docs/ is not installed with the package")


def blocks() -> list[str]:
    return re.findall(r"```yaml\n(.*?)```", PAGE.read_text(encoding="utf-8"), flags=re.DOTALL)


def test_every_example_is_a_mission_in_the_form_that_is_written(tmp_path: Path) -> None:
    first, *others = blocks()
    assert others
    for text in (first, *others):
        path = tmp_path / "mission.yaml"
        path.write_text(text, encoding="utf-8")
        assert [str(problem) for problem in check_file(path)] == []
    path.write_text(first, encoding="utf-8")
    assert convert(path, Notation.YAML) == first


@pytest.mark.parametrize(
    ("xml", "yaml"),
    [
        ("<Idle/>", "Idle:"),
        ('<TurnSearch time_limit_s="30"/>', "TurnSearch: {time_limit_s: 30}"),
        ('<SubTree ID="Find" why="{why}"/>', 'SubTree: {ID: Find, why: "{why}"}'),
        ('<Action ID="Idle" name="wait"/>', "Action: {ID: Idle, name: wait}"),
        ('<Idle _skipIf="battery &lt; 20"/>', 'Idle: {_skipIf: "battery < 20"}'),
    ],
)
def test_the_table(xml: str, yaml: str, tmp_path: Path) -> None:
    path = tmp_path / "mission.xml"
    path.write_text(
        f'<root BTCPP_format="4"><BehaviorTree ID="M">{xml}</BehaviorTree></root>', encoding="utf-8"
    )
    assert convert(path, Notation.YAML).splitlines()[-1].strip() in (yaml, f"M: {yaml.rstrip(':')}")
