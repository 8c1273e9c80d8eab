"""Blackboard entries as the built-in nodes and the scripts of a mission use them.

A leaf reads and writes through py_trees' ports. What BehaviorTree.CPP defines goes through here: text is converted when
it is read, an entry has the type of the ports that are bound to it, and `=` needs an entry that is there.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

from py_trees.blackboard import Blackboard, Client
from py_trees.common import Access

from target_nav.mission.values import BadValue, check_limits, from_blackboard, to_port


@dataclass
class Board:
    """What one mission knows of its entries. Paths are py_trees' keys."""

    types: Mapping[str, Any] = field(default_factory=dict)
    """What is written by scripts and built-ins is converted to this: the type of the ports bound to the entry."""
    declared: set[str] = field(default_factory=set)
    """Entries that are there though they may have no value: a port is bound to them."""


class BoardEntry:
    """One entry, for one node. The client is that node's, so that watchers see who reads and writes."""

    def __init__(self, board: Board, client: Client, path: str, access: Access) -> None:
        self._board = board
        self._client = client
        self._type = board.types.get(path)
        self.path = path
        client.register_key(key=path, access=access)

    @property
    def has_type(self) -> bool:
        return self._type is not None

    @property
    def exists(self) -> bool:
        return self.path in Blackboard.storage or self.path in self._board.declared

    def read(self) -> Any:
        """KeyError, with the path, when it has no value."""
        if Blackboard.activity_stream is None or self.path not in Blackboard.storage:
            return Blackboard.storage[self.path]
        # slower, but watchers are told
        return self._client.get(self.path)

    def write(self, value: Any) -> Any:
        """Stores the value, converted to the entry's type if it has one, and returns it.

        Raises:
            BadValue: it does not fit.
        """
        if self._type is not None:
            value = to_port(value, self._type)
        self._client.set(self.path, value)
        return value

    def unset(self) -> None:
        self._board.declared.discard(self.path)
        self._client.unset(self.path)


class Constant:
    """A literal, checked when the mission was loaded."""

    def __init__(self, value: Any) -> None:
        self._value = value

    def read(self) -> Any:
        return self._value


class FromEntry:
    """A blackboard entry that a built-in's port reads, converted and checked each time."""

    def __init__(
        self, entry: BoardEntry, port: str, data_type: Any, limits: tuple[float, float] | None
    ) -> None:
        self._entry = entry
        self._port = port
        self._type = data_type
        self._limits = limits

    def read(self) -> Any:
        """
        Raises:
            KeyError: it has no value.
            BadValue: it does not fit; the text continues a sentence that begins with the port.
        """
        value = self._entry.read()
        if value is None:
            raise KeyError(self._entry.path)
        try:
            converted = from_blackboard(value, self._type)
            check_limits(converted, self._port, self._limits)
        except BadValue as error:
            raise BadValue(f"read {value!r} from {self._entry.path}; {error}") from None
        return converted

    @property
    def path(self) -> str:
        return self._entry.path
