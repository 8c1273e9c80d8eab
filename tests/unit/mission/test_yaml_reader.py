from __future__ import annotations

from pathlib import Path

import pytest

from target_nav.mission import load_mission, yaml_reader_elements, yaml_reader_nodes
from target_nav.mission.check import check_file
from target_nav.mission.parse import MAX_BYTES, MAX_DEPTH, Element
from target_nav.mission.problems import Report
from target_nav.mission.yaml_reader import parse_yaml_bytes
from target_nav.mission.yaml_reader_elements import is_xml_name
from target_nav.mission.yaml_reader_nodes import MAX_LEVELS
from tests.unit.mission.vocabulary import registry


def parse(text: str | bytes) -> Element:
    report = Report()
    root = parse_yaml_bytes(text.encode() if isinstance(text, str) else text, "m.yaml", report)
    assert root is not None, report.problems()
    return root


def refused(text: str | bytes) -> list[str]:
    report = Report()
    root = parse_yaml_bytes(text.encode() if isinstance(text, str) else text, "m.yaml", report)
    assert root is None or report.has_errors
    return [str(problem) for problem in report.problems()]


def shown(element: Element) -> str:
    """An element as a line of XML would have it, for comparison only."""
    said = "".join(f' {each.name}="{each.value}"' for each in element.attributes)
    return f"<{element.tag}{said}>{element.text}{''.join(map(shown, element.children))}</{element.tag}>"


def tree(node: str) -> str:
    """The XML that a tree's node in YAML stands for."""
    indented = "\n".join(f"    {line}" for line in node.splitlines())
    root = parse(f"BTCPP_format: 4\ntrees:\n  Main:\n{indented}\n")
    (behavior_tree,) = root.children
    (made,) = behavior_tree.children
    return shown(made)


def test_the_frame_of_a_file() -> None:
    root = parse(
        "BTCPP_format: 4\n"
        "main_tree_to_execute: Main\n"
        "include:\n"
        "- parts/a.yaml\n"
        "- {path: b.xml, ros_pkg: nav}\n"
        "trees: {Main: Look, Other: {_description: no more, Look: {name: x}}}\n"
        "TreeNodesModel:\n"
        "- SubTree:\n"
        "    ID: Main\n"
        "    children:\n"
        '    - input_port: {name: a, default: "0.1", text: how far}\n'
    )
    assert shown(root) == (
        '<root BTCPP_format="4" main_tree_to_execute="Main">'
        '<include path="parts/a.yaml"></include><include path="b.xml" ros_pkg="nav"></include>'
        '<BehaviorTree ID="Main"><Look></Look></BehaviorTree>'
        '<BehaviorTree ID="Other" _description="no more"><Look name="x"></Look></BehaviorTree>'
        '<TreeNodesModel><SubTree ID="Main"><input_port name="a" default="0.1">how far</input_port></SubTree>'
        "</TreeNodesModel></root>"
    )


@pytest.mark.parametrize(
    ("node", "xml"),
    [
        ("Look:", "<Look></Look>"),
        ("Look: {}", "<Look></Look>"),
        ("Drive: {speed_mps: 0.10}", '<Drive speed_mps="0.10"></Drive>'),
        ("Drive:\n  speed_mps: 0.10\n  name: go", '<Drive speed_mps="0.10" name="go"></Drive>'),
        (
            "Sequence:\n- A\n- B: {x: 1}\n- C:\n    x: 2",
            '<Sequence><A></A><B x="1"></B><C x="2"></C></Sequence>',
        ),
        ("Sequence:\n  name: all\n  children: [A, B]", '<Sequence name="all"><A></A><B></B></Sequence>'),
        ("Inverter: [Action: {ID: A}]", '<Inverter><Action ID="A"></Action></Inverter>'),
        ("SubTree: {ID: T, children: 3}", '<SubTree ID="T" children="3"></SubTree>'),
        ('A: {_skipIf: "a < 3 && b"}', '<A _skipIf="a < 3 && b"></A>'),
        ("Script:\n  code: >-\n    a := 1;\n    b := 2", '<Script code="a := 1; b := 2"></Script>'),
        ("Script:\n  code: |-\n    a := 1\n    b := 2", '<Script code="a := 1\nb := 2"></Script>'),
    ],
)
def test_nodes(node: str, xml: str) -> None:
    assert tree(node) == xml


@pytest.mark.parametrize(
    "text",
    [
        "0.10",
        "1e-3",
        "0x1F",
        "010",
        "yes",
        "null",
        "~",
        "2020-01-01",
        "1_000",
        "on",
        ".inf",
        "1:30",
        "<<",
        "=",
    ],
)
def test_a_value_is_what_is_written_and_never_converted(text: str) -> None:
    assert tree(f"A:\n  x: {text}") == f'<A x="{text}"></A>'


