"""What an attribute's text means: a literal in the port's type and limits, or a `{key}` of the blackboard."""

from __future__ import annotations

import math
import re
from collections.abc import MutableSequence
from types import UnionType
from typing import Any, Union, get_args, get_origin

from target_nav.mission.port_types import UNKNOWN, is_enum, item_type, type_name, unit_of
from target_nav.mission.script.arithmetic import as_text, number_in
from target_nav.mission.script.syntax import ScriptError

_INT = re.compile(r"[+-]?[0-9]{1,18}")
_FLOAT = re.compile(r"[+-]?([0-9]+(\.[0-9]*)?|\.[0-9]+)([eE][+-]?[0-9]{1,4})?")
_KEY = re.compile(r"@?[A-Za-z0-9_-]+(/[A-Za-z0-9_-]+)*")
_TRUE = ("true", "True", "TRUE", "1")
_FALSE = ("false", "False", "FALSE", "0")

KEY_RULE = "a key is letters, digits, _ and - (with / between parts, and @ in front for the root blackboard)"


class BadValue(ValueError):
    """A text that does not fit its port. The message continues `<port> is "<text>"; `."""


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


def to_literal(text: str, port: str, data_type: Any, limits: tuple[float, float] | None) -> Any:
    """`text` in the port's type.

    Raises:
        BadValue: another type, not finite, or outside the limits.
    """
    value = _converted(text, data_type)
    check_limits(value, port, limits)
    return value


def _converted(text: str, data_type: Any) -> Any:
    if data_type is str or data_type in UNKNOWN:
        return text
    if get_origin(data_type) in (Union, UnionType):
        return _first_of(text, get_args(data_type))
    item = item_type(data_type)
    if item is not None:
        return _list_of(text, item, data_type)
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
    elif is_enum(data_type):
        if stripped in data_type.__members__:
            return data_type[stripped]
    else:
        raise BadValue(
            f"a {type_name(data_type)} cannot be written as text; give a {{key}} that somebody writes"
        )
    raise BadValue(f"it must be {type_name(data_type)}, or a {{key}}")


def _list_of(text: str, item: Any, data_type: Any) -> list[Any]:
    # As BehaviorTree.CPP splits: one ; at the end is none too many, and no text is no item.
    parts = text.split(";")
    try:
        return [_converted(part, item) for part in (parts[:-1] if not parts[-1] else parts)]
    except BadValue:
        raise BadValue(f"it must be {type_name(data_type)}, or a {{key}}") from None


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
    """A blackboard value in a built-in's type. Text is converted, as in BehaviorTree.CPP; so are 2 and 2.0.

    Raises:
        BadValue: it has another type.
    """
    if data_type in UNKNOWN:
        return value
    if get_origin(data_type) is list:
        # A text is none: taking items out of it would not make it shorter.
        if not isinstance(value, MutableSequence):
            raise BadValue(f"it must be {type_name(data_type)}")
        return value
    if isinstance(value, str) and data_type is not str:
        return _converted(value, data_type)
    if data_type is float and isinstance(value, int) and not isinstance(value, bool):
        return float(value)
    if data_type is int and isinstance(value, float) and value.is_integer():
        return int(value)
    if isinstance(value, bool) is not (data_type is bool) or not isinstance(
        value, get_origin(data_type) or data_type
    ):
        raise BadValue(f"it must be {type_name(data_type)}")
    return value


def to_port(value: Any, data_type: Any) -> Any:
    """What a script or a built-in writes, in the type of the ports that read it.

    Numbers become each other where nothing is lost, 0 and 1 also false and true; numbers become text, and text what it
    says.

    Raises:
        BadValue: it does not fit.
    """
    if data_type in UNKNOWN:
        return value
    if get_origin(data_type) in (Union, UnionType):
        return _to_first(value, data_type)
    if isinstance(value, str) and data_type is not str:
        try:
            return _converted(value, data_type)
        except BadValue:
            raise BadValue(f"it must be {type_name(data_type)}") from None
    number = number_in(value)
    if data_type is bool and number in (0, 1):
        return bool(number)
    if data_type is int and number is not None and float(number).is_integer():
        return int(number)
    if data_type is float and number is not None and math.isfinite(number):
        return float(number)
    if data_type is str:
        try:
            return as_text(value)
        except ScriptError as error:
            raise BadValue(str(error)) from None
    if is_enum(data_type) and not isinstance(value, data_type):
        for member in data_type:
            if number is not None and member.value == number:
                return member
    elif data_type not in (bool, int, float) and isinstance(value, get_origin(data_type) or data_type):
        return value
    raise BadValue(f"it must be {type_name(data_type)}")


def _to_first(value: Any, data_type: Any) -> Any:
    members = get_args(data_type)
    for member in members:
        if member is type(None) if value is None else isinstance(value, get_origin(member) or member):
            return value
    for member in members:
        try:
            return to_port(value, member)
        except BadValue:
            continue
    raise BadValue(f"it must be {type_name(data_type)}")
