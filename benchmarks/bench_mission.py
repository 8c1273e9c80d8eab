"""A mission's tick and its loading, beside py_trees' own and BehaviorTree.CPP's with Python leaves.

The same trees for all: sequences of four leaves that succeed at once, so that every node is visited in every tick. The
peer `behaviortreepy` is left out where it is not installed.
"""

from __future__ import annotations

import importlib
import statistics
import tempfile
import threading
import time
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import py_trees
from py_trees.behaviour import Behaviour
from py_trees.blackboard import Blackboard
from py_trees.common import Status
from py_trees.ports import PortsMixin

from benchmarks import OURS, Row, time_call
from target_nav.app.ros_support import RosNode, latched_qos
from target_nav.app.tree_streams import TreeStreams
from target_nav.errors import DeviceError
from target_nav.mission import NodeRegistry, load_mission
from target_nav.mission.snapshot_builder import SnapshotBuilder
from target_nav.mission.tree_note import TreeNotebook

BTCPP = "BehaviorTree.CPP"
SIZES = (10, 50, 500)
LOADED = 200
MOST_WATCHERS = 3
PACED_TICKS = 200


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
    notebook = TreeNotebook()

    def tick_and_look() -> None:
        root.tick_once()
        notebook.note(root)

    peer = as_py_trees(root)
    manager = py_trees.trees.BehaviourTree(as_py_trees(root))
    manager.add_visitor(py_trees.visitors.SnapshotVisitor())
    rows = [
        Row(task, OURS, us(tick_and_look), "us", "with change detection, what a watcher costs the tick"),
        Row(task, f"{OURS}, tick alone", us(root.tick_once), "us"),
        Row(task, "py_trees", us(peer.tick_once), "us"),
        Row(task, "py_trees, SnapshotVisitor", us(manager.tick), "us", "its change detection"),
    ]
    tree = btcpp_tree(mission(size))
    if tree is not None:
        rows.append(Row(task, BTCPP, us(tree.tick_exactly_once), "us", "behaviortreepy, Python leaves"))
    note, builder = notebook.note(root), SnapshotBuilder()
    snapshot = f"snapshot, {size} nodes"
    return [
        *rows,
        Row(snapshot, OURS, us(lambda: builder.build(note)), "us", "not in the tick"),
        *watched(size, root),
    ]


def watched(size: int, root: Behaviour) -> list[Row]:
    """Tick and `TreeStreams.after_tick`, a hundred times a second, with real publishers and so many subscribers, each
    to a stream of its own that is due in every tick, with blackboard, activity and statistics.
    """
    try:
        ros = RosNode("bench_mission", needs=("py_trees_ros_interfaces.srv",))
    except DeviceError:
        return []
    from py_trees_ros_interfaces.msg import BehaviourTree, SnapshotStreamParameters
    from py_trees_ros_interfaces.srv import OpenSnapshotStream

    parameters = SnapshotStreamParameters(snapshot_period=0.0, blackboard_data=True, blackboard_activity=True)
    request = OpenSnapshotStream.Request(parameters=parameters)
    rows = []
    manager = py_trees.trees.BehaviourTree(as_py_trees(root))
    manager.add_visitor(py_trees.visitors.SnapshotVisitor())
    peer = Row("", "py_trees, SnapshotVisitor", paced(manager.tick), "us", "no watcher, no message")
    with ros:
        streams = TreeStreams(ros, root)
        ros.start()

        def tick_and_note() -> None:
            root.tick_once()
            streams.after_tick(time.perf_counter(), time.perf_counter())

        opening = ros.node.create_client(OpenSnapshotStream, "~/snapshot_streams/open")
        opening.wait_for_service(5.0)
        for watchers in range(MOST_WATCHERS + 1):
            if watchers:
                done = threading.Event()
                future = opening.call_async(request)
                future.add_done_callback(lambda _, done=done: done.set())
                done.wait(5.0)
                ros.node.create_subscription(
                    BehaviourTree, future.result().topic_name, lambda message: None, latched_qos()
                )
                time.sleep(0.5)
            task = f"tick and streams, {size} nodes, watchers: {watchers}"
            rows += [Row(task, OURS, paced(tick_and_note), "us", "median"), replace(peer, task=task)]
        streams.close()
    return rows


def paced(function: Callable[[], object]) -> float:
    """Median in microseconds, caches cold: between two calls the other threads have their time, as on the robot."""
    times_us = []
    for _ in range(PACED_TICKS):
        time.sleep(0.01)
        begin_s = time.perf_counter()
        function()
        times_us.append(1e6 * (time.perf_counter() - begin_s))
    return statistics.median(times_us)


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
