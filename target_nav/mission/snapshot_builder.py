"""Notes of ticks into snapshots: plain data in the shape of py_trees_ros_interfaces/BehaviourTree, without ROS.

`py-trees-tree-watcher` stops with an exception on a type or status that it does not know, on a child that is not in
the list, on anything but one root, on ids that are not uuid4. A snapshot never has any of these. Building one costs
more than a tick of the tree, so the tick's thread only takes a note (`tree_note`), and a thread that may take its time
makes a snapshot of it.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from typing import Any
from uuid import UUID

from py_trees import composites, decorators
from py_trees.behaviour import Behaviour
from py_trees.blackboard import ActivityItem, Client
from py_trees.common import BlackBoxLevel, Status

from target_nav.mission.nodes import MissionNode
from target_nav.mission.snapshot_types import (
    NO_ID,
    ActivitySnapshot,
    BehaviourSnapshot,
    BehaviourType,
    Pair,
    StatusCode,
    TreeSnapshot,
)
from target_nav.mission.tree_note import TreeNote
from target_nav.mission.values_text import value_text

_STATUS = {status: StatusCode[status.name] for status in Status}
_BLACKBOX_LEVEL = {
    BlackBoxLevel.DETAIL: 1,
    BlackBoxLevel.COMPONENT: 2,
    BlackBoxLevel.BIG_PICTURE: 3,
    BlackBoxLevel.NOT_A_BLACKBOX: 4,
}


class SnapshotBuilder:
    """Makes snapshots of notes; what does not change while a tree lives is worked out once."""

    def __init__(self) -> None:
        self._nodes: object = None
        self._fixed: list[_Fixed] = []
        self._index: dict[UUID, int] = {}
        self.texts = ValueTexts()

    def build(self, note: TreeNote, *, changed: bool | None = None) -> TreeSnapshot:
        """`changed` overrides what the note says. Blackboard and activity are there if the note has them."""
        if note.nodes is not self._nodes:
            self._nodes = note.nodes
            self._fixed = [_fixed(node, node is note.root) for node in note.nodes]
            self._index = {node.id: i for i, node in enumerate(note.nodes)}
        visited = {node.id for node in note.visited}
        current = iter(note.current)
        tips: list[UUID] = []
        shown: list[BehaviourSnapshot] = []
        for fixed, status, message in zip(self._fixed, note.statuses, note.messages):
            child = next(current) if fixed.is_composite else None
            tip = self._tip(fixed, status, child, note, tips)
            tips.append(tip)
            shown.append(
                BehaviourSnapshot(
                    name=fixed.name,
                    class_name=fixed.class_name,
                    own_id=fixed.own_id,
                    parent_id=fixed.parent_id,
                    tip_id=NO_ID if tip == fixed.own_id else tip,
                    child_ids=fixed.child_ids,
                    current_child_id=NO_ID if child is None else child.id,
                    type=fixed.type,
                    additional_detail=fixed.detail,
                    blackbox_level=fixed.blackbox_level,
                    status=_STATUS[status],
                    message=message,
                    is_active=fixed.own_id in visited,
                    blackboard_access=fixed.access,
                )
            )
        return TreeSnapshot(
            behaviours=tuple(shown),
            changed=note.changed if changed is None else changed,
            blackboard_on_visited_path=() if note.board is None else self.values(note),
            blackboard_activity=tuple(self._activity(item) for item in note.activity),
        )

    def visited_keys(self, note: TreeNote) -> list[str]:
        """The entries that the visited behaviours may read or write, by name."""
        if note.nodes is not self._nodes:
            self.build(note)
        # a behaviour that was added since is not in the index: the next note has it
        visited = [self._index[node.id] for node in note.visited if node.id in self._index]
        return sorted({path for i in visited for path, _ in self._fixed[i].access})

    def values(self, note: TreeNote) -> tuple[Pair, ...]:
        board = note.board or {}
        return tuple((path, self.texts.of(path, board)) for path in self.visited_keys(note))

    def _tip(
        self, fixed: _Fixed, status: Status, child: Behaviour | None, note: TreeNote, tips: list[UUID]
    ) -> UUID:
        """As `Behaviour.tip` says it, worked out from the note; NO_ID if there is none."""
        own = NO_ID if status is Status.INVALID else fixed.own_id
        if fixed.is_composite and child is not None:
            tip = tips[self._index[child.id]]
            # a mission's own nodes answer for a child that was skipped or halted, py_trees' do not
            return own if tip == NO_ID and fixed.is_mission_node else tip
        if fixed.is_decorator and fixed.child_ids:
            only = self._index[fixed.child_ids[0]]
            if note.statuses[only] is not Status.INVALID:
                return tips[only]
        return own

    def _activity(self, item: ActivityItem) -> ActivitySnapshot:
        return ActivitySnapshot(
            item.key,
            item.client_name,
            item.activity_type,
            value_text(item.previous_value),
            value_text(item.current_value),
        )


class ValueTexts:
    """Texts of blackboard values; one that is still the same object is not written out again."""

    def __init__(self) -> None:
        self._known: dict[str, tuple[Any, str]] = {}

    def of(self, path: str, board: Mapping[str, Any]) -> str:
        if path not in board:
            return "-"
        value = board[path]
        known = self._known.get(path)
        if known is not None and known[0] is value and not isinstance(value, (list, dict, set)):
            return known[1]
        text = value_text(value)
        self._known[path] = (value, text)
        return text


def type_of(behaviour: Behaviour) -> BehaviourType:
    if isinstance(behaviour, composites.Sequence):
        return BehaviourType.SEQUENCE
    if isinstance(behaviour, composites.Parallel):
        return BehaviourType.PARALLEL
    if isinstance(behaviour, composites.Composite):
        # any other composite chooses between its children in some way
        return BehaviourType.SELECTOR
    if isinstance(behaviour, decorators.Decorator):
        return BehaviourType.DECORATOR
    return BehaviourType.BEHAVIOUR


@dataclass(frozen=True)
class _Fixed:
    """What of a behaviour stays as it is while its tree lives."""

    name: str
    class_name: str
    own_id: UUID
    parent_id: UUID
    child_ids: tuple[UUID, ...]
    type: BehaviourType
    detail: str
    blackbox_level: int
    access: tuple[Pair, ...]
    is_composite: bool
    is_decorator: bool
    is_mission_node: bool


def _fixed(node: Behaviour, is_root: bool) -> _Fixed:
    return _Fixed(
        name=node.name,
        class_name=f"{type(node).__module__}.{type(node).__name__}",
        own_id=node.id,
        parent_id=NO_ID if is_root or node.parent is None else node.parent.id,
        child_ids=tuple(child.id for child in node.children),
        type=type_of(node),
        detail=_detail(node),
        blackbox_level=_BLACKBOX_LEVEL[node.blackbox_level],
        access=_access(node),
        is_composite=isinstance(node, composites.Composite),
        is_decorator=isinstance(node, decorators.Decorator),
        is_mission_node=isinstance(node, MissionNode),
    )


def _detail(node: Behaviour) -> str:
    if isinstance(node, (composites.Sequence, composites.Selector)):
        return "WithMemory" if node.memory else ""
    if isinstance(node, composites.Parallel):
        return type(node.policy).__name__.replace("Success", "")
    return ""


def _keys(client: Client) -> Iterable[Pair]:
    """The entries a client may use, by their real paths and not by the client's own names for them."""
    remappings: dict[str, str] = client.remappings
    for names, mark in ((client.read, "r"), (client.write, "w"), (client.exclusive, "x")):
        for name in names:
            yield remappings.get(name, name), mark


def _access(node: Behaviour) -> tuple[Pair, ...]:
    return tuple(sorted({pair for client in node.blackboards for pair in _keys(client)}))
