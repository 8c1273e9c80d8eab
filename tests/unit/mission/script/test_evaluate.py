"""What scripts compute. Each was tried in BehaviorTree.CPP 4.8, but for what docs/mission-language.md says of it."""

from __future__ import annotations

import math
from enum import Enum
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from target_nav.mission.script import ScriptError, as_text, parse_script, truth
from tests.unit.mission.script.engine import after, value_of

NUMBERS = st.one_of(st.integers(-(2**40), 2**40), st.floats(-1e9, 1e9), st.booleans())


class Side(Enum):
    LEFT = 1
    RIGHT = 2
    NOWHERE = "nowhere"


@pytest.mark.parametrize(
    ("text", "value"),
    [
        ("1 + 2 * 3", 7.0),
        ("10 - 3 - 2", 5.0),
        ("100 / 10 * 5", 50.0),
        ("7 / 2", 3.5),
        ("-5", -5.0),
        ("~5", -6.0),
        ("~2.7", -3.0),
        ("!true", 0.0),
        ("!0.0", 1.0),
        ("1 & 3 | 4 ^ 1", 4.0),
        ("2.0 & 3", 2.0),
        ("1 == 1", 1.0),
        ("0.1 + 0.2 == 0.3", 1.0),
        ("1.000001 == 1", 0.0),
        ("1 < 2 < 3", 1.0),
        ("1 < 3 < 2", 0.0),
        ("1 < 2 == 1", 0.0),
        ("true == 1", 1.0),
        ("'a' < 'b'", 1.0),
        ("'b' <= 'a'", 0.0),
        ("'5' == 5", 1.0),
        ("'true' == 1", 1.0),
        ("1 || 0 && 0", 0.0),
        ("0 && 0 || 1", 1.0),
        ("5.0 || 0", 1.0),
        ("1 ? 2 : 3", 2),
        ("0.5 ? 'y' : 'n'", "y"),
        ("'5' ? 1 : 2", 1),
        ("'a' + 'b'", "ab"),
        ("'a' .. 1", "a1"),
        ("1.5 .. 'a'", "1.500000a"),
        ("true .. 'a'", "1a"),
        ("(1 == 1) .. 'a'", "1.000000a"),
        ("1; 2; 3", 3),
    ],
)
def test_values(text: str, value: object) -> None:
    found = value_of(text)
    assert found == value
    assert type(found) is type(value)


def test_numbers_beyond_numbers() -> None:
    assert value_of("1 / 0") == math.inf
    assert value_of("-1 / 0") == -math.inf
    assert value_of("1 / -0.0") == -math.inf
    assert math.isnan(value_of("0 / 0"))
    assert value_of("x < 1", {"x": math.nan}) == 1.0, "as in BehaviorTree.CPP, which asks for the opposite"
    assert value_of("x == x", {"x": math.inf}) == 0.0


@pytest.mark.parametrize(
    ("text", "before", "left"),
    [
        ("x := 1", {}, {"x": 1}),
        ("x := 1.5; x := 'a' == 'a'", {}, {"x": 1.0}),
        ("x := y", {"y": 2.5}, {"y": 2.5, "x": 2.5}),
        ("x = 5", {"x": 1}, {"x": 5}),
        ("x = 2.0", {"x": 1}, {"x": 2}),
        ("x = 2", {"x": 1.0}, {"x": 2.0}),
        ("x = true", {"x": 1.5}, {"x": 1.0}),
        ("x = 0", {"x": True}, {"x": False}),
        ("x = 5", {"x": True}, {"x": 5}),
        ("x = '5'", {"x": 1}, {"x": 5.0}),
        ("x = 'true'", {"x": 1}, {"x": 1.0}),
        ("x += 1", {"x": 3}, {"x": 4}),
        ("x -= 1", {"x": 3.5}, {"x": 2.5}),
        ("x *= 3; x /= 2", {"x": 2}, {"x": 3}),
        ("x += 'b'", {"x": "a"}, {"x": "ab"}),
        ("x := (y := 3)", {}, {"x": 3, "y": 3}),
        ("1 ? x := 2 : (x := 3)", {}, {"x": 2}),
        ("@x := 1", {}, {"@x": 1}),
    ],
)
def test_assignments_keep_an_entrys_kind(text: str, before: dict[str, Any], left: dict[str, Any]) -> None:
    found = after(text, **before)
    assert found == left
    assert {name: type(value) for name, value in found.items()} == {
        name: type(value) for name, value in left.items()
    }


