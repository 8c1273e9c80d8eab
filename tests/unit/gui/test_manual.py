"""Held moves, released stops: the pad's side of it."""

from __future__ import annotations

from itertools import pairwise

import pytest
from hypothesis import given
from hypothesis import strategies as st

from target_nav.config import Config
from target_nav.gui.manual import DIRECTIONS, KEYS, PERIOD_S, ManualPad
from target_nav.state.types import STOP, Twist2D

CONFIG = Config()
SPEED = CONFIG.manual.speed_mps


@pytest.mark.parametrize("direction", DIRECTIONS)
def test_each_direction_moves_along_its_own_axis(direction: str) -> None:
    pad = ManualPad()
    pad.hold(direction)
    twist = pad.twist(CONFIG)
    signs = [(v > 0) - (v < 0) for v in (twist.vx_mps, twist.vy_mps, twist.wz_radps)]
    assert tuple(signs) == DIRECTIONS[direction]


def test_opposite_directions_cancel_and_others_add() -> None:
    pad = ManualPad()
    pad.hold("forward")
    pad.hold("left")
    assert pad.twist(CONFIG) == Twist2D(SPEED, SPEED, 0.0)
    pad.hold("back")
    assert pad.twist(CONFIG) == Twist2D(0.0, SPEED, 0.0)


def test_a_differential_base_does_not_strafe() -> None:
    pad = ManualPad()
    pad.hold("left")
    assert pad.twist(CONFIG.override({"robot.drive": "differential"})) == STOP


def test_a_hold_is_said_at_once_and_then_every_period_and_its_end_once() -> None:
    pad = ManualPad()
    said = []
    for n in range(100):
        now_s = 0.01 * n
        if n == 10:
            pad.hold("forward")
        if n == 60:
            pad.release("forward")
        twist = pad.due(now_s, CONFIG)
        if twist is not None:
            said.append((n, twist))
    assert said[0] == (10, Twist2D(SPEED))
    assert said[-1] == (60, STOP)
    assert [twist for _, twist in said].count(STOP) == 1
    gaps = [b - a for (a, _), (b, _) in pairwise(said)]
    assert max(gaps) * 0.01 <= PERIOD_S + 0.011
    assert 0.5 * CONFIG.manual.timeout_s > PERIOD_S


def test_a_key_and_a_finger_on_one_direction_are_two_holders() -> None:
    pad = ManualPad()
    pad.hold("forward", "key")
    pad.hold("forward", "pad")
    pad.release("forward", "key")
    assert pad.held == {"forward"}
    pad.release("forward", "pad")
    assert not pad.held


@given(st.lists(st.tuples(st.sampled_from(sorted(DIRECTIONS)), st.booleans())))
def test_whatever_was_held_letting_go_stops(actions: list[tuple[str, bool]]) -> None:
    pad = ManualPad()
    for n, (direction, down) in enumerate(actions):
        (pad.hold if down else pad.release)(direction)
        pad.due(0.1 * n, CONFIG)
    pad.release_all()
    assert pad.due(1e3, CONFIG) in (STOP, None)
    assert pad.due(1e3 + 1, CONFIG) is None


def test_every_key_means_a_direction() -> None:
    assert set(KEYS.values()) == set(DIRECTIONS)
