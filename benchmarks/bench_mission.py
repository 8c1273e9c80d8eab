"""A mission's tick and its loading, beside py_trees' own and BehaviorTree.CPP's with Python leaves.

The same trees for all: sequences of four leaves that succeed at once, so that every node is visited in every tick. The
peer `behaviortreepy` is left out where it is not installed.
"""

from __future__ import annotations

import importlib
import tempfile
from collections.abc import Callable
from pathlib import Path
from typing import Any

import py_trees
from py_trees.behaviour import Behaviour
from py_trees.blackboard import Blackboard
from py_trees.common import Status
from py_trees.ports import PortsMixin

from benchmarks import OURS, Row, time_call
from target_nav.mission import NodeRegistry, load_mission
from target_nav.mission.snapshot import SnapshotTracker, snapshot_of

BTCPP = "BehaviorTree.CPP"
SIZES = (10, 50, 500)
LOADED = 200


class Leaf(PortsMixin, Behaviour, register=False):
    """Succeeds at once."""

    INPUT_PORTS = {}
    OUTPUT_PORTS = {}

    def update(self) -> Status:
        return Status.SUCCESS


def run() -> list[Row]:
    rows = []
    try:
        for size in SIZES:
            rows += tick(size)
        return [*rows, *scripts(), *loading()]
    finally:
        Blackboard.clear()


def mission(size: int, leaf: str = "<Leaf/>") -> str:
    """A mission of exactly so many nodes."""
    groups, rest = divmod(size - 1, 5)
    inside = f"<Sequence>{leaf * 4}</Sequence>" * groups + leaf * rest
    return document(f"<Sequence>{inside}</Sequence>")


def document(tree: str) -> str:
    return f'<root BTCPP_format="4"><BehaviorTree ID="Main">{tree}</BehaviorTree></root>'


def load(text: str) -> Behaviour:
    Blackboard.clear()
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "mission.xml"
        path.write_text(text, encoding="utf-8")
        return load_mission(path, NodeRegistry((Leaf,))).root


def as_py_trees(node: Behaviour) -> Behaviour:
    """The same tree of py_trees' own sequences."""
    if not node.children:
        return Leaf(node.name)
    return py_trees.composites.Sequence(
        node.name, memory=True, children=[as_py_trees(each) for each in node.children]
    )


def btcpp_tree(text: str) -> Any:
    """BehaviorTree.CPP's; None without `behaviortreepy`."""
    try:
        bt = importlib.import_module("behaviortreepy")
    except ImportError:
        return None
    factory = bt.BehaviorTreeFactory()
    success = bt.NodeStatus.SUCCESS
    factory.register_simple_action("Leaf", lambda node: success)
    return factory.create_tree_from_text(text)


def us(function: Callable[[], object]) -> float:
    return 1e6 * time_call(function)


def tick(size: int) -> list[Row]:
    task = f"tick, {size} nodes"
    root = load(mission(size))
    count = sum(1 for _ in root.iterate())
    assert count == size, f"{count} nodes"
    tracker = SnapshotTracker()

    def tick_and_look() -> None:
        root.tick_once()
        tracker.observe(root)

    peer = as_py_trees(root)
    manager = py_trees.trees.BehaviourTree(as_py_trees(root))
    manager.add_visitor(py_trees.visitors.SnapshotVisitor())
    rows = [
        Row(task, OURS, us(tick_and_look), "us", "with change detection"),
        Row(task, f"{OURS}, tick alone", us(root.tick_once), "us"),
        Row(task, "py_trees", us(peer.tick_once), "us"),
        Row(task, "py_trees, SnapshotVisitor", us(manager.tick), "us", "its change detection"),
    ]
    tree = btcpp_tree(mission(size))
    if tree is not None:
        rows.append(Row(task, BTCPP, us(tree.tick_exactly_once), "us", "behaviortreepy, Python leaves"))
    root.tick_once()
    rows.append(Row(f"snapshot, {size} nodes", OURS, us(lambda: snapshot_of(root)), "us", "not in the tick"))
    return rows


def scripts() -> list[Row]:
    task = "condition 'x > 3 && y == 2', 10 times"
    script = '<ScriptCondition code="x &gt; 3 &amp;&amp; y == 2"/>' * 10
    text = document(f'<Sequence><RunOnce><Script code="x := 5; y := 2"/></RunOnce>{script}</Sequence>')
    rows = [Row(task, OURS, us(load(text).tick_once), "us")]
    tree = btcpp_tree(text)
    return rows if tree is None else [*rows, Row(task, BTCPP, us(tree.tick_exactly_once), "us")]


def loading() -> list[Row]:
    task = f"load, {LOADED} nodes"
    leaf = """<Leaf name="one of many" _skipIf="false"/>"""
    text = mission(LOADED, leaf)
    rows = [
        Row(task, OURS, 1e-3 * us(lambda: load(text)), "ms", "read, checked, built; a script in each leaf")
    ]
    if btcpp_tree(text) is not None:
        rows.append(Row(task, BTCPP, 1e-3 * us(lambda: btcpp_tree(text)), "ms"))
    return rows
