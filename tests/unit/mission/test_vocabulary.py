"""The words of a mission, told to people and to Groot2."""

from __future__ import annotations

import shutil
from pathlib import Path
from xml.etree import ElementTree

import pytest
from py_trees.ports import PortInformation

from target_nav.mission import NodeRegistry, default_registry, load_mission
from target_nav.mission.check import check_file
from target_nav.mission.vocabulary import Group, groot_model, markdown, vocabulary
from tests.unit.mission.scripted import leaf_class
from tests.unit.mission.vocabulary import registry

PAGE = Path(__file__).parents[3] / "docs" / "nodes.md"
REFERENCE = Path(__file__).parents[3] / "trees" / "bowling_pin.xml"


def test_every_word_is_there_once() -> None:
    names = [entry.name for entry in vocabulary(registry())]
    assert sorted(names) == sorted([*registry().names(), "SubTree"])


def test_every_word_and_every_port_says_what_it_is() -> None:
    for entry in vocabulary(default_registry()):
        assert entry.summary, entry.name
        assert all(port.doc for port in entry.ports), entry.name


def test_a_leaf_in_words() -> None:
    drive = next(entry for entry in vocabulary(registry()) if entry.name == "Drive")
    assert (drive.group, drive.children) == (Group.ACTION, "")
    speed, goal, label, laps, careful, reason = drive.ports
    assert (speed.type, speed.unit, speed.limits, speed.required, speed.default) == (
        "a finite number", "m/s", "0.02 ... 5", True, "required"
    )  # fmt: skip
    assert (goal.type, goal.required, goal.default) == ("Pose2D", False, "")
    assert (label.default, laps.default, careful.default) == ("drives", "1", "false")
    assert (reason.is_output, reason.default) == (True, "")


def test_what_comes_from_the_configuration_is_said() -> None:
    search = next(entry for entry in vocabulary(default_registry()) if entry.name == "TurnSearch")
    assert search.ports[0].default == "robot's configuration"


def test_leaves_that_only_look_are_conditions() -> None:
    groups = {entry.name: entry.group for entry in vocabulary(default_registry())}
    assert groups["TargetTracked"] is Group.CONDITION
    assert groups["SetTarget"] is Group.ACTION
    assert groups["Sequence"] is Group.CONTROL
    assert groups["Timeout"] is groups["SubTree"] is Group.DECORATOR
    assert groups["Sleep"] is Group.BUILT_IN


def test_markdown_of_a_leaf() -> None:
    odd = leaf_class(
        "Odd", inputs={"a": PortInformation(float, True, "one | the other")}, limits={"a": (0, 1)}
    )
    odd.__doc__ = "Takes <anything>.\n\nAnd more."
    page = markdown(vocabulary(NodeRegistry((odd,))))
    assert "- Actions: [Odd](#odd)" in page
    assert "### Odd\n\nTakes &lt;anything>.\n\nAnd more.\n" in page
    assert "| `a` | one \\| the other | a finite number | 0 ... 1 | **required** |" in page


@pytest.mark.skipif(not PAGE.is_file(), reason="docs/ is not installed with the package")
def test_the_page_in_the_docs_is_up_to_date() -> None:
    """If not: `target-nav nodes --markdown -o docs/nodes.md`."""
    assert PAGE.read_text(encoding="utf-8") == markdown(vocabulary(default_registry()))


def test_groots_palette() -> None:
    root = ElementTree.fromstring(groot_model(registry()))
    (models,) = root
    assert models.tag == "TreeNodesModel"
    drive = next(each for each in models if each.get("ID") == "Drive")
    assert drive.tag == "Action"
    ports = {
        each.get("name"): (each.tag, each.get("type"), each.get("default"), each.text)
        for each in drive
        if each.get("name")
    }
    assert ports["speed_mps"] == ("input_port", "double", None, "how fast")
    assert ports["careful"] == ("input_port", "bool", "false", "slow down near people")
    assert ports["reason"] == ("output_port", "std::string", None, "why it failed")
    assert not {"Sequence", "Timeout", "Sleep"} & {each.get("ID") for each in models}


def test_a_mission_with_groots_palette_in_it_loads(tmp_path: Path) -> None:
    model = groot_model(default_registry())
    inside = model[model.index("  <TreeNodesModel>") : model.index("</root>")]
    path = Path(shutil.copytree(REFERENCE.parent, tmp_path / "trees")) / "mission.xml"
    path.write_text(
        REFERENCE.read_text(encoding="utf-8").replace("</root>", f"{inside}</root>"), encoding="utf-8"
    )
    assert check_file(path) == []
    load_mission(path)
