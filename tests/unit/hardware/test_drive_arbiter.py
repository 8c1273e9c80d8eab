"""Who drives: the latest velocity, a position command, or nobody."""

from __future__ import annotations

import math
from itertools import pairwise

import pytest
from hypothesis import given
from hypothesis import strategies as st

from target_nav.config import Config
from target_nav.errors import DeviceError
from target_nav.hardware.drive_arbiter import NOTHING, DriveArbiter, DriveMode, within_limits
from target_nav.state.types import STOP, Twist2D

CONFIG = Config()
FORWARD = Twist2D(0.2, 0.0, 0.3)
speeds = st.floats(-1000.0, 1000.0)


def make() -> DriveArbiter:
    return DriveArbiter(CONFIG.robot, CONFIG.serial)


def test_nothing_is_sent_before_anybody_asked() -> None:
    arbiter = make()
    assert [arbiter.refresh(0.05 * tick) for tick in range(100)] == [NOTHING] * 100


def test_a_velocity_is_sent_at_once_and_again_until_the_next() -> None:
    arbiter = make()
    assert arbiter.velocity(0.0, FORWARD) == b"VEL,200,0,300\n"
    assert arbiter.refresh(0.02) == NOTHING
    assert arbiter.refresh(0.07) == b"VEL,200,0,300\n"
    assert arbiter.velocity(0.08, Twist2D(0.1, 0.0, 0.0)) == b"VEL,100,0,0\n"
    assert arbiter.refresh(0.13) == b"VEL,100,0,0\n"


def test_the_firmware_hears_of_a_velocity_within_its_watchdog() -> None:
    arbiter = make()
    arbiter.velocity(0.0, FORWARD)
    sent = [0.0]
    for tick in range(1, 10):
        now_s = 0.049 * tick
        if arbiter.refresh(now_s):
            sent.append(now_s)
    assert max(b - a for a, b in pairwise(sent)) < CONFIG.serial.vel_watchdog_s / 2


def test_stop_is_sent_once_when_velocities_cease() -> None:
    arbiter = make()
    arbiter.velocity(0.0, FORWARD)
    lines = [arbiter.refresh(0.05 * tick) for tick in range(1, 40)]
    assert lines.count(b"STOP\n") == 1
    assert lines[:3] == [b"VEL,200,0,300\n"] * 3
    # At 0.25 and 0.55 s: the first turns of the timer after 0.2 and 0.5 s.
    assert lines[4:10] == [b"VEL,0,0,0\n"] * 6
    assert lines.index(b"STOP\n") == 10
    assert set(lines[11:]) == {NOTHING}
    assert arbiter.stale == 1
    assert arbiter.timeouts == 1


def test_a_velocity_that_comes_back_in_time_goes_on() -> None:
    arbiter = make()
    arbiter.velocity(0.0, FORWARD)
    assert arbiter.refresh(0.21) == b"VEL,0,0,0\n"
    assert arbiter.velocity(0.22, FORWARD) == b"VEL,200,0,300\n"
    assert arbiter.refresh(0.27) == b"VEL,200,0,300\n"


def test_standing_still_is_not_ended_before_its_time() -> None:
    arbiter = make()
    arbiter.velocity(0.0, STOP)
    assert [arbiter.refresh(0.05 * tick) for tick in range(1, 10)] == [b"VEL,0,0,0\n"] * 9
    assert arbiter.stale == 0


def test_velocities_start_again_after_a_timeout() -> None:
    arbiter = make()
    arbiter.velocity(0.0, FORWARD)
    assert arbiter.refresh(1.0) == b"STOP\n"
    assert arbiter.velocity(1.1, FORWARD) == b"VEL,200,0,300\n"


@pytest.mark.parametrize("bad", [math.nan, math.inf, -math.inf])
def test_a_velocity_that_is_not_finite_stops(bad: float) -> None:
    arbiter = make()
    arbiter.velocity(0.0, FORWARD)
    assert arbiter.velocity(0.05, Twist2D(0.1, bad, 0.0)) == b"STOP\n"
    assert arbiter.refresh(0.1) == NOTHING


