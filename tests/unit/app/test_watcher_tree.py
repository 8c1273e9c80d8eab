"""Behaviours from the wire as a tree that py_trees can draw."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any
from uuid import UUID

import py_trees
import pytest
from py_trees.common import Status

from target_nav.app.watcher_tree import BrokenTreeError, tree_of
from tests.utils.snapshots import snapshot_of


def on_the_wire(root: py_trees.behaviour.Behaviour) -> list[Any]:
    """What `snapshot_messages` makes of a tree, without ROS."""

    def uuid(value: UUID) -> Any:
        return SimpleNamespace(uuid=list(value.bytes))

    return [
        SimpleNamespace(
            name=b.name,
            own_id=uuid(b.own_id),
            parent_id=uuid(b.parent_id),
            child_ids=[uuid(child) for child in b.child_ids],
            type=int(b.type),
            status=int(b.status),
            message=b.message,
            additional_detail=b.additional_detail,
            is_active=b.is_active,
        )
        for b in snapshot_of(root).behaviours
    ]


@pytest.fixture
def root() -> py_trees.behaviour.Behaviour:
    leaf = py_trees.behaviours
    steps = py_trees.composites.Sequence("steps", True, [leaf.Failure("no"), leaf.Success("never")])
    negated = py_trees.decorators.Inverter("not", leaf.Success("yes"))
    policy = py_trees.common.ParallelPolicy.SuccessOnOne()
    both = py_trees.composites.Parallel("both", policy, [leaf.Running("run")])
    made = py_trees.composites.Selector("choose", memory=False, children=[steps, negated, both])
    made.tick_once()
    return made


def test_it_is_drawn_as_the_tree_itself_is(root: py_trees.behaviour.Behaviour) -> None:
    shown = tree_of(on_the_wire(root))
    visited = {node.id: node.status for node in root.iterate() if node.status is not Status.INVALID}
    assert shown.visited == visited
    drawn = py_trees.display.ascii_tree(shown.root, visited=shown.visited)
    itself = py_trees.display.ascii_tree(root, visited=visited)
    # a decorator's kind is not on the wire, so all are drawn alike
    assert drawn == itself
    assert [node.name for node in shown.root.iterate()] == [node.name for node in root.iterate()]


def test_messages_without_a_root_or_a_child_make_no_tree(root: py_trees.behaviour.Behaviour) -> None:
    messages = on_the_wire(root)
    with pytest.raises(BrokenTreeError, match="0 of 7 behaviours have no parent"):
        tree_of(messages[:-1])
    with pytest.raises(BrokenTreeError, match="a child of 'steps' is not in the list"):
        tree_of(messages[1:])
