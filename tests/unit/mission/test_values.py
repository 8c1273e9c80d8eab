"""What the text of an attribute means."""

from __future__ import annotations

import math
from enum import Enum
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from target_nav.mission.port_types import accepts, can_be_written, unit_of
from target_nav.mission.values import BadValue, from_blackboard, key_in, to_literal, to_port
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
        ("1;2.5;", list[float], [1.0, 2.5]),
        ("a;;b", list[str], ["a", "", "b"]),
        ("", list[int], []),
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
        ("1;x", list[int], "it must be a list with ; between, each a whole number, or a {key}"),
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
    assert from_blackboard(2.0, int) == 2
    items = [1, 2]
    assert from_blackboard(items, list[int]) is items
    for value, data_type in ((True, int), (1, bool), (1.5, int), ("x", int), (None, int), (math, float)):
        with pytest.raises(BadValue):
            from_blackboard(value, data_type)


def test_which_types_a_reader_takes() -> None:
    assert accepts(float, float)
    assert accepts(Any, float)
    assert accepts(float, object)
    assert accepts(list[int], list[int])
    assert accepts(list[int], list)
    assert not accepts(list[int], float)
    assert not accepts(float, list[float])
    assert not accepts(float, int)
    assert not accepts(int, bool)
    assert not accepts(str, float)


@pytest.mark.parametrize(
    ("value", "data_type", "becomes"),
    [
        (2, float, 2.0),
        (2.0, int, 2),
        (1, bool, True),
        (0.0, bool, False),
        (True, int, 1),
        (True, float, 1.0),
        (2, str, "2"),
        (2.5, str, "2.500000"),
        ("2.5", float, 2.5),
        ("true", bool, True),
        ("1;2", list[int], [1, 2]),
        ("LEFT", Side, Side.LEFT),
        (2.0, Side, Side.RIGHT),
        (Side.LEFT, Side, Side.LEFT),
        (2, float | None, 2.0),
        (None, float | None, None),
        ("x", int | str, "x"),
        ([1], list[int], [1]),
        (Pose2D(), Pose2D, Pose2D()),
        (2.5, object, 2.5),
    ],
)
def test_what_is_written_to_a_port_of_a_type(value: object, data_type: Any, becomes: object) -> None:
    found = to_port(value, data_type)
    assert found == becomes
    assert type(found) is type(becomes)


@pytest.mark.parametrize(
    ("value", "data_type", "message"),
    [
        (2.5, int, "it must be a whole number"),
        (2, bool, "it must be true or false"),
        (math.nan, float, "it must be a finite number"),
        (math.inf, float, "it must be a finite number"),
        ("fast", float, "it must be a finite number"),
        (3, Side, "it must be LEFT or RIGHT"),
        ([1], str, "a list cannot be made text"),
        ((1,), list[int], "it must be a list with ; between, each a whole number"),
        (None, float, "it must be a finite number"),
        ("x", int | None, "it must be a whole number"),
        (1, Pose2D, "it must be Pose2D"),
        ("x", Pose2D, "it must be Pose2D"),
    ],
)
def test_what_cannot_be_written_to_a_port_of_a_type(value: object, data_type: Any, message: str) -> None:
    with pytest.raises(BadValue) as caught:
        to_port(value, data_type)
    assert str(caught.value) == message


@given(
    st.one_of(st.integers(-(2**53), 2**53), st.floats(allow_nan=False, allow_infinity=False), st.booleans())
)
def test_a_number_that_becomes_another_type_is_the_same_number(value: float) -> None:
    for data_type in (bool, int, float):
        try:
            found = to_port(value, data_type)
        except BadValue:
            continue
        assert type(found) is data_type
        assert found == value


def test_which_types_a_text_can_mean() -> None:
    assert all(
        map(can_be_written, (bool, int, float, str, Side, object, Any, list[int], float | None, Pose2D | str))
    )
    assert not any(map(can_be_written, (Pose2D, list, list[Pose2D], dict[str, int], Pose2D | None)))
