"""LoopInt, LoopBool, LoopDouble, LoopString."""

from __future__ import annotations

from collections import deque
from pathlib import Path
from typing import Any

import pytest
from py_trees.blackboard import Blackboard
from py_trees.common import Status

from target_nav.errors import MissionError
from target_nav.mission.nodes import halt_tree
from tests.unit.mission.conftest import MakeTrace
from tests.unit.mission.scripted import Trace, spaced


def items_of(trace: Trace) -> list[Any]:
    """What {v} was in each tick."""
    items = []
    while trace.tick()[0] == "R":
        items.append(Blackboard.get("/v"))
    return items


@pytest.mark.parametrize(
    ("kind", "queue", "items"),
    [
        ("Int", "1;-2;3", [1, -2, 3]),
        ("Int", "7;", [7]),
        ("Double", "0.5;2", [0.5, 2.0]),
        ("Bool", "true;0", [True, False]),
        ("String", "a;b c;", ["a", "b c"]),
        ("String", "", []),
    ],
)
def test_each_item_once(kind: str, queue: str, items: list[Any], trace: MakeTrace) -> None:
    tree = trace(f"""<Loop{kind} queue="{queue}" value="{{v}}"><A/></Loop{kind}>""", A="S")
    for _ in range(2):
        found = items_of(tree)
        assert found == items
        assert [type(each) for each in found] == [type(each) for each in items]


def test_a_running_child_keeps_its_item_and_a_failure_ends_it(trace: MakeTrace) -> None:
    expected = spaced("R A>R", "R A:S", "R A>R", "F A:F", "R A>R")
    tree = trace("""<LoopInt queue="1;2;3" value="{v}"><A/></LoopInt>""", A="RSRF")
    values = []
    rows = []
    for _ in range(5):
        rows.append(tree.tick())
        values.append(Blackboard.get("/v"))
    assert (rows, values) == (expected, [1, 1, 2, 2, 1])


def test_a_halted_loop_begins_anew(trace: MakeTrace) -> None:
    tree = trace("""<LoopInt queue="1;2" value="{v}"><A/></LoopInt>""", A="SR")
    tree.ticks(2)
    assert tree.halt() == ["A!"]
    tree.tick()
    assert Blackboard.get("/v") == 1


@pytest.mark.parametrize(
    ("result", "letter"), [("SUCCESS", "S"), ("FAILURE", "F"), ("SKIPPED", "-"), ("RUNNING", "R")]
)
def test_what_an_empty_list_gives(result: str, letter: str, trace: MakeTrace) -> None:
    assert trace(f"""<LoopString queue="" if_empty="{result}"><A/></LoopString>""", A="S").tick() == [letter]


@pytest.mark.parametrize("container", [list, deque])
def test_an_entrys_items_are_taken_out_of_it(container: type, tmp_path: Path) -> None:
    tree = Trace(
        tmp_path, {"A": "S"}, """<LoopDouble queue="{q}" value="{v}"><A/></LoopDouble>""", provided=["/q"]
    )
    queue = container([1.5, 2])
    Blackboard.set("/q", queue)
    assert tree.tick()[0] == "R"
    queue.append(4.0)
    assert list(queue) == [2, 4.0]
    assert items_of(tree) == [2.0, 4.0]
    assert not queue


@pytest.mark.parametrize(
    ("queue", "message"),
    [
        ("1;2", "it must be a list with ; between, each a finite number"),
        ((1, 2), "it must be a list with ; between, each a finite number"),
        (["a"], "queue has the item 'a'; it must be a finite number"),
    ],
)
def test_what_is_no_list_of_numbers(queue: object, message: str, tmp_path: Path) -> None:
    tree = Trace(
        tmp_path, {"A": "S"}, """<LoopDouble queue="{q}" value="{v}"><A/></LoopDouble>""", provided=["/q"]
    )
    with pytest.raises(MissionError, match="queue reads /q, which nobody has written yet"):
        tree.tick()
    Blackboard.set("/q", queue)
    with pytest.raises(MissionError, match=message):
        tree.tick()


def test_a_script_can_fill_the_list(trace: MakeTrace) -> None:
    loop = """<LoopInt queue="{q}" value="{v}"><A/></LoopInt>"""
    tree = trace(f"""<Sequence><Script code="q := '4;5'"/>{loop}</Sequence>""", A="S")
    assert items_of(tree) == [4, 5]


def test_halting_a_tree_reaches_what_was_skipped_below(trace: MakeTrace) -> None:
    """A loop that is empty is skipped, but has begun; only a halt, or a list of its own, makes it begin anew."""
    inner = """<LoopInt queue="5" value="{w}" if_empty="SKIPPED"><A/></LoopInt>"""
    tree = trace(f"""<LoopInt queue="7" value="{{v}}">{inner}</LoopInt>""", A="S")
    assert tree.ticks(4) == spaced("R A>S", "R", "S", "R")
    tree.root.stop(Status.INVALID)
    assert tree.tick() == ["R", "A>S"]
    tree.ticks(2)
    halt_tree(tree.root)
    assert tree.tick() == ["R", "A>S"]
