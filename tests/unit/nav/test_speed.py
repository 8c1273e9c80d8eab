"""Speeds: braking curves, dead-band, limits, turning to a heading."""

from __future__ import annotations

import math

import pytest
from hypothesis import example, given
from hypothesis import strategies as st

from target_nav.config import Config, RobotConfig
from target_nav.nav.speed import (
    NOTHING,
    YawControl,
    braking_speed_mps,
    clearance_speed_mps,
    over_dead_band,
    within_limits,
)
from target_nav.state.types import STOP, Twist2D

ROBOT = RobotConfig()
DIFFERENTIAL = Config().override({"robot.drive": "differential"}).robot
anything = st.floats(allow_nan=True, allow_infinity=True)
velocity = st.floats(-2.0, 2.0)


@given(st.floats(0.001, 5.0), st.floats(0.05, 5.0), st.floats(0.0, 1.0))
def test_braking_from_the_braking_speed_takes_just_the_distance(
    distance: float, decel: float, reaction: float
) -> None:
    speed = braking_speed_mps(distance, decel, reaction)
    assert speed * reaction + speed**2 / (2.0 * decel) == pytest.approx(distance, rel=1e-6)


@pytest.mark.parametrize("distance", [0.0, -1.0, math.nan])
def test_without_room_there_is_no_speed(distance: float) -> None:
    assert braking_speed_mps(distance, 1.0, 0.1) == 0.0


def test_clearance_slows_down_linearly() -> None:
    def speed(clearance: float) -> float:
        return clearance_speed_mps(clearance, 0.3, 0.1, 0.05, 0.25)

    assert [speed(c) for c in (0.0, 0.05, 0.15, 0.25, 9.0)] == pytest.approx([0.1, 0.1, 0.2, 0.3, 0.3])
    assert clearance_speed_mps(0.0, 0.05, 0.1, 0.05, 0.25) == 0.05


@given(anything, anything, anything)
def test_nothing_leaves_the_limits(vx: float, vy: float, wz: float) -> None:
    for robot in (ROBOT, DIFFERENTIAL):
        kept = within_limits(Twist2D(vx, vy, wz), robot)
        assert kept.is_finite()
        assert abs(kept.vx_mps) <= robot.max_speed_mps + 1e-12
        assert abs(kept.vy_mps) <= robot.max_lateral_speed_mps + 1e-12
        assert kept.speed_mps <= robot.max_speed_mps + 1e-12
        assert abs(kept.wz_radps) <= robot.max_yaw_rate_radps
    assert within_limits(Twist2D(vx, vy, wz), DIFFERENTIAL).vy_mps == 0.0


@given(velocity, velocity)
def test_slowing_down_keeps_the_direction(vx: float, vy: float) -> None:
    kept = within_limits(Twist2D(vx, vy, 0.0), ROBOT)
    assert kept.vx_mps * vy == pytest.approx(kept.vy_mps * vx, abs=1e-9)


@given(velocity, velocity, velocity)
@example(5e-324, 0.0, 0.0)
@example(0.0, 1e-310, 5e-324)
@example(1e-200, 0.0, 0.05)
def test_a_wanted_motion_is_never_under_the_dead_band(vx: float, vy: float, wz: float) -> None:
    kept = over_dead_band(Twist2D(vx, vy, wz), ROBOT)
    assert kept.is_finite()
    if math.hypot(vx, vy) >= NOTHING:
        assert kept.speed_mps >= ROBOT.min_speed_mps - 1e-9
        assert kept.vx_mps * vx + kept.vy_mps * vy > 0.0
    elif abs(wz) >= NOTHING:
        assert kept.speed_mps == 0.0
        assert abs(kept.wz_radps) >= ROBOT.min_yaw_rate_radps
        assert math.copysign(1.0, kept.wz_radps) == math.copysign(1.0, wz)
    else:
        assert kept == STOP, "what rounding left over must not make the robot creep"


def test_zero_stays_zero() -> None:
    assert over_dead_band(STOP, ROBOT) == STOP


def test_turning_ends_in_the_rest_zone_and_begins_again_well_outside_it() -> None:
    yaw = YawControl(ROBOT, rest_rad=0.02)
    assert yaw.rate_radps(0.05) == 0.0, "a small error at rest is left alone"
    assert yaw.rate_radps(0.07) == pytest.approx(0.14)
    assert yaw.rate_radps(0.03) == ROBOT.min_yaw_rate_radps, "once it turns, it turns on, over the dead-band"
    assert yaw.rate_radps(0.015) == 0.0
    assert yaw.rate_radps(0.05) == 0.0


def test_what_will_still_turn_is_taken_off() -> None:
    yaw = YawControl(ROBOT)
    assert yaw.rate_radps(1.0) == pytest.approx(0.8)
    assert yaw.rate_radps(0.05, measured_radps=0.8) == 0.0, "it coasts that far by itself"


@given(st.floats(-3.1, 3.1))
def test_turning_is_the_same_to_both_sides(error: float) -> None:
    assert YawControl(ROBOT).rate_radps(error) == -YawControl(ROBOT).rate_radps(-error)
