"""Legs driven by odometry, and the scales that follow from them."""

from __future__ import annotations

import itertools
import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from target_nav.config import Config, RobotConfig
from target_nav.errors import ConfigError
from target_nav.nav.odometry import OdometryScale, arc
from target_nav.nav.odometry_calibration import (
    Axis,
    Leg,
    LegDriver,
    LegPose,
    Measured,
    Unwrapped,
    calibrated,
    square,
)
from target_nav.state.types import Pose2D, Twist2D
from target_nav.utils.frames import compose

ROBOT = Config().robot
ORIGIN = LegPose(0.0, 0.0, 0.0)
DT_S = 0.05


def driven(leg: Leg, robot: RobotConfig = ROBOT, heading_rad: float = 0.0) -> tuple[LegPose, list[Twist2D]]:
    """A leg on wheels that do at once what they are told."""
    pose, twists = Pose2D(), []
    follower, driver = Unwrapped(pose), LegDriver(leg, robot, ORIGIN, heading_rad, 0.0)
    while (twist := driver.twist(follower.pose, DT_S * len(twists))) is not None:
        twists.append(twist)
        pose = compose(pose, arc(twist, DT_S))
        follower.follow(pose)
        assert DT_S * len(twists) < driver.limit_s
    return follower.pose, twists


@pytest.mark.parametrize(
    ("leg", "end"),
    [
        (Leg(Axis.FORWARD, 1.0, 0.15), (1.0, 0.0, 0.0)),
        (Leg(Axis.FORWARD, -0.5, 0.15), (-0.5, 0.0, 0.0)),
        (Leg(Axis.LEFT, 0.7, 0.15), (0.0, 0.7, 0.0)),
        (Leg(Axis.LEFT, -0.7, 0.15), (0.0, -0.7, 0.0)),
        (Leg(Axis.TURN, 6.0 * math.pi, 0.5), (0.0, 0.0, 6.0 * math.pi)),
        (Leg(Axis.TURN, -0.5 * math.pi, 0.5), (0.0, 0.0, -0.5 * math.pi)),
    ],
)
def test_a_leg_ends_where_it_was_meant_to(leg: Leg, end: tuple[float, float, float]) -> None:
    pose, _ = driven(leg)
    assert (pose.x_m, pose.y_m, pose.yaw_rad) == pytest.approx(end, abs=0.03)


@given(
    st.sampled_from(Axis),
    st.floats(0.05, 5.0),
    st.sampled_from([1.0, -1.0]),
    st.floats(0.05, 2.0),
)
def test_no_leg_is_faster_than_asked_or_than_the_robot(
    axis: Axis, amount: float, sign: float, speed: float
) -> None:
    _, twists = driven(Leg(axis, sign * amount, speed))
    assert max(abs(t.vx_mps) for t in twists) <= min(speed, ROBOT.max_speed_mps)
    assert max(abs(t.vy_mps) for t in twists) <= min(speed, ROBOT.max_lateral_speed_mps)
    if axis is Axis.TURN:
        assert max(abs(t.wz_radps) for t in twists) <= min(speed, ROBOT.max_yaw_rate_radps)


def test_speed_grows_and_falls_gently() -> None:
    _, twists = driven(Leg(Axis.FORWARD, 2.0, 0.3))
    speeds = [twist.vx_mps for twist in twists]
    assert speeds[0] == ROBOT.min_speed_mps
    assert max(abs(b - a) for a, b in itertools.pairwise(speeds)) < 0.03
    assert speeds[-1] < 0.1


def test_a_leg_turns_back_to_its_heading() -> None:
    pose, twists = driven(Leg(Axis.FORWARD, 2.0, 0.15), heading_rad=0.1)
    assert twists[0].wz_radps > 0.0
    assert pose.yaw_rad == pytest.approx(0.1, abs=0.001)


def test_corners_make_up_for_each_other() -> None:
    pose, _ = driven(Leg(Axis.TURN, 0.5 * math.pi, 0.5), heading_rad=-0.02)
    assert pose.yaw_rad == pytest.approx(0.5 * math.pi - 0.02, abs=0.02)


def test_a_square_has_four_sides_and_one_whole_turn() -> None:
    legs = square(2.0, 0.15, 0.5)
    assert sum(leg.amount for leg in legs if leg.axis is Axis.TURN) == pytest.approx(2.0 * math.pi)
    assert [leg.amount for leg in legs if leg.axis is Axis.FORWARD] == [2.0] * 4


def test_the_scale_is_what_one_reported_unit_is_worth() -> None:
    scale = calibrated(
        Measured(2.0, 1.98), Measured(1.0, 0.93), Measured(6.0, 6.3).plus(Measured(6.0, 5.7)), OdometryScale()
    )
    assert (scale.forward, scale.lateral, scale.yaw) == pytest.approx((0.99, 0.93, 1.0))


def test_what_was_not_measured_stays() -> None:
    before = OdometryScale(1.1, 0.9, 1.05)
    assert calibrated(None, None, None, before) == before


@pytest.mark.parametrize("true", [0.0, -2.0, 1.3, 2.9, 200.0, math.nan, math.inf])
def test_a_measurement_that_cannot_be_meant_is_refused(true: float) -> None:
    with pytest.raises(ConfigError, match="forward: measured"):
        calibrated(Measured(2.0, true), None, None, OdometryScale())


def test_wheels_that_did_not_turn_calibrate_nothing() -> None:
    with pytest.raises(ConfigError, match="both must be over 0"):
        Measured(0.0, 1.0).scale("turning")
