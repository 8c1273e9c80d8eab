"""Groot2's monitor protocol as bytes: what BehaviorTree.CPP 4 and Groot2 say to each other over ZeroMQ.

Groot2 asks on a REQ socket, port p; news come on a PUB socket, port p + 1. The first part of a question is 6 bytes:
protocol (2), kind (a letter), a number; the answer's first part repeats them and adds the tree's 16 bytes. Numbers are
little endian. Some kinds have a second part. Source: BehaviorTree.CPP 4.8, groot2_protocol.h; checked against a running
`Groot2Publisher` by the tests.
"""

from __future__ import annotations

import json
import struct
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from enum import Enum, IntEnum
from typing import Any
from uuid import UUID

from py_trees.common import Status

from target_nav.errors import TargetNavError

PROTOCOL = 2
_REQUEST = struct.Struct("<BBI")
_STATUS = struct.Struct("<HB")


class Kind(str, Enum):
    """What is asked, by the letter on the wire."""

    FULL_TREE = "T"
    STATUS = "S"
    BLACKBOARD = "B"
    HOOK_INSERT = "I"
    HOOK_REMOVE = "R"
    BREAKPOINT_REACHED = "N"
    BREAKPOINT_UNLOCK = "U"
    HOOKS_DUMP = "D"
    REMOVE_ALL_HOOKS = "A"
    DISABLE_ALL_HOOKS = "X"
    TOGGLE_RECORDING = "r"
    GET_TRANSITIONS = "t"


class NodeStatus(IntEnum):
    """BehaviorTree.CPP's numbers."""

    IDLE = 0
    RUNNING = 1
    SUCCESS = 2
    FAILURE = 3
    SKIPPED = 4


IDLE_FROM = 10
"""Added to the status that an idle node had before."""

STATUS_OF = {
    Status.INVALID: NodeStatus.IDLE,
    Status.RUNNING: NodeStatus.RUNNING,
    Status.SUCCESS: NodeStatus.SUCCESS,
    Status.FAILURE: NodeStatus.FAILURE,
}


class ProtocolError(TargetNavError):
    """A question that cannot be answered; the text goes back to who asked."""


@dataclass(frozen=True)
class Request:
    kind: Kind
    number: int
    content: bytes | None = None


def parse_request(parts: list[bytes]) -> Request:
    """
    Raises:
        ProtocolError: not a question of this protocol.
    """
    if not parts or len(parts[0]) != _REQUEST.size:
        raise ProtocolError("wrong request header")
    _, letter, number = _REQUEST.unpack(parts[0])
    try:
        kind = Kind(chr(letter))
    except ValueError:
        raise ProtocolError("Request not recognized") from None
    return Request(kind, number, parts[1] if len(parts) == 2 else None)


def request_header(kind: Kind, number: int) -> bytes:
    return _REQUEST.pack(PROTOCOL, ord(kind.value), number)


def reply_header(request: Request, tree: UUID) -> bytes:
    return request_header(request.kind, request.number) + tree.bytes


def status_bytes(codes: Mapping[int, int]) -> bytes:
    """Codes by node number."""
    return b"".join(_STATUS.pack(uid, code) for uid, code in codes.items())


def transition_bytes(transitions: Iterable[tuple[int, int, int]]) -> bytes:
    """Of each: microseconds since recording began (6 bytes), node number, code."""
    return b"".join(
        (time_us & (2**48 - 1)).to_bytes(6, "little") + _STATUS.pack(uid, code)
        for time_us, uid, code in transitions
    )


class HookMode(IntEnum):
    BREAKPOINT = 0
    REPLACE = 1


@dataclass
class HookState:
    """A hook as Groot2 sees it. `desired_status` SKIPPED means: tick the node as usual."""

    uid: int
    mode: HookMode = HookMode.BREAKPOINT
    once: bool = False
    enabled: bool = True
    desired_status: NodeStatus = NodeStatus.SKIPPED
    position: int = 0

    def as_json(self) -> dict[str, Any]:
        return {
            "enabled": self.enabled,
            "uid": self.uid,
            "mode": int(self.mode),
            "once": self.once,
            "desired_status": self.desired_status.name,
            "position": self.position,
        }


def parse_json(request: Request) -> Any:
    """
    Raises:
        ProtocolError: no second part, or it is no JSON.
    """
    if request.content is None:
        raise ProtocolError("must be 2 parts message")
    try:
        return json.loads(request.content)
    except ValueError as error:
        raise ProtocolError(f"the second part is no JSON: {error}") from None


def parse_hook(data: Any) -> HookState:
    """
    Raises:
        ProtocolError: something is missing, or has a value that it cannot have.
    """
    try:
        return HookState(
            uid=int(data["uid"]),
            mode=HookMode(int(data["mode"])),
            once=bool(data["once"]),
            enabled=bool(data["enabled"]),
            desired_status=status_named(data["desired_status"]),
            position=int(data["position"]),
        )
    except (KeyError, TypeError, ValueError) as error:
        raise ProtocolError(f"a hook cannot be read: {error!r}") from None


def status_named(name: object) -> NodeStatus:
    """
    Raises:
        ValueError: no status of BehaviorTree.CPP.
    """
    if not isinstance(name, str) or name not in NodeStatus.__members__:
        raise ValueError(f"desired_status is {name!r}; it must be one of {', '.join(NodeStatus.__members__)}")
    return NodeStatus[name]
