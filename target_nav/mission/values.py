"""What an attribute's text means: a literal in the port's type and limits, or a `{key}` of the blackboard."""

from __future__ import annotations

import math
import re
from enum import Enum
from types import UnionType
from typing import Any, Union, get_args, get_origin

_INT = re.compile(r"[+-]?[0-9]{1,18}")
_FLOAT = re.compile(r"[+-]?([0-9]+(\.[0-9]*)?|\.[0-9]+)([eE][+-]?[0-9]{1,4})?")
_KEY = re.compile(r"@?[A-Za-z0-9_-]+(/[A-Za-z0-9_-]+)*")
_TRUE = ("true", "True", "TRUE", "1")
_FALSE = ("false", "False", "FALSE", "0")

KEY_RULE = "a key is letters, digits, _ and - (with / between parts, and @ in front for the root blackboard)"

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


class BadValue(ValueError):
    """A text that does not fit its port. The message continues `<port> is "<text>"; `."""


def unit_of(port: str) -> str:
    """The unit that ends a port's name (`speed_mps`: m/s), or nothing."""
    return _UNITS.get(port.rsplit("_", 1)[-1], "")


def key_in(text: str, port: str) -> str | None:
    """The key of `{key}` or of `{=}` (the port's own name); None when the text is a literal.

    Raises:
        BadValue: it looks like a reference, but is none.
    """
    stripped = text.strip(" ")
    if stripped in ("{=}", "="):
        return port
    opened, closed = stripped.startswith("{"), stripped.endswith("}")
    if not (opened and closed):
        if opened or closed:
            raise BadValue("a reference to the blackboard is {key}, with both braces and nothing round them")
        return None
    key = stripped[1:-1]
    if not _KEY.fullmatch(key):
        raise BadValue(KEY_RULE)
    return key


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
    if isinstance(data_type, type) and issubclass(data_type, Enum):
        return " or ".join(member.name for member in data_type)
    return getattr(data_type, "__name__", str(data_type))


def to_literal(text: str, port: str, data_type: Any, limits: tuple[float, float] | None) -> Any:
    """`text` in the port's type.

    Raises:
        BadValue: another type, not finite, or outside the limits.
    """
    value = _converted(text, data_type)
    check_limits(value, port, limits)
    return value


def _converted(text: str, data_type: Any) -> Any:
    if data_type is str or data_type is object or data_type is Any:
        return text
    if get_origin(data_type) in (Union, UnionType):
        return _first_of(text, get_args(data_type))
    stripped = text.strip()
    if data_type is bool:
        if stripped in _TRUE or stripped in _FALSE:
            return stripped in _TRUE
    elif data_type is int:
        if _INT.fullmatch(stripped):
            return int(stripped)
    elif data_type is float:
        if _FLOAT.fullmatch(stripped) and math.isfinite(float(stripped)):
            return float(stripped)
    elif isinstance(data_type, type) and issubclass(data_type, Enum):
        if stripped in data_type.__members__:
            return data_type[stripped]
    else:
        raise BadValue(
            f"a {type_name(data_type)} cannot be written as text; give a {{key}} that somebody writes"
        )
    raise BadValue(f"it must be {type_name(data_type)}, or a {{key}}")


def _first_of(text: str, types: tuple[Any, ...]) -> Any:
    for each in types:
        if each is not type(None):
            try:
                return _converted(text, each)
            except BadValue:
                continue
    names = " or ".join(type_name(each) for each in types if each is not type(None))
    raise BadValue(f"it must be {names}, or a {{key}}")


def check_limits(value: Any, port: str, limits: tuple[float, float] | None) -> None:
    """
    Raises:
        BadValue: a number outside its inclusive limits.
    """
    if limits is None or isinstance(value, bool) or not isinstance(value, (int, float)):
        return
    low, high = limits
    # written so that NaN fails
    if not low <= value <= high:
        raise BadValue(f"it must lie in {_bounds(low, high, unit_of(port))}")


def _bounds(low: float, high: float, unit: str) -> str:
    return f"{low:.12g} ... {high:.12g} {unit}".rstrip()


def from_blackboard(value: Any, data_type: Any) -> Any:
    """A blackboard value in a built-in's type. Text is converted, as in BehaviorTree.CPP; an int may be a float.

    Raises:
        BadValue: it has another type.
    """
    if isinstance(value, str) and data_type is not str:
        return _converted(value, data_type)
    if data_type is float and isinstance(value, int) and not isinstance(value, bool):
        return float(value)
    if isinstance(value, bool) is not (data_type is bool) or not isinstance(value, data_type):
        raise BadValue(f"it must be {type_name(data_type)}")
    return value


def accepts(reader: Any, writer: Any) -> bool:
    """Whether a port that reads type `reader` can take what a port of type `writer` wrote. Unknown types pass."""
    unknown = (Any, object)
    if reader in unknown or writer in unknown or not isinstance(reader, type) or not isinstance(writer, type):
        return True
    if bool in (reader, writer):
        return reader is writer
    return issubclass(writer, reader)
