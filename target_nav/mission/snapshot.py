"""What a watcher sees of a tree: plain data in the shape of py_trees_ros_interfaces/BehaviourTree, without ROS.

`py-trees-tree-watcher` stops with an exception on a type or status that it does not know, on a child that is not in
the list, on anything but one root, on ids that are not uuid4. A snapshot never has any of these. Building one costs
more than a tick of the tree, so it is for when somebody watches; `SnapshotTracker` is for every tick.
"""

from __future__ import annotations

from collections.abc import Collection, Iterable
from dataclasses import dataclass
from enum import IntEnum
from typing import Any
from uuid import UUID

from py_trees import composites, decorators
from py_trees.behaviour import Behaviour
from py_trees.blackboard import Blackboard, Client
from py_trees.common import BlackBoxLevel, Status

from target_nav.mission.nodes import MissionNode

NO_ID = UUID(int=0)
"""Stands for: no parent, no tip, no current child."""

MAX_TEXT = 500
"""Longest text of a blackboard value: an array of obstacles is not for reading."""

Pair = tuple[str, str]


class BehaviourType(IntEnum):
    """Numbers of py_trees_ros_interfaces/Behaviour. 0 (unknown) and 5 (chooser) exist there, and break the watcher."""

    BEHAVIOUR = 1
    SEQUENCE = 2
    SELECTOR = 3
    PARALLEL = 4
    DECORATOR = 6


class StatusCode(IntEnum):
    """Numbers of py_trees_ros_interfaces/Behaviour."""

    INVALID = 1
    RUNNING = 2
    SUCCESS = 3
    FAILURE = 4


_STATUS = {status: StatusCode[status.name] for status in Status}
_BLACKBOX_LEVEL = {
    BlackBoxLevel.DETAIL: 1,
    BlackBoxLevel.COMPONENT: 2,
    BlackBoxLevel.BIG_PICTURE: 3,
    BlackBoxLevel.NOT_A_BLACKBOX: 4,
}


@dataclass(frozen=True)
class BehaviourSnapshot:
    """One behaviour; fields as in the message. `blackboard_access` is (key, `r`, `w` or `x`)."""

    name: str
    class_name: str
    own_id: UUID
    parent_id: UUID
    tip_id: UUID
    child_ids: tuple[UUID, ...]
    current_child_id: UUID
    type: BehaviourType
    additional_detail: str
    blackbox_level: int
    status: StatusCode
    message: str
    is_active: bool
    blackboard_access: tuple[Pair, ...]


@dataclass(frozen=True)
class ActivitySnapshot:
    """One entry of py_trees' blackboard activity stream."""

    key: str
    client_name: str
    activity_type: str
    previous_value: str
    current_value: str


@dataclass(frozen=True)
class TreeSnapshot:
    """A whole tree, children before parents, the root last, as py_trees iterates. Statistics are the sender's."""

    behaviours: tuple[BehaviourSnapshot, ...]
    changed: bool = False
    blackboard_on_visited_path: tuple[Pair, ...] = ()
    blackboard_activity: tuple[ActivitySnapshot, ...] = ()


def snapshot_of(
    root: Behaviour,
    visited: Collection[Behaviour] | None = None,
    *,
    changed: bool = False,
    blackboard_data: bool = False,
    blackboard_activity: bool = False,
) -> TreeSnapshot:
    """The tree as it stands.

    Args:
        root: of the tree, or of a part of it, which is then shown as a tree of its own
        visited: what the last tick passed through; found out when None, see `visited_by`
        changed: what `SnapshotTracker.observe` said
        blackboard_data: with the values of the keys that the visited behaviours read or write
        blackboard_activity: with py_trees' activity stream, if somebody enabled it; clearing it is the caller's part
    """
    active = {behaviour.id for behaviour in (visited_by(root) if visited is None else visited)}
    nodes = list(root.iterate())
    return TreeSnapshot(
        behaviours=tuple(_behaviour(node, node is root, node.id in active) for node in nodes),
        changed=changed,
        blackboard_on_visited_path=_values(node for node in nodes if node.id in active)
        if blackboard_data
        else (),
        blackboard_activity=_activity() if blackboard_activity else (),
    )


class SnapshotTracker:
    """Tells after each tick whether a watcher would see a change, without building a snapshot."""

    def __init__(self) -> None:
        self._root: Behaviour | None = None
        self._nodes: list[Behaviour] = []
        self._seen: list[object] = []

    def observe(self, root: Behaviour, visited: Collection[Behaviour] | None = None) -> bool:
        """Whether a status, a message or the visited path differs from the last call. True for a new tree.

        `visited` is what the last tick passed through; found out when None, see `visited_by`.
        """
        if root is not self._root:
            self.forget()
            self._root, self._nodes = root, list(root.iterate())
        seen: list[object] = [node.status for node in self._nodes]
        seen += [node.feedback_message for node in self._nodes]
        seen += map(id, visited_by(root) if visited is None else visited)
        if seen == self._seen:
            return False
        self._seen = seen
        return True

    def forget(self) -> None:
        """Takes the next tree for a new one: after behaviours were added to the tree or removed from it."""
        self._root, self._nodes, self._seen = None, [], []


def visited_by(root: Behaviour) -> Collection[Behaviour]:
    """What the last tick of a mission passed through. Of any other tree: the behaviours that have a status."""
    if isinstance(root, MissionNode):
        return root.last_visited
    return [node for node in root.iterate() if node.status is not Status.INVALID]


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


def _behaviour(node: Behaviour, is_root: bool, is_active: bool) -> BehaviourSnapshot:
    tip = node.tip()
    current = node.current_child if isinstance(node, composites.Composite) else None
    return BehaviourSnapshot(
        name=node.name,
        class_name=f"{type(node).__module__}.{type(node).__name__}",
        own_id=node.id,
        parent_id=NO_ID if is_root or node.parent is None else node.parent.id,
        tip_id=NO_ID if tip is None or tip is node else tip.id,
        child_ids=tuple(child.id for child in node.children),
        current_child_id=NO_ID if current is None else current.id,
        type=type_of(node),
        additional_detail=_detail(node),
        blackbox_level=_BLACKBOX_LEVEL[node.blackbox_level],
        status=_STATUS[node.status],
        message=node.feedback_message,
        is_active=is_active,
        blackboard_access=_access(node),
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


def _values(nodes: Iterable[Behaviour]) -> tuple[Pair, ...]:
    paths = sorted({path for node in nodes for path, _ in _access(node)})
    return tuple(
        (path, _text(Blackboard.storage[path]) if path in Blackboard.storage else "-") for path in paths
    )


def _text(value: Any) -> str:
    text = str(value)
    return text if len(text) <= MAX_TEXT else f"{text[:MAX_TEXT]}..."


def _activity() -> tuple[ActivitySnapshot, ...]:
    stream = Blackboard.activity_stream
    if stream is None:
        return ()
    return tuple(
        ActivitySnapshot(
            item.key,
            item.client_name,
            item.activity_type,
            _text(item.previous_value),
            _text(item.current_value),
        )
        for item in stream.data
    )
