"""Whatever a file holds, it loads or it is a MissionError: nothing else, and soon."""

from __future__ import annotations

import tempfile
from contextlib import suppress
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st
from py_trees.behaviour import Behaviour
from py_trees.blackboard import Blackboard
from py_trees.ports import NoDataAvailable

from target_nav.errors import MissionError
from target_nav.mission import load_mission
from target_nav.mission.btcpp import CONDITIONS
from target_nav.mission.check import check_file
from target_nav.mission.nodes import halt_tree
from target_nav.mission.registry import NodeKind
from tests.unit.mission.fuzzing import FUZZ, mutilated
from tests.unit.mission.scripted import set_clock
from tests.unit.mission.vocabulary import registry

FOLDER = Path(__file__).parent / "broken"
REGISTRY = registry()

SEEDS = [path.read_text(encoding="utf-8").split("<!-- expect")[0] for path in sorted(FOLDER.glob("*.xml"))]
FRAME = (
    "SubTree",
    "Action",
    "Condition",
    "Control",
    "Decorator",
    "BehaviorTree",
    "include",
    "root",
    "py_trees.behaviours.Success",
    "py_trees.behaviours:TickCounter",
    "os:path",
)
TAGS = (*REGISTRY.names(), *FRAME)
NAMES = [
    "ID",
    "name",
    "speed_mps",
    "distance_m",
    "label",
    "num_cycles",
    "msec",
    "_autoremap",
    "_skipIf",
    "_while",
    "_onHalted",
    "_post",
    "path",
    "code",
    "if",
    "else",
    "entry",
    "key",
    "output_key",
    "value",
    "queue",
    "if_empty",
    "variable",
    "case_1",
    "case_2",
    "max_failures",
    "duration",
    "completion_status",
]
VALUES = [
    "Main",
    "T",
    "Look",
    "1",
    "-1",
    "0.5",
    "nan",
    "{a}",
    "{=}",
    "{@b}",
    "{_c}",
    "{clock/now_s}",
    "{T/a}",
    "{",
    "SUCCESS",
    "SKIPPED",
    "a",
    "a := 1",
    "a += 1; @b := 'x' .. a",
    "a == 1",
    "b &amp; 1 || !a",
    "a ? b : 'c'",
    "1;2;3",
    "py_trees.behaviours:Running",
]


def tick(root: Behaviour) -> None:
    """A few times; what leaves read may be missing, and scripts may fail."""
    for number in range(4):
        set_clock(0.05 * number)
        with suppress(MissionError, NoDataAvailable):
            root.tick_once()
    halt_tree(root)


def load_or_refuse(data: bytes) -> None:
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "mission.xml"
        path.write_bytes(data)
        Blackboard.clear()
        errors = [problem for problem in check_file(path, REGISTRY) if problem.severity == "error"]
        assert all(problem.line >= 1 and problem.column >= 1 for problem in errors)
        if errors:
            with pytest.raises(MissionError):
                load_mission(path, REGISTRY)
        else:
            tick(load_mission(path, REGISTRY).root)


@FUZZ
@given(st.binary(max_size=400))
def test_any_bytes(data: bytes) -> None:
    load_or_refuse(data)


@FUZZ
@given(st.text(max_size=200))
def test_any_text_inside_a_mission(text: str) -> None:
    whole = f'<root BTCPP_format="4"><BehaviorTree ID="Main">{text}</BehaviorTree></root>'
    load_or_refuse(whole.encode("utf-8", "replace"))


@FUZZ
@given(mutilated(SEEDS, ["<", '"', "&", "{", "}", "\0", "]]>", "é"]))
def test_missions_with_pieces_cut_out_doubled_and_swapped(text: str) -> None:
    load_or_refuse(text.encode())


def element(tag: str, attributes: dict[str, str], children: list[str]) -> str:
    said = "".join(f' {name}="{value}"' for name, value in attributes.items())
    return f"<{tag}{said}>{''.join(children)}</{tag}>"


tags = st.sampled_from(TAGS)
attributes = st.dictionaries(st.sampled_from(NAMES), st.sampled_from(VALUES), max_size=3)
elements = st.recursive(
    st.builds(element, tags, attributes, st.just([])),
    lambda children: st.builds(element, tags, attributes, st.lists(children, min_size=1, max_size=3)),
    max_leaves=12,
)


@FUZZ
@given(st.lists(elements, min_size=1, max_size=3))
def test_any_tree_of_known_words(contents: list[str]) -> None:
    trees = [
        f'<BehaviorTree ID="{name}">{inside}</BehaviorTree>'
        for name, inside in zip(("Main", "T", "U"), contents)
    ]
    load_or_refuse(f'<root BTCPP_format="4" main_tree_to_execute="Main">{"".join(trees)}</root>'.encode())


def own_attributes(tag: str) -> st.SearchStrategy[dict[str, str]]:
    """Those that the node has, and conditions."""
    spec = REGISTRY.resolve(tag)
    ports = spec.ports if spec is not None else ()
    value = st.sampled_from(VALUES)
    given_ports = st.fixed_dictionaries({}, optional=dict.fromkeys(ports, value))
    conditions = st.dictionaries(st.sampled_from(CONDITIONS), st.sampled_from(SCRIPTS), max_size=2)
    return st.builds(lambda *parts: {**parts[0], **parts[1]}, given_ports, conditions)


def fitting(tag: str, said: dict[str, str], children: list[str]) -> str:
    """With as many children as the node takes."""
    spec = REGISTRY.resolve(tag)
    least, most = spec.children if spec is not None else (0, 0)
    padded = [*children, *(["<Look/>"] * least)]
    return element(tag, said, padded[: len(children) if most is None else most] or padded[:least])


KINDS = {kind: [spec.name for spec in REGISTRY.specs() if spec.kind is kind] for kind in NodeKind}
LEAVES = [*KINDS[NodeKind.LEAF], "py_trees.behaviours:TickCounter", "py_trees.behaviours.Failure"]
INNER = [*KINDS[NodeKind.CONTROL], *KINDS[NodeKind.DECORATOR]]
SCRIPTS = [value for value in VALUES if any(each in value for each in ("a", "b", "1")) and "{" not in value]

leaves = st.sampled_from(LEAVES).flatmap(
    lambda tag: st.builds(fitting, st.just(tag), own_attributes(tag), st.just([]))
)
fitting_elements = st.recursive(
    leaves,
    lambda children: st.sampled_from(INNER).flatmap(
        lambda tag: st.builds(
            fitting, st.just(tag), own_attributes(tag), st.lists(children, min_size=1, max_size=3)
        )
    ),
    max_leaves=8,
)


@FUZZ
@given(st.lists(fitting_elements, min_size=1, max_size=2))
def test_any_tree_of_words_in_their_places(contents: list[str]) -> None:
    begin = """<Script code="a := 1; b := 'x'; c := 0.5"/>"""
    trees = [
        f'<BehaviorTree ID="{name}"><Sequence>{begin}{inside}</Sequence></BehaviorTree>'
        for name, inside in zip(("Main", "T"), contents)
    ]
    load_or_refuse(f'<root BTCPP_format="4" main_tree_to_execute="Main">{"".join(trees)}</root>'.encode())
