"""What a script's operators do with values: BehaviorTree.CPP's rules on Python's numbers and texts.

Whole numbers are its int64, the others its double. Calculating gives doubles; comparing gives 1.0 or 0.0; two
doubles are equal when they differ by no more than a float's epsilon. Both sides of `&&` are always evaluated.
"""

from __future__ import annotations

import math
import operator
import re
from collections.abc import Callable, Mapping
from enum import Enum
from numbers import Integral, Real
from typing import Any, Final

from target_nav.mission.script.syntax import ScriptError

Enums = Mapping[str, int]

EPSILON: Final = 2.0**-23
LARGEST_EXACT: Final = 2**53 - 1
"""Whole numbers beyond are not all doubles."""
_INT64: Final = (-(2**63), 2**63 - 1)

_NUMBER = re.compile(r"[+-]?([0-9]+(\.[0-9]*)?|\.[0-9]+)([eE][+-]?[0-9]{1,4})?")


def number_in(value: object) -> int | float | None:
    """The number that a value is; None when it is none. An Enum's member counts if its value does."""
    if isinstance(value, (int, float)):
        return value
    if isinstance(value, Enum):
        return value.value if isinstance(value.value, (int, float)) else None
    if isinstance(value, Integral):
        return int(value)
    if isinstance(value, Real):
        return float(value)
    return None


def as_double(value: int | float) -> float:
    if isinstance(value, int) and abs(value) > LARGEST_EXACT:
        raise ScriptError(f"{value} is too large to be calculated with")
    return float(value)


def as_integer(value: int | float) -> int:
    """The same number as an int64.

    Raises:
        ScriptError: it is not a whole number, or too large.
    """
    if isinstance(value, float):
        if not value.is_integer():
            raise ScriptError(f"{value:g} is not a whole number")
        value = int(value)
    if not _INT64[0] <= value <= _INT64[1]:
        raise ScriptError(f"{value} is too large for a whole number")
    return int(value)


def as_text(value: object) -> str:
    """A text or number as text: 2 is `2`, 2.5 is `2.500000`, true is `1`."""
    if isinstance(value, str):
        return value
    number = number_in(value)
    if number is None:
        raise ScriptError(f"{described(value)} cannot be made text")
    return str(int(number)) if isinstance(number, int) else f"{number:f}"


def text_as_number(text: str, enums: Enums | None) -> float:
    """
    Raises:
        ScriptError: the text is neither a number nor, with `enums`, `true`, `false` or an enum's constant.
    """
    if enums is not None:
        if text in ("true", "false"):
            return 1.0 if text == "true" else 0.0
        if text in enums:
            return float(enums[text])
    stripped = text.strip()
    if not _NUMBER.fullmatch(stripped):
        raise ScriptError(f"text '{text}' is no number")
    return float(stripped)


def described(value: object) -> str:
    """A value with its kind, for a message."""
    if value is None:
        return "nothing"
    if isinstance(value, str):
        return f"text '{value}'"
    number = number_in(value)
    if number is not None:
        return f"{number:g}" if isinstance(number, float) else str(int(number))
    return f"a {type(value).__name__}"


def truth(value: object) -> bool:
    """Whether a condition holds. A whole number must be 0 or 1, as BehaviorTree.CPP wants it.

    Raises:
        ScriptError: it is not a number, or neither true nor false.
    """
    if type(value) is float:
        return bool(value)
    number = number_in(value)
    if number is None:
        raise ScriptError(f"{described(value)} is neither true nor false")
    if isinstance(number, int) and number not in (0, 1):
        raise ScriptError(f"{number} is neither true (1) nor false (0); compare it with something")
    return bool(number)


def chooses(value: object) -> bool:
    """Whether `value ? a : b` is a: any number but 0. A text must be a number's."""
    if isinstance(value, str):
        return text_as_number(value, None) != 0.0
    number = number_in(value)
    if number is None:
        raise ScriptError(f"{described(value)} cannot decide")
    return as_double(number) != 0.0


