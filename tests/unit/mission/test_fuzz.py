"""Whatever a file holds, it loads or it is a MissionError: nothing else, and soon."""

from __future__ import annotations

import tempfile
from pathlib import Path

from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from py_trees.blackboard import Blackboard

from target_nav.errors import MissionError
from target_nav.mission import load_mission
from target_nav.mission.check import check_file
from tests.unit.mission.vocabulary import registry

QUICK = settings(max_examples=150, deadline=None, suppress_health_check=[HealthCheck.too_slow])
FOLDER = Path(__file__).parent / "broken"
REGISTRY = registry()

SEEDS = [
    path.read_text(encoding="utf-8").split("<!-- expect")[0]
    for path in sorted(FOLDER.glob("*.xml"))
    if path.stat().st_size
]
TAGS = [
    *REGISTRY.names(),
    "SubTree",
    "Action",
    "Condition",
    "Control",
    "Decorator",
    "BehaviorTree",
    "include",
    "root",
    "Switch2",
]
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
    "success_count",
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
    "true",
    "",
    "..",
    "{",
]


def load_or_refuse(data: bytes) -> None:
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "mission.xml"
        path.write_bytes(data)
        Blackboard.clear()
        errors = [problem for problem in check_file(path, REGISTRY) if problem.severity == "error"]
        try:
            load_mission(path, REGISTRY)
        except MissionError as error:
            assert errors
            assert str(error).count("\n") + 1 >= len(errors)
            assert all(problem.line >= 1 and problem.column >= 1 for problem in errors)
        else:
            assert not errors


@QUICK
@given(st.binary(max_size=400))
def test_any_bytes(data: bytes) -> None:
    load_or_refuse(data)


@QUICK
@given(st.text(max_size=200))
def test_any_text_inside_a_mission(text: str) -> None:
    load_or_refuse(
        f'<root BTCPP_format="4"><BehaviorTree ID="Main">{text}</BehaviorTree></root>'.encode(
            "utf-8", "replace"
        )
    )


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


nodes = st.recursive(
    st.builds(
        lambda tag, attributes: (tag, attributes, []),
        st.sampled_from(TAGS),
        st.dictionaries(st.sampled_from(NAMES), st.sampled_from(VALUES), max_size=3),
    ),
    lambda children: st.builds(
        lambda tag, attributes, inner: (tag, attributes, inner),
        st.sampled_from(TAGS),
        st.dictionaries(st.sampled_from(NAMES), st.sampled_from(VALUES), max_size=3),
        st.lists(children, min_size=1, max_size=3),
    ),
    max_leaves=12,
)


def written(node: tuple[str, dict[str, str], list[object]]) -> str:
    tag, attributes, children = node
    inside = "".join(written(child) for child in children)  # type: ignore[arg-type]
    return f"<{tag}{''.join(f' {name}={chr(34)}{value}{chr(34)}' for name, value in attributes.items())}>{inside}</{tag}>"


@QUICK
@given(st.lists(nodes, min_size=1, max_size=3))
def test_any_tree_of_known_words(trees: list[tuple[str, dict[str, str], list[object]]]) -> None:
    names = ["Main", "T", "U"]
    parts = [f'<BehaviorTree ID="{name}">{written(tree)}</BehaviorTree>' for name, tree in zip(names, trees)]
    load_or_refuse(f'<root BTCPP_format="4" main_tree_to_execute="Main">{"".join(parts)}</root>'.encode())
