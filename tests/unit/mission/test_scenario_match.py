"""What fits an expected value, and what is said of one that does not."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from target_nav.mission.scenario_match import BadExpectation, matcher
from target_nav.state.types import MotionRequest, NavState, Outcome, OutcomeKind, Twist2D

REQUEST = MotionRequest("me", NavState.NAVIGATING, Twist2D(0.1, 0.0, -0.2), "on the way", near_target=True)


@pytest.mark.parametrize(
    ("expected", "value"),
    [
        ("none", None),
        (None, None),
        (True, True),
        (True, np.True_),
        (3, 3),
        (3, 3.0),
        (0.1, np.float64(0.1)),
        ("exactly this", "exactly this"),
        ("target lost*", "target lost: no track"),
        ("?.5 s", "0.5 s"),
        ("NAVIGATING", NavState.NAVIGATING),
        ("FAILED", OutcomeKind.FAILED),
        ({"above": 0.0}, 1e-9),
        ({"above": 1, "below": 2}, 1.5),
        ({"near": 0.29, "tolerance": 0.02}, 0.30),
        ({"near": 0.29}, 0.2999),
        ([1, "a*"], (1, "abc")),
        ([], ()),
        ({"state": "NAVIGATING", "twist": {"vx_mps": {"above": 0.05}}}, REQUEST),
        ({"near_target": True}, REQUEST),
        ({"a": 1}, {"a": 1, "b": 2}),
    ],
)
def test_fits(expected: Any, value: Any) -> None:
    assert matcher(expected).mismatch(value) == ""


@pytest.mark.parametrize(
    ("expected", "value", "why"),
    [
        ("none", 3, "is 3, not none"),
        (True, 1, "is 1, not true"),
        (1, True, "is True, not 1"),
        (0, None, "is None, not 0"),
        ("a*", "b", "is b, not 'a*'"),
        ("a", 3, "is 3, not 'a'"),
        ("IDLE", NavState.ARRIVED, "is ARRIVED, not IDLE"),
        ({"above": 1}, 1, "is 1, not above 1"),
        ({"below": 1}, 1.0, "is 1, not below 1"),
        ({"above": 0}, math.nan, "is nan, not above 0"),
        ({"near": 1}, math.nan, "is nan, not 1 +- 0.01"),
        ({"above": 0}, True, "is True, not a number"),
        ({"near": 0.29, "tolerance": 0.02}, 0.32, "is 0.32, not 0.29 +- 0.02"),
        ([1, 2], (1, 3), "[1] is 3, not 2"),
        ([1], (1, 2), "is [1, 2], not 1 items"),
        ({"twist": {"vx_mps": {"below": 0.05}}}, REQUEST, "twist vx_mps is 0.1, not below 0.05"),
        ({"speed": 1}, REQUEST.twist, "is Twist2D(vx_mps=0.1, vy_mps=0, wz_radps=-0.2), which has no speed"),
        ({"a": 1}, {}, "is {}, which has no a"),
    ],
)
def test_does_not_fit_and_says_why(expected: Any, value: Any, why: str) -> None:
    assert matcher(expected).mismatch(value) == why


@pytest.mark.parametrize(
    ("expected", "why"),
    [
        ({"above": "x"}, "above is 'x'"),
        ({"above": 1, "over": 2}, "'over' beside a range"),
        ({"tolerance": 1}, "tolerance without near"),
        ({"near": True}, "near is True"),
        ([{"below": math.nan}], "below is nan"),
        ({"twist": {"above": None}}, "above is None"),
    ],
)
def test_what_cannot_be_meant_is_refused(expected: Any, why: str) -> None:
    with pytest.raises(BadExpectation, match=why):
        matcher(expected)


@given(st.floats(allow_nan=False), st.floats(allow_nan=False))
def test_above_and_below_part_all_numbers(limit: float, value: float) -> None:
    above, below = (
        matcher({"above": limit}).mismatch(value) == "",
        matcher({"below": limit}).mismatch(value) == "",
    )
    assert (above, below) == (value > limit, value < limit)


def test_an_outcome_is_described_by_its_fields() -> None:
    outcome = Outcome(OutcomeKind.FAILED, "not found after 3 s")
    assert matcher({"kind": "FAILED", "reason": "not found*"}).mismatch(outcome) == ""
    assert str(matcher({"kind": "FAILED", "reason": "x"})) == "{kind: 'FAILED', reason: 'x'}"
