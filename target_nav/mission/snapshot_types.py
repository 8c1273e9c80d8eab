"""The shape of a snapshot: py_trees_ros_interfaces/BehaviourTree as plain data, without ROS."""

from __future__ import annotations

from dataclasses import dataclass
from enum import IntEnum
from uuid import UUID

NO_ID = UUID(int=0)
"""Stands for: no parent, no tip, no current child."""

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
