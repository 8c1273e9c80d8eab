"""Pre- and postconditions: when they are asked, in which order, and what they do to the node."""

from __future__ import annotations

from pathlib import Path

import py_trees
import pytest
from py_trees.blackboard import Blackboard
from py_trees.common import Status

from target_nav.errors import MissionError
from tests.unit.mission.conftest import MakeTrace
from tests.unit.mission.scripted import Trace, names, spaced


def set_x(value: object) -> None:
    Blackboard.set("/x", value)


def with_x(folder: Path, tree: str, **scripts: str) -> Trace:
    """A mission in which somebody outside writes {x}, here 0 to begin with."""
    made = Trace(folder, scripts, tree, provided=["/x", "/y", "/log"])
    set_x(0)
    return made


@pytest.mark.parametrize(
    ("attribute", "row"),
    [
        ("_failureIf", ["F", "B>S"]),
        ("_successIf", ["S"]),
        ("_skipIf", ["F", "B>S"]),
        ("_while", ["S", "A>S"]),
    ],
)
def test_what_a_true_precondition_does(attribute: str, row: list[str], tmp_path: Path) -> None:
    tree = with_x(
        tmp_path, f"""<Fallback><A {attribute}="x == 1"/><Inverter><B/></Inverter></Fallback>""", A="S", B="S"
    )
    set_x(1)
    assert tree.tick() == row


@pytest.mark.parametrize("attribute", ["_failureIf", "_successIf", "_skipIf"])
def test_what_a_false_precondition_does(attribute: str, tmp_path: Path) -> None:
    assert with_x(tmp_path, f"""<A {attribute}="x == 1"/>""", A="S").tick() == ["S", "A>S"]


def test_the_first_true_one_decides(tmp_path: Path) -> None:
    tree = with_x(
        tmp_path, """<A _skipIf="x == 1" _while="x == 2" _successIf="x == 1" _failureIf="x == 1"/>""", A="S"
    )
    set_x(1)
    assert tree.tick() == ["F"]


def test_only_while_is_asked_of_a_running_node(tmp_path: Path) -> None:
    for attribute in ("_failureIf", "_successIf", "_skipIf"):
        Blackboard.clear()
        tree = with_x(tmp_path, f"""<A {attribute}="x == 1"/>""", A="R")
        assert tree.tick() == ["R", "A>R"]
        set_x(1)
        assert tree.tick() == ["R", "A:R"]


def test_while_halts_a_running_node_and_skips_it(tmp_path: Path) -> None:
    expected = spaced("R A>R", "R A! B>R", "R A>R B!")
    tree = with_x(tmp_path, """<ReactiveFallback><A _while="x == 0"/><B/></ReactiveFallback>""", A="R", B="R")
    rows = []
    for value in (0, 1, 0):
        set_x(value)
        rows.append(tree.tick())
    assert rows == expected


def test_conditions_of_a_control_node_stand_for_its_children(tmp_path: Path) -> None:
    tree = with_x(tmp_path, """<Sequence _while="x == 0"><A/><B/></Sequence>""", A="S", B="R")
    assert tree.ticks(2) == spaced("R A>S B>R", "R B:R")
    set_x(1)
    assert tree.ticks(2) == spaced("- B!", "-")
    set_x(0)
    assert tree.tick() == ["R", "A>S", "B>R"]


def test_a_subtrees_conditions_are_asked_outside(trace: MakeTrace) -> None:
    inner = """<BehaviorTree ID="T"><Sequence><Script code="x := 1"/><A/></Sequence></BehaviorTree>"""
    tree = trace(
        """<Sequence><Script code="x := 0"/><SubTree ID="T" _skipIf="x == 1"/></Sequence>""", inner, A="S"
    )
    assert tree.ticks(2) == spaced("S A>S", "S A>S")


@pytest.mark.parametrize(("result", "log"), [("S", "'onSuccess post"), ("F", "'onFailure post"), ("R", "'")])
def test_postconditions_follow_a_result(result: str, log: str, tmp_path: Path) -> None:
    tree = with_x(
        tmp_path,
        """<A _post="log += ' post'" _onFailure="log += 'onFailure'" _onSuccess="log += 'onSuccess'"
              _onHalted="log += 'onHalted'"/>""",
        A=result,
    )
    Blackboard.set("/log", "'")
    tree.tick()
    assert Blackboard.get("/log") == log


def test_on_halted_follows_a_halt_and_nothing_else_does(tmp_path: Path) -> None:
    tree = with_x(tmp_path, """<A _onHalted="x += 1" _post="x += 10" _onFailure="x += 100"/>""", A="RS")
    tree.tick()
    tree.halt()
    assert Blackboard.get("/x") == 1
    tree.halt()
    assert Blackboard.get("/x") == 1, "it did not run any more"


def test_halts_are_noticed_from_the_leaves_up(tmp_path: Path) -> None:
    tree = with_x(
        tmp_path,
        """<Sequence _onHalted="log += 'S'">
            <Inverter _onHalted="log += 'I'"><A _onHalted="log += 'A'"/></Inverter>
        </Sequence>""",
        A="R",
    )
    Blackboard.set("/log", "")
    tree.tick()
    assert tree.halt() == ["A!"]
    assert Blackboard.get("/log") == "AIS"


def test_a_preconditions_result_has_postconditions_too(tmp_path: Path) -> None:
    tree = with_x(tmp_path, """<A _successIf="x == 0" _onSuccess="x := 5"/>""", A="F")
    assert tree.tick() == ["S"]
    assert Blackboard.get("/x") == 5


def test_what_is_seen_of_a_node_that_was_not_ticked(tmp_path: Path) -> None:
    tree = with_x(
        tmp_path, """<Sequence><A _skipIf="x == 1" _successIf="x == 2"/><B/></Sequence>""", A="S", B="S"
    )
    seen = []
    for value in (0, 1, 2, 0):
        set_x(value)
        assert names(list(tree.root.tick())) == ["A", "B", "Sequence"]
        leaf = tree.root.children[0]
        seen.append((leaf.status, leaf.feedback_message))
    assert seen == [
        (Status.SUCCESS, ""),
        (Status.INVALID, "skipped: _skipIf"),
        (Status.SUCCESS, "not ticked: _successIf"),
        (Status.SUCCESS, ""),
    ]


def test_a_leaf_that_is_the_whole_mission(tmp_path: Path) -> None:
    """py_trees ticks it then, and must not go past its conditions."""
    tree = with_x(tmp_path, """<A _skipIf="x == 1" _onHalted="x := 7"/>""", A="R")
    manager = py_trees.trees.BehaviourTree(tree.root)
    set_x(1)
    manager.tick()
    assert tree.root.status is Status.INVALID
    set_x(0)
    assert names(list(tree.root.tick())) == ["A"]
    tree.root.stop(Status.INVALID)
    assert tree.halt() == ["A>R", "A!"]
    assert Blackboard.get("/x") == 7


def test_a_script_that_fails_says_where(tmp_path: Path) -> None:
    tree = with_x(tmp_path, """<A name="go" _skipIf="y &gt; 1"/>""", A="S")
    with pytest.raises(
        MissionError, match=r'mission.xml:1:\d+: error: go: _skipIf is "y > 1"; y has no value yet'
    ):
        tree.tick()
    Blackboard.set("/y", "high")
    with pytest.raises(MissionError, match="text 'high' is no number"):
        tree.tick()
