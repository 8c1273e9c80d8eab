"""A snapshot of a tree at once, without the streams in between."""

from __future__ import annotations

from collections.abc import Collection

from py_trees.behaviour import Behaviour
from py_trees.blackboard import Blackboard

from target_nav.mission.snapshot_builder import SnapshotBuilder
from target_nav.mission.snapshot_types import TreeSnapshot
from target_nav.mission.tree_note import TreeNotebook


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