@pytest.mark.parametrize(
    ("text", "values", "message"),
    [
        ("x", {}, "x has no value yet"),
        ("x + 1", {"x": None}, "x has no value yet"),
        ("x = 1", {}, "there is no entry x yet; to make one, write x := ..."),
        ("x += 1", {}, "there is no entry x yet; to make one, write x := ..."),
        ("a && b", {"a": 0}, "b has no value yet"),
        ("a && 1", {"a": 5}, "5 is neither true (1) nor false (0); compare it with something"),
        ("a && 1", {"a": "no"}, "&& cannot be used with text 'no' and 1"),
        ("a + 1", {"a": "1"}, "+ cannot be used with text '1' and 1"),
        ("a .. 1", {"a": 2}, ".. needs a text, not 2 and 1"),
        ("a & 1", {"a": 2.5}, "2.5 is not a whole number"),
        ("a & 1", {"a": 1e19}, "10000000000000000000 is too large for a whole number"),
        ("~a", {"a": 1e19}, "~ needs a whole number, not 1e+19"),
        ("-a", {"a": "5"}, "- needs a number, not text '5'"),
        ("a + 0", {"a": 2**53}, f"{2**53} is too large to be calculated with"),
        ("a < 1", {"a": "red"}, "text 'red' is no number"),
        ("a == b", {"a": [1], "b": 1}, "== cannot be used with a list and 1"),
        ("a ? 1 : 2", {"a": "red"}, "text 'red' is no number"),
        ("a ? 1 : 2", {"a": [1]}, "a list cannot decide"),
        (
            "x = 2.5",
            {"x": 1},
            "x = 2.5: it holds a whole number, and 2.5 is not a whole number; begin with 1.0",
        ),
        (
            "x /= 2",
            {"x": 3},
            "x /= 1.5: it holds a whole number, and 1.5 is not a whole number; begin with 3.0",
        ),
        ("x = 5", {"x": "a"}, "x = 5: it holds text 'a', and 5 is of another kind"),
        ("x = 'abc'", {"x": 1}, "x = text 'abc': text 'abc' is no number"),
        ("x = y", {"x": 1, "y": [1]}, "x = a list: it holds 1, and a list is of another kind"),
        ("x += 1", {"x": "a"}, "+= cannot be used with text 'a' and 1"),
        ("x += 'a'", {"x": 1}, "+= cannot be used with 1 and text 'a'"),
    ],
)
def test_what_fails_when_it_runs(text: str, values: dict[str, Any], message: str) -> None:
    with pytest.raises(ScriptError) as caught:
        value_of(text, values)
    assert str(caught.value) == message


def test_both_sides_of_logic_are_evaluated() -> None:
    assert after("(x := 0) && (y := 1)") == {"x": 0, "y": 1}


def test_enums_are_constants_and_texts_may_name_them() -> None:
    enums = {"RED": 1, "GREEN": 2}
    assert value_of("x == GREEN", {"x": 2}, enums) == 1.0
    assert value_of("x == RED", {"x": "RED"}, enums) == 1.0
    assert value_of("x := RED", {"RED": 7}, enums) == 1.0
    with pytest.raises(ScriptError, match=r"RED is a constant \(1\) and cannot be written"):
        value_of("RED := 2", {}, enums)


def test_values_of_python() -> None:
    assert value_of("side == 1 && side != 2", {"side": Side.LEFT}) == 1.0
    assert value_of("a + b", {"a": np.int64(2), "b": np.float32(0.5)}) == 2.5
    assert value_of("a == b", {"a": True, "b": np.int64(1)}) == 1.0
    with pytest.raises(ScriptError, match="a Side"):
        value_of("side == 1", {"side": Side.NOWHERE})
    goal = (1.0, 2.0)
    assert after("x := goal; x = goal", goal=goal)["x"] is goal


@pytest.mark.parametrize(
    ("value", "holds"),
    [(1, True), (0, False), (True, True), (2.5, True), (0.0, False), (math.nan, True)],
)
def test_what_is_true(value: object, holds: bool) -> None:
    assert truth(value) is holds


@pytest.mark.parametrize("value", [5, -1, "true", None, [1]])
def test_what_is_neither_true_nor_false(value: object) -> None:
    with pytest.raises(ScriptError):
        truth(value)


@given(NUMBERS, NUMBERS)
def test_comparisons_hold_together(left: float, right: float) -> None:
    def holds(operator: str) -> bool:
        return bool(value_of(f"l {operator} r", {"l": left, "r": right}))

    assert holds("==") is not holds("!=")
    assert holds("<") is not holds(">=")
    assert holds(">") is not holds("<=")
    if not holds("=="):
        assert holds("<") is not holds(">")


@given(NUMBERS)
def test_a_number_is_itself(value: float) -> None:
    assert value_of("x - x", {"x": value}) == 0.0
    assert value_of("-(-x)", {"x": value}) == float(value)
    assert value_of("!!x", {"x": value}) == float(bool(value))
    assert after("y := x", x=value)["y"] is value


@given(st.text(st.characters(codec="ascii", exclude_characters="'"), max_size=20), NUMBERS)
def test_texts_join(text: str, number: float) -> None:
    values = {"t": text, "n": number}
    assert value_of("t .. n", values) == text + as_text(number)
    assert value_of(f"t + '{text}'", values) == text * 2


def test_a_script_is_parsed_once() -> None:
    assert parse_script("x := 1") is parse_script("x := 1")
