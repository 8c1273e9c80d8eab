"""Where a built-in node's port gets its value: the mission's text, or the blackboard at the moment of reading."""

from __future__ import annotations

from typing import Any, Protocol

from py_trees.blackboard import Client
from py_trees.common import Access

from target_nav.mission.values import BadValue, check_limits, from_blackboard


class Source(Protocol):
    def read(self) -> Any:
        """The value.

        Raises:
            ValueError: there is none, or not one that fits; the text continues a sentence that begins with the port.
        """


class Constant:
    """A literal, checked when the mission was loaded."""

    def __init__(self, value: Any) -> None:
        self._value = value

    def read(self) -> Any:
        return self._value


class FromKey:
    """A blackboard entry, checked each time it is read."""

    def __init__(
        self,
        client: Client,
        path: str,
        port: str,
        data_type: Any,
        limits: tuple[float, float] | None,
        default: Any,
    ) -> None:
        client.register_key(key=path, access=Access.READ)
        self._client = client
        self._path = path
        self._port = port
        self._type = data_type
        self._limits = limits
        self._default = default

    def read(self) -> Any:
        try:
            value = self._client.get(self._path)
        except KeyError:
            if self._default is None:
                raise ValueError(f"reads {self._path}, which nobody has written yet") from None
            return self._default
        try:
            converted = from_blackboard(value, self._type)
            check_limits(converted, self._port, self._limits)
        except BadValue as error:
            raise ValueError(f"read {value!r} from {self._path}; {error}") from None
        return converted