def unary(sign: str, value: object) -> float:
    number = number_in(value)
    if number is None:
        raise ScriptError(f"{sign} needs a number, not {described(value)}")
    double = as_double(number)
    if sign == "-":
        return -double
    if sign == "!":
        return 0.0 if double else 1.0
    if not _INT64[0] <= double <= _INT64[1]:
        raise ScriptError(f"~ needs a whole number, not {double:g}")
    return float(~int(double))


def _divided(left: float, right: float) -> float:
    if right == 0.0:
        return (
            math.nan
            if left == 0.0 or math.isnan(left)
            else math.copysign(math.inf, left) * math.copysign(1, right)
        )
    return left / right


CALCULATE: Final[dict[str, Callable[[float, float], float]]] = {
    "+": lambda left, right: left + right,
    "-": lambda left, right: left - right,
    "*": lambda left, right: left * right,
    "/": _divided,
}
_BITS: Final[dict[str, Callable[[int, int], int]]] = {
    "&": lambda left, right: left & right,
    "|": lambda left, right: left | right,
    "^": lambda left, right: left ^ right,
}


def binary(sign: str, left: object, right: object) -> Any:
    """A number, or a text for texts with `+` and for `..`."""
    first, second = number_in(left), number_in(right)
    if first is not None and second is not None:
        if sign in CALCULATE:
            return CALCULATE[sign](as_double(first), as_double(second))
        if sign in _BITS:
            return float(_BITS[sign](as_integer(first), as_integer(second)))
        if sign == "..":
            raise ScriptError(f".. needs a text, not {described(left)} and {described(right)}")
        both = truth(left), truth(right)
        return float(all(both) if sign == "&&" else any(both))
    texts = isinstance(left, str), isinstance(right, str)
    if (sign == "+" and all(texts)) or (
        sign == ".."
        and any(texts)
        and all(text or number is not None for text, number in zip(texts, (first, second)))
    ):
        return as_text(left) + as_text(right)
    raise ScriptError(f"{sign} cannot be used with {described(left)} and {described(right)}")


# Written as BehaviorTree.CPP does, for the sake of NaN and of two infinities.
COMPARE_DOUBLES: Final[dict[str, Callable[[float, float], bool]]] = {
    "==": lambda left, right: abs(left - right) <= EPSILON,
    "!=": lambda left, right: not abs(left - right) <= EPSILON,
    "<": lambda left, right: not left >= right,
    ">": lambda left, right: not left <= right,
    "<=": lambda left, right: not left > right,
    ">=": lambda left, right: not left < right,
}


_COMPARE_TEXTS: Final[dict[str, Callable[[str, str], bool]]] = {
    "==": operator.eq,
    "!=": operator.ne,
    "<": operator.lt,
    ">": operator.gt,
    "<=": operator.le,
    ">=": operator.ge,
}


def compare(sign: str, left: object, right: object, enums: Enums) -> bool:
    """A text beside a number is taken for a number, `true`, `false` or an enum's constant."""
    if isinstance(left, str) and isinstance(right, str):
        return _COMPARE_TEXTS[sign](left, right)
    first = text_as_number(left, enums) if isinstance(left, str) else number_in(left)
    second = text_as_number(right, enums) if isinstance(right, str) else number_in(right)
    if first is None or second is None:
        raise ScriptError(f"{sign} cannot be used with {described(left)} and {described(right)}")
    return COMPARE_DOUBLES[sign](as_double(first), as_double(second))


def assigned(old: object, value: object, enums: Enums) -> object:
    """What an entry that holds `old` then holds: an entry keeps its kind, as in BehaviorTree.CPP.

    Raises:
        ScriptError: the value does not fit.
    """
    before, number = number_in(old), number_in(value)
    if isinstance(value, str):
        if isinstance(old, str):
            return value
        if before is not None:
            return text_as_number(value, enums)
    elif number is not None and before is not None:
        if isinstance(before, float):
            return as_double(number)
        try:
            whole = as_integer(number)
        except ScriptError as error:
            raise ScriptError(f"it holds a whole number, and {error}; begin with {before}.0") from None
        return bool(whole) if isinstance(old, bool) and whole in (0, 1) else whole
    elif number is None and type(old) is type(value):
        return value
    raise ScriptError(f"it holds {described(old)}, and {described(value)} is of another kind")
