"""Types of ports: what they are called, which of them a text can be, and which a port can take from another."""

from __future__ import annotations

from enum import Enum
from types import UnionType
from typing import Any, Union, get_args, get_origin

_UNITS = {
    "m": "m",
    "s": "s",
    "msec": "ms",
    "mps": "m/s",
    "mps2": "m/s^2",
    "rad": "rad",
    "radps": "rad/s",
    "radps2": "rad/s^2",
    "hz": "Hz",
    "px": "px",
}

UNKNOWN = (object, Any)
"""Types that say nothing."""


def unit_of(port: str) -> str:
    """The unit that ends a port's name (`speed_mps`: m/s), or nothing."""
    return _UNITS.get(port.rsplit("_", 1)[-1], "")


def type_name(data_type: Any) -> str:
    """A port's type in words a mission's author knows."""
    if data_type is bool:
        return "true or false"
    if data_type is int:
        return "a whole number"
    if data_type is float:
        return "a finite number"
    if data_type is str:
        return "text"
    if data_type in UNKNOWN:
        return "anything"
    if is_enum(data_type):
        return " or ".join(member.name for member in data_type)
    item = item_type(data_type)
    if item is not None:
        return f"a list with ; between, each {type_name(item)}"
    if get_origin(data_type) in (Union, UnionType):
        return " or ".join(type_name(each) for each in get_args(data_type) if each is not type(None))
    return getattr(data_type, "__name__", str(data_type))


def item_type(data_type: Any) -> Any:
    """The type of a list's items; None if it is no list, or one whose items have no type."""
    if get_origin(data_type) is list:
        return next(iter(get_args(data_type)), None)
    return None


def can_be_written(data_type: Any) -> bool:
    """Whether a text can mean a value of that type."""
    if get_origin(data_type) in (Union, UnionType):
        return any(can_be_written(each) for each in get_args(data_type))
    if item_type(data_type) is not None:
        return can_be_written(item_type(data_type))
    simple = (bool, int, float, str, object, Any)
    return data_type in simple or (is_enum(data_type))


def accepts(reader: Any, writer: Any) -> bool:
    """Whether a port that reads type `reader` can take what a port of type `writer` wrote. Unknown types pass."""
    if reader in UNKNOWN or writer in UNKNOWN:
        return True
    if list in (get_origin(reader), get_origin(writer)):
        return (get_origin(reader) or reader) is (get_origin(writer) or writer)
    if not _is_class(reader) or not _is_class(writer):
        return True
    if bool in (reader, writer):
        return reader is writer
    return issubclass(writer, reader)


def _is_class(data_type: Any) -> bool:
    # Python 3.10 takes list[int] for an instance of `type`.
    return isinstance(data_type, type) and get_origin(data_type) is None


def is_enum(data_type: Any) -> bool:
    return _is_class(data_type) and issubclass(data_type, Enum)
