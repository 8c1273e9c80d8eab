"""Pictures of missions: what they show, and that nothing in them lies on anything else."""

from __future__ import annotations

import struct
from pathlib import Path
from xml.etree import ElementTree

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from py_trees.common import Status

from target_nav.errors import MissionError
from target_nav.mission import load_mission
from target_nav.mission.check import analyse
from target_nav.mission.draw import draw_png, draw_svg, tree_of
from target_nav.mission.draw_layout import GAP_X, Pile, place, small_lines, text_width
from target_nav.mission.draw_nodes import MAX_PORT, MAX_TITLE, DrawNode, Kind, instance_paths
from target_nav.mission.draw_scene import STATUS_STYLES, Rectangle, Text, scene_of
from target_nav.mission.draw_text import plain_text_of
from target_nav.mission.tree_paths import paths_of
from tests.unit.mission.scripted import document
from tests.unit.mission.vocabulary import registry

REFERENCE = Path(__file__).parents[3] / "trees" / "bowling_pin.xml"

TREE = """
<Fallback name="either">
  <Drive speed_mps="0.5" label="to the kitchen, and not into the garden" _description="x"/>
  <Inverter><SubTree ID="T"/></Inverter>
</Fallback>"""
OTHER = '<BehaviorTree ID="T"><Sequence><Look/><Look/></Sequence></BehaviorTree>'


@pytest.fixture
def mission(tmp_path: Path) -> Path:
    path = tmp_path / "mission.xml"
    path.write_text(document(TREE, OTHER), encoding="utf-8")
    return path


def titles(tree: DrawNode) -> list[object]:
    return [tree.title, *(titles(child) for child in tree.children)]


# -- what is shown -----------------------------------------------------------------------------------------------------


def test_a_tree_with_its_subtrees_written_out(mission: Path) -> None:
    tree = tree_of(mission, registry=registry())
    assert titles(tree) == ["either", ["Drive"], ["Inverter", ["T", ["Sequence", ["Look"], ["Look"]]]]]
    drive, inverter = tree.children
    subtree = inverter.children[0]
    assert (tree.word, tree.kind, tree.symbol) == ("Fallback", Kind.CONTROL, "?")
    assert (drive.word, drive.kind, drive.ports[0]) == ("", Kind.ACTION, "speed_mps 0.5")
    assert (inverter.kind, subtree.kind, subtree.word) == (Kind.DECORATOR, Kind.SUBTREE, "SubTree")
    assert len(drive.ports[1]) == MAX_PORT
    assert drive.ports[1].endswith("…")
    assert tree.status is None


def test_long_texts_are_cut(tmp_path: Path) -> None:
    path = tmp_path / "mission.xml"
    path.write_text(document(f"<Look name='{'very ' * 20}long'/>"), encoding="utf-8")
    tree = tree_of(path, registry=registry())
    assert len(tree.title) == MAX_TITLE
    assert tree.title.endswith("…")


def test_leaves_that_only_look_are_conditions() -> None:
    kinds = {node.title: node.kind for node in _walk(tree_of(REFERENCE))}
    assert kinds["InputsFresh"] is kinds["TargetTracked"] is kinds["MissionRequested"] is Kind.CONDITION
    assert kinds["TurnSearch"] is kinds["SetTarget"] is Kind.ACTION


def _walk(tree: DrawNode) -> list[DrawNode]:
    return [tree, *(node for child in tree.children for node in _walk(child))]


def test_the_statuses_of_a_tick(mission: Path) -> None:
    statuses = {
        "/either": "RUNNING",
        "/either/Inverter/T/Sequence/Look#2": "RUNNING",
        "/either/Drive": "FAILURE",
    }
    tree = tree_of(mission, statuses, registry())
    drive, inverter = tree.children
    first, second = inverter.children[0].children[0].children
    assert [node.status for node in (tree, drive, inverter, first, second)] == [
        Status.RUNNING, Status.FAILURE, Status.INVALID, Status.INVALID, Status.RUNNING
    ]  # fmt: skip