def test_a_position_command_takes_over_from_velocities() -> None:
    arbiter = make()
    arbiter.velocity(0.0, FORWARD)
    assert arbiter.command(0.1, "FWD,100,1719\n") == b"FWD,100,1719\n"
    assert arbiter.mode is DriveMode.POSITION
    assert [arbiter.refresh(0.1 + 0.05 * tick) for tick in range(40)] == [NOTHING] * 40


def test_zero_velocities_leave_a_position_command_alone() -> None:
    arbiter = make()
    arbiter.command(0.0, "FWD,100,1719")
    assert arbiter.velocity(1.0, STOP) == NOTHING
    assert arbiter.mode is DriveMode.POSITION


def test_any_other_velocity_takes_over_from_a_position_command() -> None:
    arbiter = make()
    arbiter.command(0.0, "FWD,100,1719")
    assert arbiter.velocity(1.0, FORWARD) == b"VEL,200,0,300\n"


def test_zero_velocities_count_again_when_the_firmware_must_have_ended_the_move() -> None:
    arbiter = make()
    arbiter.command(0.0, "FWD,100,1719")
    assert arbiter.velocity(30.0, STOP) == b"VEL,0,0,0\n"


def test_stop_ends_both_modes() -> None:
    arbiter = make()
    arbiter.velocity(0.0, FORWARD)
    assert arbiter.command(0.1, "STOP") == b"STOP\n"
    assert arbiter.refresh(0.2) == NOTHING
    arbiter.command(0.3, "FWD,100,1719")
    arbiter.command(0.4, "STOP")
    assert arbiter.velocity(0.5, STOP) == b"VEL,0,0,0\n"


def test_a_question_passes_and_leaves_the_driving_alone() -> None:
    arbiter = make()
    arbiter.velocity(0.0, FORWARD)
    assert arbiter.command(0.02, "VERSION") == b"VERSION\n"
    assert arbiter.refresh(0.07) == b"VEL,200,0,300\n"
    arbiter.command(0.1, "FWD,100,1719")
    arbiter.command(0.2, "VERSION")
    assert arbiter.velocity(0.3, STOP) == NOTHING


@pytest.mark.parametrize("text", ["", "HOP", "FWD,1", "STOP\nVEL,1,1,1", "é"])
def test_what_the_firmware_does_not_know_is_refused(text: str) -> None:
    with pytest.raises(DeviceError, match="not a command"):
        make().command(0.0, text)


def test_a_velocity_cannot_go_round_the_limits() -> None:
    with pytest.raises(DeviceError, match="/cmd_vel"):
        make().command(0.0, "VEL,900,0,0")


@given(speeds, speeds, speeds)
def test_no_component_exceeds_its_limit_and_the_direction_stays(vx: float, vy: float, wz: float) -> None:
    robot = CONFIG.robot
    asked = Twist2D(vx, vy, wz)
    got = within_limits(asked, robot)
    assert abs(got.vx_mps) <= robot.max_speed_mps * (1 + 1e-9)
    assert abs(got.vy_mps) <= robot.max_lateral_speed_mps * (1 + 1e-9)
    assert abs(got.wz_radps) <= robot.max_yaw_rate_radps * (1 + 1e-9)
    for a, b in ((vx, got.vx_mps), (vy, got.vy_mps), (wz, got.wz_radps)):
        assert a * b >= 0.0
        assert abs(b) <= abs(a)
    assert math.isclose(vx * got.vy_mps, vy * got.vx_mps, rel_tol=1e-9, abs_tol=1e-200)
    assert math.isclose(vx * got.wz_radps, wz * got.vx_mps, rel_tol=1e-9, abs_tol=1e-200)


@given(st.floats(-0.25, 0.25), st.floats(-0.25, 0.25), st.floats(-1.0, 1.0))
def test_a_velocity_within_limits_is_left_alone(vx: float, vy: float, wz: float) -> None:
    assert within_limits(Twist2D(vx, vy, wz), CONFIG.robot) == Twist2D(vx, vy, wz)


def test_a_differential_drive_does_not_strafe() -> None:
    robot = CONFIG.override({"robot.drive": "differential"}).robot
    assert within_limits(Twist2D(0.1, 5.0, 0.2), robot) == Twist2D(0.1, 0.0, 0.2)
