"""What a watcher sees of a tree: plain data in the shape of py_trees_ros_interfaces/BehaviourTree, without ROS.

`py-trees-tree-watcher` stops with an exception on a type or status that it does not know, on a child that is not in
the list, on anything but one root, on ids that are not uuid4. A snapshot never has any of these. Building one costs
more than a tick of the tree, so the tick's thread only takes a note (`tree_note`), and a thread that may take its time
makes a snapshot of it.
"""

from __future__ import annotations

from collections.abc import Collection

from py_trees.behaviour import Behaviour
from py_trees.blackboard import Blackboard

from target_nav.mission.snapshot_builder import SnapshotBuilder, ValueTexts, type_of
from target_nav.mission.snapshot_types import (
    NO_ID,
    ActivitySnapshot,
    BehaviourSnapshot,
    BehaviourType,
    StatusCode,
    TreeSnapshot,
)
from target_nav.mission.tree_note import TreeNotebook, visited_by
from target_nav.mission.values_text import MAX_TEXT

__all__ = [
    "MAX_TEXT",
    "NO_ID",
    "ActivitySnapshot",
    "BehaviourSnapshot",
    "BehaviourType",
    "SnapshotBuilder",
    "SnapshotTracker",
    "StatusCode",
    "TreeSnapshot",
    "ValueTexts",
    "snapshot_of",
    "type_of",
    "visited_by",
]


def snapshot_of(
    root: Behaviour,
    visited: Collection[Behaviour] | None = None,
    *,
    changed: bool = False,
    blackboard_data: bool = False,
    blackboard_activity: bool = False,
) -> TreeSnapshot:
    """The tree as it stands, at once.

    Args:
        root: of the tree, or of a part of it, which is then shown as a tree of its own
        visited: what the last tick passed through; found out when None, see `visited_by`
        changed: whether it is told as changed
        blackboard_data: with the values of the keys that the visited behaviours read or write
        blackboard_activity: with py_trees' activity stream, if somebody enabled it; clearing it is the caller's part
    """
    stream = Blackboard.activity_stream if blackboard_activity else None
    note = TreeNotebook().note(
        root, visited, board=blackboard_data, activity=tuple(stream.data) if stream is not None else ()
    )
    return SnapshotBuilder().build(note, changed=changed)


class SnapshotTracker:
    """Tells after each tick whether a watcher would see a change, without building a snapshot."""

    def __init__(self) -> None:
        self._notebook = TreeNotebook()

    def observe(self, root: Behaviour, visited: Collection[Behaviour] | None = None) -> bool:
        """Whether a status or the visited path differs from the last call. True for a new tree.

        `visited` is what the last tick passed through; found out when None, see `visited_by`.
        """
        return self._notebook.note(root, visited).changed

    def forget(self) -> None:
        """Takes the next tree for a new one: after behaviours were added to the tree or removed from it."""
        self._notebook.forget()