def test_paths_are_those_of_the_behaviours() -> None:
    analysis = analyse(REFERENCE)
    assert analysis.root is not None
    assert sorted(instance_paths(analysis.root).values()) == sorted(
        paths_of(load_mission(REFERENCE).root).values()
    )


def test_what_cannot_be_drawn(mission: Path, tmp_path: Path) -> None:
    with pytest.raises(
        MissionError, match="the mission has no node /elsewhere; the recording is of another mission"
    ):
        tree_of(mission, {"/elsewhere": "RUNNING"}, registry())
    with pytest.raises(MissionError, match="there is no status 'DONE'"):
        tree_of(mission, {"/either": "DONE"}, registry())
    with pytest.raises(MissionError, match="there is no such file"):
        tree_of(tmp_path / "nowhere.xml")


# -- where it is shown -------------------------------------------------------------------------------------------------

kinds = st.sampled_from(Kind)
statuses = st.one_of(st.none(), st.sampled_from(Status))
leaves = st.builds(
    DrawNode,
    st.text("aWi →é", max_size=20),
    st.sampled_from(["", "Sequence"]),
    kinds,
    st.sampled_from(["", "→", "while"]),
    st.lists(st.text("a_ 0", max_size=MAX_PORT), max_size=4).map(tuple),
    statuses,
    st.just(()),
)
trees = st.recursive(
    leaves,
    lambda below: st.builds(
        DrawNode, st.text("aWi", max_size=20), st.just(""), kinds, st.just("?"), st.just(()), statuses,
        st.lists(below, min_size=1, max_size=4).map(tuple),
    ),
    max_leaves=25,
)  # fmt: skip

Area = tuple[float, float, float, float]


def overlap(one: Area, other: Area) -> bool:
    """Areas are (left, top, right, bottom); touching is no overlap."""
    slack = 1e-6
    return (
        one[0] < other[2] - slack
        and other[0] < one[2] - slack
        and one[1] < other[3] - slack
        and other[1] < one[3] - slack
    )


def boxes_of(root: Pile) -> list[Area]:
    return [(b.x, b.y, b.x + b.width, b.y + b.height) for pile in root.walk() for b in pile.boxes]


@settings(max_examples=60, deadline=None)
@given(trees)
def test_nothing_overlaps(tree: DrawNode) -> None:
    root = place(tree)
    boxes = boxes_of(root)
    assert len(boxes) == len(_walk(tree))
    assert min(box[1] for box in boxes) == pytest.approx(0.0, abs=1e-6)
    assert not any(overlap(a, b) for n, a in enumerate(boxes) for b in boxes[n + 1 :])
    for pile in root.walk():
        for child in pile.children:
            # nor does any box lie on the way of an edge
            start, end = pile.boxes[-1], child.boxes[0]
            assert end.x == pytest.approx(start.x + start.width + GAP_X)
            low, high = sorted((start.middle_y, end.middle_y))
            assert not any(overlap((start.x + start.width, low, end.x, high), box) for box in boxes)


@settings(max_examples=60, deadline=None)
@given(trees)
def test_children_stand_in_their_order_beside_their_parent(tree: DrawNode) -> None:
    for pile in place(tree).walk():
        entries = [child.boxes[0].middle_y for child in pile.children]
        assert entries == sorted(entries)
        if entries:
            assert pile.boxes[-1].middle_y == pytest.approx((entries[0] + entries[-1]) / 2.0)


def test_a_decorator_is_piled_on_its_child(mission: Path) -> None:
    root = place(tree_of(mission, registry=registry()))
    assert [[box.node.title for box in pile.boxes] for pile in root.walk()] == [
        ["either"], ["Drive"], ["Inverter", "T", "Sequence"], ["Look"], ["Look"]
    ]  # fmt: skip


