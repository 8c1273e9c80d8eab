"""The ramp: whatever is wanted, velocity, acceleration and jerk stay within their limits, and it gets there."""

from __future__ import annotations

import math

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from target_nav.config import Config, RobotConfig
from target_nav.nav.ramp import Ramp
from target_nav.nav.speed import within_limits
from target_nav.state.types import STOP, Twist2D
from tests.unit.nav.views import assert_mirrored

ROBOT = Config().robot
DT = 0.05
CREEP = 1.25 * ROBOT.min_speed_mps
YAW_CREEP = 1.25 * ROBOT.min_yaw_rate_radps

twists = st.builds(Twist2D, st.floats(-0.5, 0.5), st.floats(-0.5, 0.5), st.floats(-1.5, 1.5))
held = st.lists(st.tuples(twists | st.just(STOP), st.integers(1, 8)), min_size=1, max_size=8)
robots = st.builds(
    lambda accel, decel, jerk, drive: (
        Config()
        .override(
            {
                "robot.max_accel_mps2": accel,
                "robot.max_decel_mps2": decel,
                "robot.max_jerk_mps3": jerk,
                "robot.drive": drive,
            }
        )
        .robot
    ),
    st.floats(0.2, 3.0),
    st.floats(0.2, 3.0),
    st.floats(1.0, 60.0),
    st.sampled_from(["mecanum", "differential"]),
)


def drive(ramp: Ramp, wanted: Twist2D, dt_s: float = DT) -> Twist2D:
    ramp.last = ramp.smooth(wanted, dt_s)
    return ramp.last.twist


def between_rest_and_creep(one: complex, other: complex, creep: float) -> bool:
    """The motors can do no smaller step, so it counts for nothing."""
    return min(abs(one), abs(other)) == 0.0 and max(abs(one), abs(other)) <= creep + 1e-9


@settings(max_examples=150)
@given(robots, held, st.sampled_from([0.02, 0.05, 0.1]))
def test_no_command_beyond_the_limits_of_speed_acceleration_and_jerk(
    robot: RobotConfig, script: list[tuple[Twist2D, int]], dt: float
) -> None:
    ramp = Ramp(robot)
    v, w, a, turn = 0j, 0.0, 0j, 0.0
    for twist, ticks in script:
        wanted = within_limits(twist, robot)
        for _ in range(ticks):
            sent = drive(ramp, wanted, dt)
            assert within_limits(sent, robot).speed_mps == pytest.approx(sent.speed_mps, abs=1e-9)
            assert abs(sent.vy_mps) <= robot.max_lateral_speed_mps + 1e-9
            assert abs(sent.wz_radps) <= robot.max_yaw_rate_radps + 1e-9
            assert robot.drive == "mecanum" or sent.vy_mps == 0.0
            now, rate = complex(sent.vx_mps, sent.vy_mps), sent.wz_radps
            accel, yaw_accel = (now - v) / dt, (rate - w) / dt
            assert abs(accel) <= max(robot.max_accel_mps2, robot.max_decel_mps2) + 1e-6
            assert (abs(now) - abs(v)) / dt <= robot.max_accel_mps2 + 1e-6
            assert abs(yaw_accel) <= robot.max_yaw_accel_radps2 + 1e-6
            if between_rest_and_creep(now, v, CREEP):
                accel = 0j
            else:
                assert abs(accel - a) <= robot.max_jerk_mps3 * dt + 1e-6
            if between_rest_and_creep(complex(rate), complex(w), YAW_CREEP):
                yaw_accel = 0.0
            else:
                assert abs(yaw_accel - turn) <= robot.max_yaw_jerk_radps3 * dt + 1e-6
            v, w, a, turn = now, rate, accel, yaw_accel


@settings(max_examples=80)
@given(held, st.lists(st.floats(0.0, 0.2), min_size=64, max_size=64))
def test_ticks_of_any_length_keep_speed_and_acceleration(
    script: list[tuple[Twist2D, int]], lengths: list[float]
) -> None:
    ramp = Ramp(ROBOT)
    last = STOP
    times = iter(lengths)
    for twist, ticks in script:
        for _ in range(ticks):
            dt = next(times)
            sent = drive(ramp, within_limits(twist, ROBOT), dt)
            change = math.hypot(sent.vx_mps - last.vx_mps, sent.vy_mps - last.vy_mps)
            assert change <= ROBOT.max_decel_mps2 * dt + 1e-6
            assert abs(sent.wz_radps - last.wz_radps) <= ROBOT.max_yaw_accel_radps2 * dt + 1e-6
            last = sent


@settings(max_examples=60)
@given(held, twists)
def test_it_gets_where_it_is_wanted_and_stays_there(script: list[tuple[Twist2D, int]], end: Twist2D) -> None:
    ramp = Ramp(ROBOT)
    for twist, ticks in script:
        for _ in range(ticks):
            drive(ramp, within_limits(twist, ROBOT))
    wanted = within_limits(end, ROBOT)
    for _ in range(60):
        drive(ramp, wanted)
    assert drive(ramp, wanted) == drive(ramp, wanted) == wanted


@settings(max_examples=60)
@given(held)
def test_mirrored_requests_get_mirrored_velocities(script: list[tuple[Twist2D, int]]) -> None:
    left, right = Ramp(ROBOT), Ramp(ROBOT)
    for twist, ticks in script:
        wanted = within_limits(twist, ROBOT)
        flipped = Twist2D(wanted.vx_mps, -wanted.vy_mps, -wanted.wz_radps)
        for _ in range(ticks):
            assert_mirrored(drive(left, wanted), drive(right, flipped), 1e-12)


def test_up_to_speed_and_down_again_without_overshoot() -> None:
    ramp = Ramp(ROBOT)
    up = [drive(ramp, Twist2D(0.3, 0.0, 0.0)).vx_mps for _ in range(16)]
    assert up == sorted(up)
    assert up[-1] == 0.3
    down = [drive(ramp, STOP).vx_mps for _ in range(12)]
    assert down == sorted(down, reverse=True)
    assert down[-1] == 0.0


def test_from_a_creeping_speed_it_stops_in_one_tick() -> None:
    ramp = Ramp(ROBOT)
    creep = Twist2D(1.2 * ROBOT.min_speed_mps, 0.0, 0.0)
    for _ in range(10):
        drive(ramp, creep)
    assert drive(ramp, STOP) == STOP


def test_a_brisk_step_knows_no_jerk_and_leaves_no_acceleration_behind() -> None:
    ramp = Ramp(ROBOT)
    for _ in range(20):
        drive(ramp, Twist2D(0.3, 0.0, 0.0))
    ramp.last = ramp.brisk(STOP, DT)
    assert ramp.last.twist.vx_mps == pytest.approx(0.3 - ROBOT.max_decel_mps2 * DT)
    assert drive(ramp, ramp.last.twist) == ramp.last.twist
