"""A tree as it came over the wire, as a tree of py_trees that its displays can draw. Nothing in it can be ticked."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any
from uuid import UUID

from py_trees import behaviours, common, composites, decorators
from py_trees.behaviour import Behaviour
from py_trees.common import Status

_STATUS = {1: Status.INVALID, 2: Status.RUNNING, 3: Status.SUCCESS, 4: Status.FAILURE}
_SEQUENCE, _SELECTOR, _PARALLEL, _DECORATOR = 2, 3, 4, 6
_POLICIES = {
    "OnAll": common.ParallelPolicy.SuccessOnAll,
    "OnOne": common.ParallelPolicy.SuccessOnOne,
}


@dataclass(frozen=True)
class ShownTree:
    """`visited` is what the last tick passed through, with its status, as py_trees' displays take it."""

    root: Behaviour
    visited: dict[UUID, Status]


class BrokenTreeError(ValueError):
    """Messages that make no tree; the text says why."""


def tree_of(messages: Sequence[Any]) -> ShownTree:
    """The tree of `py_trees_ros_interfaces/Behaviour` messages.

    Raises:
        BrokenTreeError: no root or two, or a child that is not there.
    """
    by_id = {bytes(each.own_id.uuid): each for each in messages}
    roots = [each for each in messages if not any(each.parent_id.uuid)]
    if len(roots) != 1:
        raise BrokenTreeError(f"{len(roots)} of {len(messages)} behaviours have no parent; it must be one")
    visited: dict[UUID, Status] = {}
    return ShownTree(_behaviour(roots[0], by_id, visited), visited)


def _behaviour(message: Any, by_id: dict[bytes, Any], visited: dict[UUID, Status]) -> Behaviour:
    children = []
    for child in message.child_ids:
        if bytes(child.uuid) not in by_id:
            raise BrokenTreeError(f"a child of {message.name!r} is not in the list")
        children.append(_behaviour(by_id[bytes(child.uuid)], by_id, visited))
    shown = _stand_in(message, children)
    shown.id = UUID(bytes=bytes(message.own_id.uuid))
    shown.status = _STATUS.get(message.status, Status.INVALID)
    shown.feedback_message = message.message
    if message.is_active:
        visited[shown.id] = shown.status
    return shown


def _stand_in(message: Any, children: list[Behaviour]) -> Behaviour:
    name, kind, detail = message.name, message.type, message.additional_detail
    with_memory = detail == "WithMemory"
    if kind == _SEQUENCE:
        return composites.Sequence(name, with_memory, children)
    if kind == _SELECTOR:
        return composites.Selector(name, with_memory, children)
    if kind == _PARALLEL:
        return composites.Parallel(
            name, _POLICIES.get(detail, common.ParallelPolicy.SuccessOnAll)(), children
        )
    if kind == _DECORATOR and len(children) == 1:
        return decorators.PassThrough(name, children[0])
    return behaviours.Dummy(name)