@settings(max_examples=60, deadline=None)
@given(trees)
def test_everything_is_inside_the_picture(tree: DrawNode) -> None:
    scene = scene_of(place(tree), "a caption")
    for shape in scene.shapes:
        if isinstance(shape, Rectangle):
            assert shape.x >= 0.0
            assert shape.y >= 0.0
            assert shape.x + shape.width <= scene.width
            assert shape.y + shape.height <= scene.height
        elif isinstance(shape, Text):
            assert shape.x + text_width(shape.text, shape.size_px, shape.bold) <= scene.width + 1e-6


@pytest.mark.parametrize("bold", [False, True])
def test_texts_are_no_wider_than_they_are_taken_for(bold: bool) -> None:
    textpath = pytest.importorskip("matplotlib.textpath")
    properties = pytest.importorskip("matplotlib.font_manager").FontProperties(
        family="DejaVu Sans", weight="bold" if bold else "normal"
    )
    texts = [
        "RetryUntilSuccessful",
        "With fresh inputs",
        "stand_off_m {stand_off_m}",
        "→",
        "num_attempts -1",
        "▶ WWW mmm iii",
    ]
    texts += [node.title for node in _walk(tree_of(REFERENCE))]
    for text in texts:
        measured = textpath.TextPath((0, 0), text, size=100, prop=properties).get_extents().width
        assert measured <= text_width(text, 100, bold), text


# -- files -------------------------------------------------------------------------------------------------------------


def test_svg(mission: Path) -> None:
    svg = draw_svg(tree_of(mission, {"/either": "RUNNING"}, registry()), "a < b & c")
    root = ElementTree.fromstring(svg)
    name = "{http://www.w3.org/2000/svg}"
    texts = [each.text for each in root.iter(f"{name}text")]
    assert texts[0] == "a < b & c"
    assert {"either", "Drive", "speed_mps 0.5", "SubTree", "▶"} <= set(texts)
    strokes = [each.get("stroke") for each in root.iter(f"{name}rect")]
    # the root, and its sample in the legend
    assert strokes.count(STATUS_STYLES[Status.RUNNING].stroke) == 2


def test_svg_holds_any_name() -> None:
    node = DrawNode("\x00\ud800<&\ufffe", "", Kind.ACTION, "", ("\x1b",), None, ())
    svg = draw_svg(node)
    ElementTree.fromstring(svg.encode("utf-8"))


def test_png(mission: Path) -> None:
    pytest.importorskip("matplotlib")
    tree = tree_of(mission, registry=registry())
    png = draw_png(tree)
    assert png[:8] == b"\x89PNG\r\n\x1a\n"
    scene = scene_of(place(tree), "")
    width, height = struct.unpack(">II", png[16:24])
    assert (width, height) == pytest.approx((2 * scene.width, 2 * scene.height), abs=1.0)


def test_a_name_is_no_formula() -> None:
    """matplotlib takes what stands between two dollars for one."""
    pytest.importorskip("matplotlib")
    draw_png(DrawNode("$\\frac{$", "", Kind.ACTION, "", (), None, ()))


def test_a_picture_has_a_largest_size() -> None:
    pytest.importorskip("matplotlib")
    leaf = DrawNode("leaf", "", Kind.ACTION, "", (), None, ())
    with pytest.raises(MissionError, match=r"is too large; draw an \.svg"):
        draw_png(DrawNode("all", "", Kind.CONTROL, "", (), None, (leaf,) * 3000))


def test_text(mission: Path) -> None:
    tree = tree_of(mission, {"/either": "SUCCESS", "/either/Drive": "SUCCESS"}, registry())
    assert plain_text_of(tree).splitlines() == [
        "✔ ? either (Fallback)",
        "├── ✔ Drive  speed_mps 0.5, label to the kitchen, and not int…, _description x",
        "└── · Inverter",
        "    └── · T (SubTree)",
        "        └── · → Sequence",
        "            ├── · Look",
        "            └── · Look",
    ]


def test_small_lines_are_the_word_and_the_ports() -> None:
    node = DrawNode("a", "Drive", Kind.ACTION, "", ("speed_mps 1",), None, ())
    assert small_lines(node) == ["Drive", "speed_mps 1"]
