"""The tree in shared memory: depth first, with what each behaviour said, and no more often than screens look."""

from __future__ import annotations

import os
from collections.abc import Iterator

import py_trees
import pytest
from py_trees.common import Status

from target_nav.app.tree_channel import PERIOD_S, TreeChannel, depth_first
from target_nav.ipc import channels
from target_nav.mission.tree_note import TreeNotebook
from target_nav.state.snapshots import NodeStatus, TreeState
from tests.utils.processes import wait_until

pytestmark = pytest.mark.linux


def tree(wide: int = 1) -> py_trees.behaviour.Behaviour:
    root = py_trees.composites.Sequence("root", memory=False)
    inner = py_trees.composites.Selector("inner", memory=False)
    inner.add_children([py_trees.behaviours.Failure("no"), py_trees.behaviours.Running("on it")])
    root.add_children([py_trees.behaviours.Success("yes"), inner])
    root.add_children([py_trees.behaviours.Success(f"later {i}") for i in range(wide)])
    return root


class Clock:
    now_s = 50.0

    def __call__(self) -> float:
        return self.now_s


@pytest.fixture
def prefix() -> Iterator[str]:
    name = f"t{os.getpid()}-tree"
    yield name
    channels.remove(name)


def published(prefix: str, root: py_trees.behaviour.Behaviour) -> TreeState:
    channel = TreeChannel(prefix, Clock())
    try:
        root.tick_once()
        assert channel.wants_note()
        channel.take(TreeNotebook().note(root))
        with channels.open_reader(channels.TREE, prefix) as reader:
            wait_until(lambda: reader.latest() is not None, "the tree is written")
            state = reader.latest()
        assert state is not None
        return state
    finally:
        channel.close()


def test_rows_stand_in_the_order_in_which_a_person_reads_a_tree(prefix: str) -> None:
    root = tree()
    root.children[0].feedback_message = "because"
    state = published(prefix, root)
    assert [(row.name, row.depth, row.status) for row in state.rows] == [
        ("root", 0, NodeStatus.RUNNING),
        ("yes", 1, NodeStatus.SUCCESS),
        ("inner", 1, NodeStatus.RUNNING),
        ("no", 2, NodeStatus.FAILURE),
        ("on it", 2, NodeStatus.RUNNING),
        ("later 0", 1, NodeStatus.INVALID),
    ]
    assert [row.active for row in state.rows] == [True] * 5 + [False]
    assert state.rows[2].word == "Selector"
    assert state.stamp_s == 50.0
    assert state.total == 6


def test_of_a_tree_that_is_too_large_the_first_rows_are_there_and_the_rest_is_counted(prefix: str) -> None:
    state = published(prefix, tree(wide=channels.MAX_TREE_ROWS))
    assert len(state.rows) == channels.MAX_TREE_ROWS
    assert state.total == channels.MAX_TREE_ROWS + 5


def test_notes_are_wanted_ten_times_a_second(prefix: str) -> None:
    clock = Clock()
    channel = TreeChannel(prefix, clock)
    wanted = 0
    for _ in range(40):
        wanted += channel.wants_note()
        clock.now_s += 0.05
    channel.close()
    assert wanted == 20
    assert PERIOD_S < 0.1


def test_every_status_has_its_number() -> None:
    assert {status.name for status in Status} == {status.name for status in NodeStatus}


def test_a_parent_comes_before_its_children() -> None:
    root = tree(3)
    depths = [depth for _, _, _, depth in depth_first(TreeNotebook().note(root))]
    assert depths == [0, 1, 1, 2, 2, 1, 1, 1]
