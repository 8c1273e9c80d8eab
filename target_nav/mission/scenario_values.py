"""YAML's own values as values of a blackboard key's type, or a message for the scenario's author."""

from __future__ import annotations

import dataclasses
import math
import types
import typing
from collections.abc import Collection, Mapping
from enum import Enum
from typing import Any

import numpy as np

from target_nav.mission.problems import did_you_mean
from target_nav.state.types import FloatArray


class BadScript(ValueError):
    """Something that the blackboard cannot hold. The message is for the author of the scenario."""


def value_of(data: Any, wanted: Any, what: str, optional: bool = False) -> Any:
    """`data` (YAML's own values, or already an object of that type) as a value of type `wanted`.

    Raises:
        BadScript: it cannot be one.
    """
    if data is None or (isinstance(data, str) and data == "none"):
        if optional or _takes_none(wanted):
            return None
        raise BadScript(f"{what} is none; it must be {_name(wanted)}")
    if typing.get_origin(wanted) in (typing.Union, types.UnionType):
        wanted = next(each for each in typing.get_args(wanted) if each is not type(None))
    if wanted is float and isinstance(data, (int, float)) and not isinstance(data, bool):
        return float(data)
    if wanted is int and isinstance(data, int) and not isinstance(data, bool):
        return data
    if wanted is np.ndarray:
        return array_of(data, what)
    if typing.get_origin(wanted) is tuple:
        return tuple_of(data, typing.get_args(wanted), what)
    if isinstance(wanted, type):
        if isinstance(data, wanted) and isinstance(data, bool) is (wanted is bool):
            return data
        if issubclass(wanted, Enum) and isinstance(data, str) and data in wanted.__members__:
            return wanted[data]
        if dataclasses.is_dataclass(wanted) and isinstance(data, Mapping):
            return _object(data, wanted, what)
    raise BadScript(f"{what} is {data!r}; it must be {_name(wanted)}")


def _takes_none(wanted: Any) -> bool:
    return type(None) in typing.get_args(wanted)


def _name(wanted: Any) -> str:
    if isinstance(wanted, type) and issubclass(wanted, Enum):
        return " or ".join(wanted.__members__)
    if dataclasses.is_dataclass(wanted):
        return "{" + ", ".join(f"{f.name}: ..." for f in dataclasses.fields(wanted)) + "}"
    words = {
        float: "a number",
        int: "a whole number",
        bool: "true or false",
        str: "text",
        np.ndarray: "[[x, y], ...]",
    }
    return words.get(wanted, getattr(wanted, "__name__", str(wanted)))


def array_of(data: Any, what: str) -> FloatArray:
    """Points of shape (N, 2)."""
    try:
        array = np.asarray(data, dtype=np.float64)
    except (TypeError, ValueError):
        array = np.empty((0, 0))
    if array.size == 0 and isinstance(data, (list, tuple, np.ndarray)) and len(data) == 0:
        return np.empty((0, 2))
    if array.ndim != 2 or array.shape[1] != 2:
        raise BadScript(f"{what} is {data!r}; it must be points: [[x, y], ...]")
    return array


def tuple_of(data: Any, kinds: tuple[Any, ...], what: str) -> tuple[Any, ...]:
    if not isinstance(data, (list, tuple)):
        raise BadScript(f"{what} is {data!r}; it must be a list")
    if len(kinds) == 2 and kinds[1] is Ellipsis:
        kinds = (kinds[0],) * len(data)
    if len(kinds) != len(data):
        raise BadScript(f"{what} has {len(data)} values; it must have {len(kinds)}")
    return tuple(value_of(each, kind, f"{what}[{i}]") for i, (each, kind) in enumerate(zip(data, kinds)))


def _object(data: Mapping[str, Any], wanted: type, what: str) -> Any:
    hints = typing.get_type_hints(wanted)
    fields = {f.name: f for f in dataclasses.fields(wanted)}
    check_words(data, fields, what)
    missing = [
        name
        for name, f in fields.items()
        if name not in data and f.default is dataclasses.MISSING and f.default_factory is dataclasses.MISSING
    ]
    if missing:
        raise BadScript(f"{what} lacks {', '.join(missing)}")
    return wanted(**{name: value_of(each, hints[name], f"{what}: {name}") for name, each in data.items()})


def check_words(data: Any, allowed: Collection[str], what: str) -> None:
    if not isinstance(data, Mapping):
        raise BadScript(f"{what} is {data!r}; it must be a mapping with {', '.join(allowed)}")
    for name in data:
        if name not in allowed:
            raise BadScript(
                f"{what} has no {name!r}{did_you_mean(name, allowed)}; it has {', '.join(allowed)}"
            )


def number(data: Mapping[str, Any], name: str, what: str, default: float | None = None) -> float:
    if name not in data and default is not None:
        return default
    value: float = value_of(data.get(name), float, f"{what}: {name}")
    if math.isnan(value):
        raise BadScript(f"{what}: {name} is not a number")
    return value
