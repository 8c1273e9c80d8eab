"""What one tick left behind, noted in microseconds: lists of references, nothing built, nothing formatted.

The tick's thread takes notes, and only when somebody watches. Another thread makes snapshots, messages and texts of
them (`snapshot`): that costs more than the tick itself.
"""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from py_trees import composites
from py_trees.behaviour import Behaviour
from py_trees.blackboard import ActivityItem, Blackboard
from py_trees.common import Status

from target_nav.mission.nodes import MissionNode


@dataclass(frozen=True, eq=False)
class TreeNote:
    """A tree after a tick. `statuses` and `messages` go with `nodes`, `current` with those of them that are composites.

    `nodes` is the same object as long as the tree is the same. `board` is None if it was not asked for.
    """

    nodes: Sequence[Behaviour]
    statuses: Sequence[Status]
    messages: Sequence[str]
    current: Sequence[Behaviour | None]
    visited: Collection[Behaviour]
    changed: bool
    board: Mapping[str, Any] | None = None
    activity: Sequence[ActivityItem] = ()

    @property
    def root(self) -> Behaviour:
        return self.nodes[-1]


class TreeNotebook:
    """Takes notes of one tree at a time, and knows what has changed since the last one."""

    def __init__(self) -> None:
        self._root: Behaviour | None = None
        self._nodes: tuple[Behaviour, ...] = ()
        self._composites: tuple[composites.Composite, ...] = ()
        self._seen: tuple[object, ...] = ()

    def note(
        self,
        root: Behaviour,
        visited: Collection[Behaviour] | None = None,
        *,
        board: bool = False,
        activity: Sequence[ActivityItem] = (),
    ) -> TreeNote:
        """The tree as it stands. `changed` if a status or the visited path differs from the last note, as py_trees has
        it: a message may change in every tick.

        Args:
            root: of the tree; another than last time is a change
            visited: what the last tick passed through; found out when None, see `visited_by`
            board: with the values on the blackboard
            activity: of the blackboard in the last tick
        """
        if root is not self._root:
            self.forget()
            self._root = root
            self._nodes = tuple(root.iterate())
            self._composites = tuple(node for node in self._nodes if isinstance(node, composites.Composite))
        if visited is None:
            visited = visited_by(root)
        statuses = [node.status for node in self._nodes]
        messages = [node.feedback_message for node in self._nodes]
        seen = (statuses, list(visited))
        changed = seen != self._seen
        self._seen = seen
        return TreeNote(
            nodes=self._nodes,
            statuses=statuses,
            messages=messages,
            current=[node.current_child for node in self._composites],
            visited=visited,
            changed=changed,
            board=dict(Blackboard.storage) if board else None,
            activity=activity,
        )

    def forget(self) -> None:
        """Takes the next tree for a new one: after behaviours were added to the tree or removed from it."""
        self._root, self._nodes, self._composites, self._seen = None, (), (), ()


def visited_by(root: Behaviour) -> Collection[Behaviour]:
    """What the last tick of a mission passed through. Of any other tree: the behaviours that have a status."""
    if isinstance(root, MissionNode):
        return root.last_visited
    return [node for node in root.iterate() if node.status is not Status.INVALID]