def test_places_are_those_of_names() -> None:
    root = parse("BTCPP_format: 4\ntrees:\n  Main:\n    Sequence:\n    - Drive:\n        speed_mps: 1\n")
    behavior_tree = root.children[0]
    drive = behavior_tree.children[0].children[0]
    assert [(each.line, each.column) for each in (behavior_tree.position, drive.position)] == [(3, 3), (5, 7)]
    assert str(drive.attributes[0].position) == "m.yaml:6:9"


def test_columns_count_characters() -> None:
    root = parse("BTCPP_format: 4\ntrees: {Mäin: {Drive: {name: äöü, x: 1}}}\n")
    drive = root.children[0].children[0]
    assert [each.position.column for each in drive.attributes] == [24, 35]


def test_line_ends_of_every_kind() -> None:
    for end in ("\n", "\r\n", "\r"):
        root = parse(end.join(["\ufeffBTCPP_format: 4", "trees:", "  Main: Look", ""]))
        assert root.children[0].position.line == 3


def test_an_xml_and_a_yaml_file_may_include_each_other(tmp_path: Path) -> None:
    (tmp_path / "look.xml").write_text(
        '<root BTCPP_format="4"><BehaviorTree ID="T"><Look/></BehaviorTree></root>'
    )
    (tmp_path / "more.YML").write_text(
        "BTCPP_format: 4\ninclude: [look.xml]\ntrees: {U: {SubTree: {ID: T}}}\n"
    )
    main = tmp_path / "main.xml"
    main.write_text(
        '<root BTCPP_format="4" main_tree_to_execute="M"><include path="more.YML"/>'
        '<BehaviorTree ID="M"><SubTree ID="U"/></BehaviorTree></root>'
    )
    mission = load_mission(main, registry())
    assert [path.name for path in mission.files] == ["main.xml", "more.YML", "look.xml"]
    assert [node.name for node in mission.root.iterate()] == ["Look", "T", "U"]


# -- what is refused ---------------------------------------------------------------------------------------------------


def test_aliases_cannot_grow(tmp_path: Path) -> None:
    laughs = "".join(f"a{n}: &a{n} [{', '.join([f'*a{n - 1}'] * 9) if n else 'lol'}]\n" for n in range(9))
    (message,) = refused(laughs)
    assert message.startswith("m.yaml:1:5: error: &a0 marks a place to be used again")


def test_sizes_have_limits(monkeypatch: pytest.MonkeyPatch) -> None:
    (message,) = refused(b"#" * (MAX_BYTES + 1))
    assert message == f"m.yaml:1:1: error: is larger than {MAX_BYTES} bytes, the most a mission file may have"
    monkeypatch.setattr(yaml_reader_elements, "MAX_ELEMENTS", 100)
    many = "BTCPP_format: 4\ntrees:\n  Main:\n    Sequence:\n"
    # the tree and the Sequence are two
    parse(many + "    - A\n" * 98)
    (message,) = refused(many + "    - A\n" * 99)
    assert message == "m.yaml:103:7: error: has more than 100 nodes, the most a mission file may have"
    monkeypatch.setattr(yaml_reader_nodes, "MAX_EVENTS", 1000)
    (message,) = refused("BTCPP_format: 4\nx: [" + "[]," * 1000)
    assert message.endswith("has more than 1000 values, the most a mission file may have")


@pytest.mark.parametrize("opening", ["[", "{a: ", "- ", "? "])
def test_depth_has_a_limit(opening: str) -> None:
    (message,) = refused(opening * 100_000)
    assert f"is nested more than {MAX_LEVELS} deep" in message or "a key must be a text" in message


def test_nodes_have_the_same_limit_of_depth_as_in_xml(tmp_path: Path) -> None:
    def nested(depth: int) -> str:
        lines = ["BTCPP_format: 4", "trees:", "  Main:", "    Sequence:"]
        lines += [f"{' ' * (4 + 2 * n)}- Sequence:" for n in range(depth)]
        return "\n".join([*lines, f"{' ' * (4 + 2 * depth)}- A", ""])

    # root, BehaviorTree, Sequence and the leaf are four
    parse(nested(MAX_DEPTH - 4))
    (message,) = refused(nested(MAX_DEPTH - 3))
    assert message.endswith(f"A is nested more than {MAX_DEPTH} deep; use a SubTree")


def test_names_are_those_of_xml() -> None:
    for good in ("A", "_a", "a.b-c", "é", "xsi:schema", "名前"):
        assert is_xml_name(good), good
    for bad in ("", "1a", "-a", "a b", "a/", "a=", "<<", "a>b", "*", "\ud800", "a\n"):
        assert not is_xml_name(bad), bad


def test_problems_after_the_frame_have_places_too(tmp_path: Path) -> None:
    path = tmp_path / "m.yaml"
    path.write_text(
        "BTCPP_format: 4\ntrees:\n  Main:\n    Sequence:\n    - Drive: {speed_mps: fast}\n", encoding="utf-8"
    )
    (problem,) = check_file(path, registry())
    assert (problem.line, problem.column) == (5, 15)
