"""What the text of an attribute means."""

from __future__ import annotations

import math
from enum import Enum
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from target_nav.mission.values import BadValue, accepts, from_blackboard, key_in, to_literal, unit_of
from target_nav.state.types import Pose2D


class Side(Enum):
    LEFT = 1
    RIGHT = 2


@pytest.mark.parametrize(
    ("text", "data_type", "value"),
    [
        ("true", bool, True),
        ("False", bool, False),
        ("0", bool, False),
        ("-12", int, -12),
        (" 7 ", int, 7),
        ("0.5", float, 0.5),
        (".5", float, 0.5),
        ("-2.", float, -2.0),
        ("1e-3", float, 0.001),
        ("3", float, 3.0),
        (" as it is ", str, " as it is "),
        ("", str, ""),
        ("LEFT", Side, Side.LEFT),
        ("4", float | None, 4.0),
        ("x", int | str, "x"),
        ("x", object, "x"),
    ],
)
def test_literals(text: str, data_type: Any, value: object) -> None:
    converted = to_literal(text, "port", data_type, None)
    assert converted == value
    assert type(converted) is type(value)


@pytest.mark.parametrize(
    ("text", "data_type", "message"),
    [
        ("yes", bool, "it must be true or false, or a {key}"),
        ("1.0", int, "it must be a whole number, or a {key}"),
        ("1_000", int, "it must be a whole number, or a {key}"),
        ("9" * 400, int, "it must be a whole number, or a {key}"),
        ("١", int, "it must be a whole number, or a {key}"),
        ("inf", float, "it must be a finite number, or a {key}"),
        ("1e400", float, "it must be a finite number, or a {key}"),
        ("1,5", float, "it must be a finite number, or a {key}"),
        ("", float, "it must be a finite number, or a {key}"),
        ("UP", Side, "it must be LEFT or RIGHT, or a {key}"),
        ("x", int | None, "it must be a whole number, or a {key}"),
        ("1;2;3", Pose2D, "a Pose2D cannot be written as text; give a {key} that somebody writes"),
    ],
)
def test_what_is_no_literal(text: str, data_type: Any, message: str) -> None:
    with pytest.raises(BadValue) as caught:
        to_literal(text, "port", data_type, None)
    assert str(caught.value) == message


def test_limits_are_inclusive_and_have_the_unit_of_the_ports_name() -> None:
    limits = (0.02, 5.0)
    assert to_literal("0.02", "speed_mps", float, limits) == 0.02
    assert to_literal("5", "speed_mps", float, limits) == 5.0
    for text in ("0.0199", "5.001", "-1"):
        with pytest.raises(BadValue, match=r"^it must lie in 0.02 ... 5 m/s$"):
            to_literal(text, "speed_mps", float, limits)


@pytest.mark.parametrize(
    ("port", "unit"),
    [("range_m", "m"), ("yaw_rate_radps", "rad/s"), ("msec", "ms"), ("delay_msec", "ms"), ("name", "")],
)
def test_units(port: str, unit: str) -> None:
    assert unit_of(port) == unit


@given(st.floats(allow_nan=False, allow_infinity=False))
def test_every_finite_number_can_be_written(value: float) -> None:
    assert to_literal(repr(value), "port", float, None) == value


@given(st.text(max_size=20))
def test_any_text_is_a_literal_or_a_bad_value(text: str) -> None:
    for data_type in (bool, int, float):
        try:
            value = to_literal(text, "port", data_type, None)
        except BadValue:
            continue
        assert type(value) is data_type
        assert math.isfinite(value)


@pytest.mark.parametrize(
    ("text", "key"),
    [
        ("{goal}", "goal"),
        (" {goal} ", "goal"),
        ("{=}", "port"),
        ("=", "port"),
        ("{@goal}", "@goal"),
        ("{clock/now_s}", "clock/now_s"),
        ("{_private}", "_private"),
        ("goal", None),
        ("", None),
        ("go to {goal} now", None),
    ],
)
def test_references(text: str, key: str | None) -> None:
    assert key_in(text, "port") == key


@pytest.mark.parametrize(
    "text", ["{", "}", "{goal", "goal}", "{}", "{ }", "{a b}", "{a.b}", "{/a}", "{a//b}", "{@@a}", "{{a}}"]
)
def test_what_looks_like_a_reference_but_is_none(text: str) -> None:
    with pytest.raises(BadValue):
        key_in(text, "port")


def test_built_ins_take_text_and_whole_numbers_from_the_blackboard() -> None:
    assert from_blackboard("12", int) == 12
    assert from_blackboard(3, float) == 3.0
    assert from_blackboard("true", bool) is True
    for value, data_type in ((True, int), (1, bool), (1.5, int), ("x", int), (None, int), (math, float)):
        with pytest.raises(BadValue):
            from_blackboard(value, data_type)


def test_which_types_a_reader_takes() -> None:
    assert accepts(float, float)
    assert accepts(Any, float)
    assert accepts(float, object)
    assert not accepts(float, int)
    assert not accepts(int, bool)
    assert not accepts(str, float)
