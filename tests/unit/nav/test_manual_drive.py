"""The deadman: a velocity lives exactly as long as somebody says that it is held."""

from __future__ import annotations

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from target_nav.config import ManualConfig
from target_nav.nav.manual_drive import ManualDrive, manual_text, manual_twist
from target_nav.state.types import Twist2D

LIMIT_S = ManualConfig().timeout_s
speeds = st.floats(-2.0, 2.0)


@given(speeds, speeds, speeds)
def test_a_velocity_comes_back_from_its_text(vx: float, vy: float, wz: float) -> None:
    back = manual_twist(manual_text(Twist2D(vx, vy, wz)))
    assert back is not None
    assert [back.vx_mps, back.vy_mps, back.wz_radps] == pytest.approx([vx, vy, wz], rel=1e-3, abs=1e-9)


@given(st.text())
def test_any_other_text_is_no_velocity_and_no_error(text: str) -> None:
    twist = manual_twist(text)
    assert twist is None or twist.is_finite()


@given(st.floats(0.0, 10.0), st.floats(0.0, 1000.0))
def test_it_asks_for_motion_within_the_limit_and_never_after(age_s: float, stamp_s: float) -> None:
    drive = ManualDrive(ManualConfig())
    drive.hold(stamp_s, Twist2D(0.1))
    asked = drive.request(stamp_s + age_s)
    really_s = (stamp_s + age_s) - stamp_s
    assert (asked is not None) == (really_s <= LIMIT_S)


@pytest.mark.parametrize("stamp_s", [math.nan, math.inf, -math.inf, 1e6])
def test_a_stamp_of_another_clock_moves_nothing(stamp_s: float) -> None:
    drive = ManualDrive(ManualConfig())
    drive.hold(stamp_s, Twist2D(0.1))
    assert drive.request(10.0) is None


def test_released_is_released() -> None:
    drive = ManualDrive(ManualConfig())
    drive.hold(10.0, Twist2D(0.1))
    drive.release()
    assert drive.request(10.0) is None


@pytest.mark.parametrize("lets_go", ["with a zero", "by silence"])
def test_after_a_stop_a_key_that_is_still_held_moves_nothing_until_it_was_let_go(lets_go: str) -> None:
    drive = ManualDrive(ManualConfig())
    drive.hold(10.0, Twist2D(0.1))
    drive.stop()
    for n in range(1, 100):
        drive.hold(10.0 + 0.05 * n, Twist2D(0.1))
        assert drive.request(10.0 + 0.05 * n) is None
    again_s = 15.0
    if lets_go == "with a zero":
        drive.hold(14.96, Twist2D())
    else:
        again_s = 14.95 + LIMIT_S + 0.01
    drive.hold(again_s, Twist2D(0.1))
    assert drive.request(again_s) is not None


def test_a_key_pressed_some_time_after_a_stop_moves_at_once() -> None:
    drive = ManualDrive(ManualConfig())
    drive.stop()
    drive.hold(10.0, Twist2D(0.1))
    assert drive.request(10.0) is not None
