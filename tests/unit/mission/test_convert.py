"""One notation into the other and back: nothing is lost, and what cannot be said is refused.

`TARGET_NAV_CONVERTED_FILES=5000` tries more generated files.
"""

from __future__ import annotations

import dataclasses
import importlib
import os
from pathlib import Path
from typing import Any

import pytest
from hypothesis import HealthCheck, given, settings

from target_nav.errors import MissionError
from target_nav.mission.convert import convert, read_source
from target_nav.mission.convert_source import Part, Source, same_mission
from target_nav.mission.document import read_document
from target_nav.mission.model import MissionFile
from target_nav.mission.notations import Notation
from target_nav.mission.parse import parse_bytes
from target_nav.mission.problems import Position, Report
from target_nav.mission.xml_writer import write_xml
from target_nav.mission.yaml_reader import parse_yaml_bytes
from target_nav.mission.yaml_writer import write_yaml
from tests.unit.mission.sources import sources

FILES = int(os.environ.get("TARGET_NAV_CONVERTED_FILES", "60"))
THOROUGH = settings(
    max_examples=FILES,
    deadline=None,
    suppress_health_check=[HealthCheck.too_slow, HealthCheck.data_too_large],
)
REFERENCE = Path(__file__).parents[3] / "trees" / "bowling_pin.xml"


def plain(value: Any) -> Any:
    """A model without the places where its parts stand."""
    if isinstance(value, Position):
        return None
    if isinstance(value, tuple):
        return tuple(plain(each) for each in value)
    if dataclasses.is_dataclass(value) and not isinstance(value, type):
        return {f.name: plain(getattr(value, f.name)) for f in dataclasses.fields(value)}
    return value


def model_of(text: str, notation: Notation) -> MissionFile:
    report = Report()
    parse = parse_bytes if notation is Notation.XML else parse_yaml_bytes
    root = parse(text.encode(), "m", report)
    assert root is not None, report.problems()
    model = read_document(root, Path("m"), "m", report)
    assert not report.has_errors, report.problems()
    return model


def comments_of(source: Source) -> list[Any]:
    def of(part: Part) -> Any:
        return (part.tag, part.before, part.beside, [of(child) for child in part.children], part.end)

    return [of(source.root), source.footer]


def read(text: str, notation: Notation) -> Source:
    return read_source(text.encode(), notation, "m")


# -- laws --------------------------------------------------------------------------------------------------------------


@THOROUGH
@given(sources())
def test_nothing_is_lost(source: Source) -> None:
    xml, yaml = write_xml(source), write_yaml(source)
    from_xml, from_yaml = read(xml, Notation.XML), read(yaml, Notation.YAML)

    # what is written is read back, with its comments
    for again in (from_xml, from_yaml):
        assert same_mission(again.root, source.root)
        assert comments_of(again) == comments_of(source)

    # the loader sees the same mission in both
    assert plain(model_of(xml, Notation.XML)) == plain(model_of(yaml, Notation.YAML))

    # there and back is the same file
    assert write_xml(read(write_yaml(from_xml), Notation.YAML)) == xml
    assert write_yaml(read(write_xml(from_yaml), Notation.XML)) == yaml


# -- comments in files as people write them ----------------------------------------------------------------------------

XML = """\
<?xml version="1.0" encoding="UTF-8"?>
<!-- header
     of two lines -->
<root BTCPP_format="4">   <!-- root -->
  <include path="a.xml"/>
  <!-- one --><!-- two -->
  <BehaviorTree ID="Main"> <!-- about Main -->
    <Sequence>  <!-- all of it -->
      <!--
        a list:
          - looks
          - - drives
      -->
      <Look/><!-- looks -->
      <Drive speed_mps="1"> <!-- beside --> <!-- inside --> </Drive>
      <!-- last -->
    </Sequence>
    <!-- behind the node -->
  </BehaviorTree>
  <!-- -->
  <!-- behind the tree -->
</root>
<!-- footer -->
"""

YAML = """\
# header
# of two lines
BTCPP_format: 4
include:
  # root
  - a.xml

trees:
  # one

  # two
  Main:  # about Main
    Sequence:  # all of it
    # a list:
    #   - looks
    #   - - drives
    - Look  # looks
    # inside
    - Drive: {speed_mps: 1}  # beside
    # last

    # behind the node

# behind the tree

# footer
"""


def test_comments_of_xml_in_yaml() -> None:
    assert write_yaml(read(XML, Notation.XML)) == YAML


