"""A mission's nodes are py_trees behaviours: managers, visitors and foreign behaviours work with them."""

from __future__ import annotations

import py_trees
import pytest
from py_trees.blackboard import Blackboard
from py_trees.common import Status

from target_nav.errors import MissionError
from target_nav.mission.nodes import (
    BUILT_INS,
    AlwaysFailure,
    AlwaysSuccess,
    Fallback,
    Inverter,
    MissionNode,
    Sequence,
    halt_tree,
)
from tests.unit.mission.conftest import MakeTrace
from tests.unit.mission.scripted import names


class Forgetful(py_trees.behaviour.Behaviour):
    """Forgets to return its status."""

    def update(self) -> Status:
        return None


def test_every_built_in_says_what_it_does_and_what_its_ports_are_for() -> None:
    for node in BUILT_INS:
        assert (node.__doc__ or "").strip()
        assert all(port.description for port in node.INPUT_PORTS.values())
        assert set(node.PORT_LIMITS) <= set(node.INPUT_PORTS)


def test_ticking_yields_what_was_visited_children_first(trace: MakeTrace) -> None:
    root = trace("<Fallback><Inverter><A/></Inverter><B/><C/></Fallback>", A="S", B="S", C="S").root
    assert names(list(root.tick())) == ["A", "Inverter", "B", "Fallback"]


def test_py_trees_own_manager_and_snapshot_visitor_see_the_ticks(trace: MakeTrace) -> None:
    root = trace("<Sequence><A/><B/><C/></Sequence>", A="S", B="RS", C="S").root
    manager, visitor = py_trees.trees.BehaviourTree(root), py_trees.visitors.SnapshotVisitor()
    manager.add_visitor(visitor)
    manager.setup()

    manager.tick()
    seen = {node.name: visitor.visited.get(node.id) for node in root.iterate()}
    assert seen == {"A": Status.SUCCESS, "B": Status.RUNNING, "C": None, "Sequence": Status.RUNNING}
    manager.tick()
    assert visitor.changed

    root.stop(Status.INVALID)
    assert root.status is Status.INVALID


def test_a_mission_can_be_a_part_of_a_py_trees_tree(trace: MakeTrace) -> None:
    tree = trace("<Sequence><A/><B/></Sequence>", A="S", B="R")
    guard = py_trees.behaviours.StatusQueue("guard", [Status.FAILURE, Status.SUCCESS], None)
    selector = py_trees.composites.Selector("foreign", memory=False, children=[guard, tree.root])

    selector.tick_once()
    tip = selector.tip()
    assert tip is not None
    assert tip.name == "B"
    assert tree.root.status is Status.RUNNING
    selector.tick_once()
    assert tree.root.status is Status.INVALID
    assert tree.halt() == ["A>S", "B>R", "B!"]


def test_a_py_trees_tree_can_be_a_part_of_a_mission() -> None:
    inner = py_trees.composites.Selector(
        "foreign",
        memory=False,
        children=[py_trees.behaviours.Failure("no"), py_trees.behaviours.Running("yes")],
    )
    root = Sequence("root", [AlwaysSuccess("first"), inner])
    assert names(list(root.tick())) == ["first", "no", "yes", "foreign", "root"]
    assert root.status is Status.RUNNING
    root.stop(Status.INVALID)
    assert {node.status for node in root.iterate()} == {Status.INVALID}


def test_a_leaf_that_returns_no_status_is_an_error_and_not_skipped() -> None:
    root = Sequence("root", [Forgetful("leaf"), AlwaysSuccess("after")])
    with pytest.raises(MissionError, match=r"leaf 'leaf' \(Forgetful\) returned None"):
        root.tick_once()


def test_finished_children_keep_their_status_until_the_parent_begins_anew(trace: MakeTrace) -> None:
    tree = trace("<Sequence><A/><B/></Sequence>", A="SF", B="S")
    tree.tick()
    assert [node.status for node in tree.root.children] == [Status.SUCCESS, Status.SUCCESS]
    tree.tick()
    assert [node.status for node in tree.root.children] == [Status.FAILURE, Status.INVALID]


def test_the_tip_is_the_leaf_that_decided(trace: MakeTrace) -> None:
    tree = trace("<Fallback><A/><Sequence><B/><C/></Sequence></Fallback>", A="F", B="S", C="RF")
    assert tree.root.tip() is None
    for expected in ("C", "C"):
        tree.tick()
        assert tree.root.tip().name == expected
    assert tree.root.status is Status.FAILURE


def test_the_tip_of_a_node_whose_child_was_halted_is_the_node(trace: MakeTrace) -> None:
    tree = trace('<Sequence><Timeout msec="100"><A/></Timeout></Sequence>', A="R")
    tree.ticks_at([0.0, 0.2])
    assert tree.root.tip().name == "Timeout"


def test_nodes_can_be_made_without_a_file() -> None:
    root = Fallback("either", [Inverter("not", AlwaysSuccess("yes")), AlwaysFailure("no")])
    root.tick_once()
    assert root.status is Status.FAILURE


def test_halting_a_whole_tree_reaches_a_skipped_node_at_any_depth_once(trace: MakeTrace) -> None:
    inner = """<Sequence name="deep" _onHalted="n += 1"><A _skipIf="true"/></Sequence>"""
    # a Precondition that was skipped is not active
    inner = f"""<Precondition if="true"><Precondition if="true">{inner}</Precondition></Precondition>"""
    tree = trace(f"""<Sequence><Script code="n := 0"/>{inner}<B/></Sequence>""", A="S", B="R")
    tree.tick()
    (deep,) = [node for node in tree.root.iterate() if node.name == "deep"]
    assert isinstance(deep, MissionNode)
    assert deep.active
    for _ in range(2):
        halt_tree(tree.root)
        assert not deep.active
        assert Blackboard.get("/n") == 1


def test_stopping_a_tree_that_does_not_run_tells_nobody(trace: MakeTrace) -> None:
    tree = trace("""<Sequence _onHalted="n += 1"><Script code="n := 0"/><A/></Sequence>""", A="S")
    tree.tick()
    tree.root.stop(Status.INVALID)
    assert Blackboard.get("/n") == 0
