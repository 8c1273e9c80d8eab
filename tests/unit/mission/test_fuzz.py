"""Whatever a file holds, it loads or it is a MissionError: nothing else, and soon."""

from __future__ import annotations

import tempfile
from pathlib import Path

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from py_trees.blackboard import Blackboard

from target_nav.errors import MissionError
from target_nav.mission import load_mission
from target_nav.mission.check import check_file
from tests.unit.mission.vocabulary import registry

QUICK = settings(max_examples=100, deadline=None, suppress_health_check=[HealthCheck.too_slow])
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
    "Switch2",
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
    "path",
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
]


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
            load_mission(path, REGISTRY)


@QUICK
@given(st.binary(max_size=400))
def test_any_bytes(data: bytes) -> None:
    load_or_refuse(data)


@QUICK
@given(st.text(max_size=200))
def test_any_text_inside_a_mission(text: str) -> None:
    whole = f'<root BTCPP_format="4"><BehaviorTree ID="Main">{text}</BehaviorTree></root>'
    load_or_refuse(whole.encode("utf-8", "replace"))


@QUICK
@given(st.sampled_from(SEEDS), st.data())
def test_missions_with_pieces_cut_out_doubled_and_swapped(seed: str, data: st.DataObject) -> None:
    text = seed
    for _ in range(data.draw(st.integers(1, 4))):
        begin, end = sorted(data.draw(st.tuples(st.integers(0, len(text)), st.integers(0, len(text)))))
        piece = text[begin:end]
        insert = data.draw(
            st.sampled_from(["", piece * 2, piece[::-1], "<", '"', "&", "{", "}", "\0", "]]>", "é"])
        )
        text = text[:begin] + insert + text[end:]
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


@QUICK
@given(st.lists(elements, min_size=1, max_size=3))
def test_any_tree_of_known_words(contents: list[str]) -> None:
    trees = [
        f'<BehaviorTree ID="{name}">{inside}</BehaviorTree>'
        for name, inside in zip(("Main", "T", "U"), contents)
    ]
    load_or_refuse(f'<root BTCPP_format="4" main_tree_to_execute="Main">{"".join(trees)}</root>'.encode())
