"""The schema for editors: it takes what the loader takes, and underlines what can be told without the whole mission."""

from __future__ import annotations

from pathlib import Path
from typing import Any
from xml.etree import ElementTree

import pytest
from py_trees.ports import PortInformation

from target_nav.mission import NodeRegistry, default_registry
from target_nav.mission.check import check_file
from target_nav.mission.xsd import write_xsd
from tests.unit.mission.oracle import make_trial
from tests.unit.mission.scripted import document, leaf_class, scripted_leaves
from tests.unit.mission.vocabulary import registry

XS = "{http://www.w3.org/2001/XMLSchema}"
FOLDER = Path(__file__).parent / "broken"
REFERENCE = Path(__file__).parents[3] / "trees" / "bowling_pin.xml"


def schema_of(words: NodeRegistry) -> Any:
    xmlschema = pytest.importorskip("xmlschema")
    return xmlschema.XMLSchema(write_xsd(words))


def elements(words: NodeRegistry) -> dict[str, ElementTree.Element]:
    root = ElementTree.fromstring(write_xsd(words))
    return {str(each.get("name")): each for each in root.iter(f"{XS}element") if each.get("name")}


# -- without a validator -----------------------------------------------------------------------------------------------


def test_every_word_is_an_element_and_stands_in_the_group_of_nodes() -> None:
    words = default_registry()
    root = ElementTree.fromstring(write_xsd(words))
    (group,) = (each for each in root.findall(f"{XS}group") if each.get("name") == "node")
    refs = {each.get("ref") for each in group.iter(f"{XS}element")}
    assert refs == {*words.names(), "SubTree", "Action", "Condition", "Control", "Decorator"}
    assert refs <= {each.get("name") for each in root.findall(f"{XS}element")}


def test_every_reference_is_to_something_there() -> None:
    root = ElementTree.fromstring(write_xsd(default_registry()))
    for tag in ("element", "group", "attributeGroup"):
        defined = {each.get("name") for each in root.findall(f"{XS}{tag}")}
        assert {each.get("ref") for each in root.iter(f"{XS}{tag}") if each.get("ref")} <= defined


def test_ports_are_attributes_with_their_documentation() -> None:
    drive = elements(registry())["Drive"]
    attributes = {each.get("name"): each for each in drive.iter(f"{XS}attribute")}
    assert set(attributes) == {"speed_mps", "goal", "label", "laps", "careful", "reason"}
    assert attributes["speed_mps"].get("use") == "required"
    assert attributes["label"].get("use") is None
    documentation = attributes["speed_mps"].find(f".//{XS}documentation")
    assert documentation is not None
    assert documentation.text == "Input: how fast (a finite number in m/s; 0.02 ... 5)"


# -- with one ----------------------------------------------------------------------------------------------------------


def test_the_reference_mission_is_valid() -> None:
    schema_of(default_registry()).validate(REFERENCE.read_text(encoding="utf-8"))


@pytest.mark.parametrize("chunk", range(2))
def test_what_the_loader_takes_is_valid(chunk: int, tmp_path: Path) -> None:
    for seed in range(chunk * 5, chunk * 5 + 5):
        trial = make_trial(seed)
        words = NodeRegistry(scripted_leaves(trial.scripts, []))
        path = tmp_path / "trial.xml"
        path.write_text(trial.xml, encoding="utf-8")
        assert not [problem for problem in check_file(path, words) if problem.severity == "error"]
        schema_of(words).validate(trial.xml)


GOOD = [
    "<Drive speed_mps='1'/>",
    "<Drive speed_mps=' 0.5 ' careful='TRUE' laps='+3'/>",
    "<Drive speed_mps='{fast}' laps='{=}' reason='{why}' name='x' _description='y'/>",
    "<Action ID='Drive' speed_mps='1'/>",
    "<Sequence><Look/><SubTree ID='T' any='thing' _autoremap='true'/></Sequence>",
]
BAD = [
    "<Drive/>",
    "<Drive speed_mps='9'/>",
    "<Drive speed_mps='INF'/>",
    "<Drive speed_mps='NaN'/>",
    "<Drive speed_mps='1' laps='1.5'/>",
    "<Drive speed_mps='1' careful='yes'/>",
    "<Drive speed_mps='1' reason='why'/>",
    "<Drive speed_mps='1' lable='x'/>",
    "<Look><Look/></Look>",
    "<Lok/>",
    "<Sequence/>",
    "<Inverter><Look/><Look/></Inverter>",
    "<Action ID='Sequence'/>",
]


@pytest.mark.parametrize("tree", GOOD)
def test_valid(tree: str) -> None:
    schema_of(registry()).validate(document(tree))


@pytest.mark.parametrize("tree", BAD)
def test_invalid(tree: str) -> None:
    assert not schema_of(registry()).is_valid(document(tree))


def test_a_name_is_escaped() -> None:
    odd = leaf_class("Odd", inputs={"a": PortInformation(float, False, 'a < b & "c"')})
    odd.__doc__ = "If a < b & c."
    ElementTree.fromstring(write_xsd(NodeRegistry((odd,))))


def test_a_mission_may_name_its_schema(tmp_path: Path) -> None:
    """For an editor; the loader takes no notice."""
    named = document("<Look/>").replace(
        "<root ",
        '<root xmlns:xsi="http://www.w3.org/2001/XMLSchema-instance" xsi:noNamespaceSchemaLocation="mission.xsd" ',
    )
    path = tmp_path / "mission.xml"
    path.write_text(named, encoding="utf-8")
    assert check_file(path, registry()) == []
