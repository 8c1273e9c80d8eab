"""What a scenario expects of a value on the blackboard, written as YAML's own values.

text with * or ?              fits as a pattern
other text, true, a number    is that (an enumeration by its member's name)
none                          there is no value
[a, b]                        a sequence that fits item by item
{above: 0.1, below: 2.0}      a number between, both excluded
{near: 0.5, tolerance: 0.02}  a number within (tolerance 0.01 if not said)
{field: ...}                  an object whose fields fit; those not named do not matter
"""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from enum import Enum
from fnmatch import fnmatchcase
from typing import Any

import numpy as np

from target_nav.mission.values_text import value_text

RANGE_WORDS = ("above", "below", "near", "tolerance")
NONE_WORDS = ("none", "null")
TOLERANCE = 0.01


class BadExpectation(ValueError):
    """An expectation that cannot be meant so."""


@dataclass(frozen=True)
class Matcher:
    """One expected value, as written."""

    expected: Any

    def mismatch(self, value: Any) -> str:
        """Why `value` does not fit, or nothing."""
        return _mismatch(self.expected, value, "")

    def __str__(self) -> str:
        return _text(self.expected)


def matcher(data: Any) -> Matcher:
    """
    Raises:
        BadExpectation: a range with a word or a value that it cannot have.
    """
    _check(data)
    return Matcher(data)


def _check(data: Any) -> None:
    if isinstance(data, Mapping):
        if any(word in data for word in RANGE_WORDS):
            for word, limit in data.items():
                if word not in RANGE_WORDS:
                    raise BadExpectation(f"{word!r} beside a range; a range has {', '.join(RANGE_WORDS)}")
                if isinstance(limit, bool) or not isinstance(limit, (int, float)) or math.isnan(limit):
                    raise BadExpectation(f"{word} is {limit!r}; it must be a number")
            if "tolerance" in data and "near" not in data:
                raise BadExpectation("tolerance without near")
        else:
            for each in data.values():
                _check(each)
    elif isinstance(data, (list, tuple)):
        for each in data:
            _check(each)


def _mismatch(expected: Any, value: Any, where: str) -> str:
    if expected is None or (isinstance(expected, str) and expected in NONE_WORDS):
        return "" if value is None else f"{where}is {value_text(value)}, not none"
    if isinstance(expected, Mapping):
        if any(word in expected for word in RANGE_WORDS):
            return _out_of_range(expected, value, where)
        return _fields_differ(expected, value, where)
    if isinstance(expected, (list, tuple)):
        return _items_differ(expected, value, where)
    if isinstance(value, Enum) and isinstance(expected, str):
        return "" if expected == value.name else f"{where}is {value.name}, not {expected}"
    if isinstance(expected, str):
        return "" if _text_fits(expected, value) else f"{where}is {value_text(value)}, not {_text(expected)}"
    if isinstance(expected, bool) or isinstance(value, (bool, np.bool_)):
        fits = isinstance(expected, bool) and isinstance(value, (bool, np.bool_)) and bool(value) == expected
    else:
        fits = _is_number(value) and (value == expected or math.isclose(value, expected, rel_tol=1e-9))
    return "" if fits else f"{where}is {value_text(value)}, not {_text(expected)}"


def _text_fits(pattern: str, value: Any) -> bool:
    if not isinstance(value, str):
        return False
    return fnmatchcase(value, pattern) if any(c in pattern for c in "*?") else value == pattern


def _is_number(value: Any) -> bool:
    return isinstance(value, (int, float, np.integer, np.floating)) and not isinstance(value, bool)


def _out_of_range(limits: Mapping[str, float], value: Any, where: str) -> str:
    if not _is_number(value):
        return f"{where}is {value_text(value)}, not a number"
    fits = True
    if "near" in limits:
        fits = abs(value - limits["near"]) <= limits.get("tolerance", TOLERANCE)
    fits = fits and not ("above" in limits and not value > limits["above"])
    fits = fits and not ("below" in limits and not value < limits["below"])
    return "" if fits else f"{where}is {value_text(value)}, not {_text(limits)}"


def _fields_differ(fields: Mapping[str, Any], value: Any, where: str) -> str:
    for name, expected in fields.items():
        if isinstance(value, Mapping):
            there = name in value
            got = value.get(name)
        else:
            there = dataclasses.is_dataclass(value) and hasattr(value, name)
            got = getattr(value, name, None)
        if not there:
            return f"{where}is {value_text(value)}, which has no {name}"
        problem = _mismatch(expected, got, f"{where}{name} ")
        if problem:
            return problem
    return ""


def _items_differ(expected: Sequence[Any], value: Any, where: str) -> str:
    if not isinstance(value, (list, tuple, np.ndarray)) or len(value) != len(expected):
        return f"{where}is {value_text(value)}, not {len(expected)} items"
    for index, (each, got) in enumerate(zip(expected, value)):
        problem = _mismatch(each, got, f"{where}[{index}] ")
        if problem:
            return problem
    return ""


def _text(expected: Any) -> str:
    if isinstance(expected, Mapping):
        if "near" in expected:
            return f"{expected['near']:g} +- {expected.get('tolerance', TOLERANCE):g}"
        if any(word in expected for word in RANGE_WORDS):
            return " and ".join(f"{word} {limit:g}" for word, limit in expected.items())
        return "{" + ", ".join(f"{name}: {_text(each)}" for name, each in expected.items()) + "}"
    if isinstance(expected, (list, tuple)):
        return "[" + ", ".join(map(_text, expected)) + "]"
    if isinstance(expected, bool):
        return "true" if expected else "false"
    return "none" if expected is None else repr(expected) if isinstance(expected, str) else f"{expected:g}"