def test_comments_of_yaml_in_xml() -> None:
    """What XML has no place for moves to the nearest it has: a port's comment before its node, for one."""
    yaml = """\
# header
BTCPP_format: 4  # the format
# trees
trees:  # of them
  Main:
    Sequence:
      # the name
      name: "# no comment"  # a name
      children:
        # look first
        - Look  # looks -- twice
        - Drive:
            speed_mps: 1  # m/s
            label: >-  # a text
              # not a comment
            # laps: 3

        # last
      # behind it
# about T
  T: {Inverter: [Look]}  # turned round
"""
    assert (
        write_xml(read(yaml, Notation.YAML))
        == """\
<?xml version="1.0" encoding="UTF-8"?>
<!-- header -->
<!-- the format -->
<root BTCPP_format="4">

  <!-- trees -->
  <!-- of them -->
  <BehaviorTree ID="Main">
    <!-- the name -->
    <!-- a name -->
    <Sequence name="# no comment">
      <!-- look first -->
      <Look/>  <!-- looks - - twice -->
      <!-- m/s -->
      <!-- a text -->
      <!-- laps: 3 -->
      <Drive speed_mps="1" label="# not a comment"/>
      <!-- last -->
      <!-- behind it -->
    </Sequence>
  </BehaviorTree>

  <!-- about T -->
  <BehaviorTree ID="T">  <!-- turned round -->
    <Inverter>
      <Look/>
    </Inverter>
  </BehaviorTree>
</root>
"""
    )


def test_the_reference_mission_survives_to_the_byte(tmp_path: Path) -> None:
    yaml = tmp_path / "mission.yaml"
    yaml.write_text(convert(REFERENCE, Notation.YAML), encoding="utf-8")
    assert convert(yaml, Notation.XML) == REFERENCE.read_text(encoding="utf-8")


def test_a_file_in_its_own_notation_is_tidied(tmp_path: Path) -> None:
    path = tmp_path / "mission.xml"
    path.write_text("<root BTCPP_format='4'><BehaviorTree><Look   name='a&apos;b'/></BehaviorTree></root>")
    tidy = convert(path, Notation.XML)
    assert tidy == (
        '<?xml version="1.0" encoding="UTF-8"?>\n<root BTCPP_format="4">\n\n'
        '  <BehaviorTree ID="BehaviorTree_0">\n    <Look name="a\'b"/>\n  </BehaviorTree>\n</root>\n'
    )


def test_long_tags_and_long_nodes_take_several_lines() -> None:
    ports = [(f"port_{number}", "x" * 20) for number in range(5)]
    node = Part("Look", ports, "", Position("m"))
    tree = Part("BehaviorTree", [("ID", "Main")], "", Position("m"), [node])
    source = Source(Part("root", [("BTCPP_format", "4")], "", Position("m"), [tree]))
    for text, notation in ((write_xml(source), Notation.XML), (write_yaml(source), Notation.YAML)):
        assert max(map(len, text.splitlines())) < 60
        assert same_mission(read(text, notation).root, source.root)


# -- what is refused ---------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("name", "content", "message"),
    [
        ("m.xml", "<root", r"m\.xml:1:1: error: is not well-formed XML"),
        ("m.xml", "<root BTCPP_format='3'/>", r'm\.xml:1:7: error: BTCPP_format is "3"'),
        ("m.yaml", "BTCPP_format: 4\ntrees: [x]\n", r"m\.yaml:2:1: error: trees is a mapping"),
        ("m.json", "{}", r'm\.json: has suffix "\.json"; a mission file ends in \.xml, \.yaml or \.yml'),
        ("mission", "", "mission: has no suffix"),
        (
            "m.xml",
            "<root BTCPP_format='4'><BehaviorTree ID='A'><Look/></BehaviorTree>"
            "<BehaviorTree ID='A'><Look/></BehaviorTree></root>",
            r'm\.xml:1:67: error: a second tree "A" in one file',
        ),
        (
            "m.xml",
            "<root BTCPP_format='4'><BehaviorTree ID='A'><Control ID='B' children='2'><Look/></Control>"
            "</BehaviorTree></root>",
            r'm\.xml:1:45: error: <Control> has an attribute children="2", which YAML cannot tell',
        ),
        (
            "m.xml",
            "<root BTCPP_format='4'><BehaviorTree ID='A'><_uid name='x'/></BehaviorTree></root>",
            r"m\.xml as YAML:4:3: error: tree A has 0 nodes",
        ),
    ],
)
def test_what_cannot_be_converted(name: str, content: str, message: str, tmp_path: Path) -> None:
    path = tmp_path / name
    path.write_text(content, encoding="utf-8")
    with pytest.raises(MissionError, match=message):
        convert(path, Notation.YAML)


def test_a_writer_that_loses_something_is_caught(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    path = tmp_path / "m.xml"
    path.write_text(
        '<root BTCPP_format="4"><BehaviorTree ID="A"><Look name="x"/></BehaviorTree></root>', encoding="utf-8"
    )
    module = importlib.import_module("target_nav.mission.convert")
    monkeypatch.setattr(module, "write_yaml", lambda source: write_yaml(source).replace("x", "y"))
    with pytest.raises(MissionError, match="cannot be written as YAML without a change of its meaning"):
        convert(path, Notation.YAML)


def test_a_file_that_is_not_there(tmp_path: Path) -> None:
    with pytest.raises(MissionError, match="there is no such file"):
        convert(tmp_path / "m.xml", Notation.YAML)
