"""Wheel speeds and body speeds belong to each other."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from target_nav.config import RobotConfig
from target_nav.sim.wheels import Base

speed = st.floats(-2.0, 2.0)
MECANUM = Base.of(RobotConfig())
DIFFERENTIAL = Base.of(RobotConfig(drive="differential"))


@given(speed, speed, speed)
def test_forward_kinematics_undoes_inverse_kinematics(vx, vy, wz):
    assert MECANUM.body_speeds(MECANUM.wheel_speeds(vx, vy, wz)) == pytest.approx((vx, vy, wz), abs=1e-9)


@given(speed, speed, speed)
def test_a_differential_base_does_the_same_but_never_strafes(vx, vy, wz):
    assert DIFFERENTIAL.body_speeds(DIFFERENTIAL.wheel_speeds(vx, vy, wz)) == pytest.approx(
        (vx, 0.0, wz), abs=1e-9
    )


@pytest.mark.parametrize(
    ("body", "signs"),
    [((1, 0, 0), (1, 1, 1, 1)), ((0, 1, 0), (-1, 1, 1, -1)), ((0, 0, 1), (-1, 1, -1, 1))],
)
def test_wheels_turn_the_way_mecanum_wheels_do(body, signs):
    """Front left, front right, rear left, rear right; forward, left, counter-clockwise."""
    assert tuple((w > 0) - (w < 0) for w in MECANUM.wheel_speeds(*body)) == signs
