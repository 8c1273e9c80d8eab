"""Integration of body velocities: exact on arcs, no jumps, gaps bounded and told."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from target_nav.nav.odometry import OdometryIntegrator, OdometryScale, arc
from target_nav.state.types import Pose2D, Twist2D
from target_nav.utils.frames import compose

speed = st.floats(-1.0, 1.0)
turn = st.floats(-3.0, 3.0)
step_s = st.floats(0.0, 0.2)


def drive(twist: Twist2D, seconds: float, rate_hz: float = 20.0) -> OdometryIntegrator:
    odometry = OdometryIntegrator()
    for tick in range(round(seconds * rate_hz) + 1):
        odometry.add(100.0 + tick / rate_hz, twist)
    return odometry


def test_straight_on() -> None:
    pose = drive(Twist2D(0.2, 0.0, 0.0), 5.0).pose_in_odom
    assert pose.x_m == pytest.approx(1.0)
    assert pose.y_m == pytest.approx(0.0)
    assert pose.yaw_rad == 0.0


def test_a_strafe_goes_to_the_left() -> None:
    assert drive(Twist2D(0.0, 0.1, 0.0), 2.0).pose_in_odom.y_m == pytest.approx(0.2)


def test_a_whole_circle_ends_where_it_began() -> None:
    odometry = OdometryIntegrator()
    for tick in range(41):
        odometry.add(tick * 0.05, Twist2D(0.3, 0.1, math.pi))
    pose = odometry.pose_in_odom
    assert (pose.x_m, pose.y_m) == (pytest.approx(0.0, abs=1e-12), pytest.approx(0.0, abs=1e-12))


def test_half_a_circle_is_a_diameter_to_the_side() -> None:
    pose = arc(Twist2D(math.pi, 0.0, math.pi), 1.0)
    assert (pose.x_m, pose.y_m) == (pytest.approx(0.0, abs=1e-12), pytest.approx(2.0))


@given(speed, speed, turn, step_s, step_s)
def test_an_arc_in_two_parts_is_the_arc(
    vx: float, vy: float, wz: float, first_s: float, then_s: float
) -> None:
    twist = Twist2D(vx, vy, wz)
    whole = arc(twist, first_s + then_s)
    parts = compose(arc(twist, first_s), arc(twist, then_s))
    assert parts.x_m == pytest.approx(whole.x_m, abs=1e-12)
    assert parts.y_m == pytest.approx(whole.y_m, abs=1e-12)


@given(speed, speed, st.floats(-2e-3, 2e-3))
def test_the_series_and_the_formula_meet(vx: float, vy: float, wz: float) -> None:
    exact = arc(Twist2D(vx, vy, wz), 0.1)
    steps = Pose2D()
    for _ in range(64):
        steps = compose(steps, Pose2D(vx * 0.1 / 64, vy * 0.1 / 64, wz * 0.1 / 64))
    assert exact.x_m == pytest.approx(steps.x_m, abs=1e-6)
    assert exact.y_m == pytest.approx(steps.y_m, abs=1e-6)


@given(speed, speed, turn)
def test_driving_back_the_same_way_returns(vx: float, vy: float, wz: float) -> None:
    back = compose(arc(Twist2D(vx, vy, wz), 0.2), arc(Twist2D(-vx, -vy, -wz), 0.2))
    assert (back.x_m, back.y_m, back.yaw_rad) == pytest.approx((0.0, 0.0, 0.0), abs=1e-12)


@given(speed, speed, turn)
def test_a_mirrored_drive_gives_the_mirrored_pose(vx: float, vy: float, wz: float) -> None:
    left, right = arc(Twist2D(vx, vy, wz), 0.2), arc(Twist2D(vx, -vy, -wz), 0.2)
    assert (left.x_m, left.y_m, left.yaw_rad) == pytest.approx((right.x_m, -right.y_m, -right.yaw_rad))


@given(st.lists(st.tuples(st.floats(0.0, 5.0), speed, speed, turn), min_size=2))
def test_no_message_makes_the_pose_jump(messages: list[tuple[float, float, float, float]]) -> None:
    odometry = OdometryIntegrator()
    now_s = 0.0
    for dt_s, vx, vy, wz in messages:
        before = odometry.pose_in_odom
        now_s += dt_s
        odometry.add(now_s, Twist2D(vx, vy, wz))
        after = odometry.pose_in_odom
        assert math.hypot(after.x_m - before.x_m, after.y_m - before.y_m) <= math.hypot(vx, vy) * 0.25 + 1e-9
        assert -math.pi <= after.yaw_rad <= math.pi


def test_the_first_message_only_sets_the_clock() -> None:
    odometry = OdometryIntegrator()
    first = odometry.add(1000.0, Twist2D(0.3, 0.0, 0.0))
    assert first is not None
    assert first.pose_in_odom == Pose2D()
    assert not odometry.in_gap


def test_a_gap_is_integrated_up_to_its_bound_and_told() -> None:
    odometry = OdometryIntegrator(max_gap_s=0.25)
    odometry.add(0.0, Twist2D(0.2, 0.0, 0.0))
    odometry.add(0.05, Twist2D(0.2, 0.0, 0.0))
    assert not odometry.in_gap
    after = odometry.add(10.05, Twist2D(0.2, 0.0, 0.0))
    assert after is not None
    assert odometry.in_gap
    assert odometry.gaps == 1
    assert after.pose_in_odom.x_m == pytest.approx(0.01 + 0.05)
    odometry.add(10.1, Twist2D(0.2, 0.0, 0.0))
    assert not odometry.in_gap
    assert odometry.pose_in_odom.x_m == pytest.approx(0.07)


@pytest.mark.parametrize(
    ("stamp_s", "twist"),
    [
        (1.1, Twist2D(math.nan, 0.0, 0.0)),
        (1.1, Twist2D(0.0, math.inf, 0.0)),
        (1.1, Twist2D(0.0, 0.0, -math.inf)),
        (math.nan, Twist2D(0.1, 0.0, 0.0)),
        (0.9, Twist2D(0.1, 0.0, 0.0)),
    ],
)
def test_what_cannot_be_is_ignored_and_counted(stamp_s: float, twist: Twist2D) -> None:
    odometry = OdometryIntegrator()
    odometry.add(1.0, Twist2D(0.1, 0.0, 0.0))
    assert odometry.add(stamp_s, twist) is None
    assert odometry.rejected == 1
    assert odometry.pose_in_odom == Pose2D()
    following = odometry.add(1.1, Twist2D(0.1, 0.0, 0.0))
    assert following is not None
    assert following.pose_in_odom.x_m == pytest.approx(0.01)


def test_two_lines_of_one_instant_move_once() -> None:
    odometry = OdometryIntegrator()
    odometry.add(0.0, Twist2D(0.1, 0.0, 0.0))
    odometry.add(0.1, Twist2D(0.1, 0.0, 0.0))
    odometry.add(0.1, Twist2D(0.1, 0.0, 0.0))
    assert odometry.pose_in_odom.x_m == pytest.approx(0.01)


def test_scales_are_applied_to_pose_and_velocity() -> None:
    odometry = OdometryIntegrator(OdometryScale(forward=1.1, lateral=0.9, yaw=2.0))
    odometry.add(0.0, Twist2D(0.1, 0.2, 0.0))
    after = odometry.add(0.1, Twist2D(0.1, 0.2, 0.0))
    assert after is not None
    assert after.twist_in_base == Twist2D(pytest.approx(0.11), pytest.approx(0.18), 0.0)
    assert after.pose_in_odom.x_m == pytest.approx(0.011)
    assert after.pose_in_odom.y_m == pytest.approx(0.018)
    assert OdometryScale(yaw=2.0).apply(Twist2D(0.0, 0.0, 0.5)).wz_radps == 1.0


@pytest.mark.parametrize("scale", [0.0, -1.0, math.nan, math.inf])
def test_a_scale_that_is_none_is_refused(scale: float) -> None:
    with pytest.raises(ValueError, match="lateral"):
        OdometryScale(lateral=scale)


def test_reset_makes_this_pose_the_origin_and_keeps_the_clock() -> None:
    odometry = drive(Twist2D(0.2, 0.0, 0.5), 2.0)
    odometry.reset()
    assert odometry.pose_in_odom == Pose2D()
    assert not odometry.covariance.any()
    after = odometry.add(102.05, Twist2D(0.2, 0.0, 0.0))
    assert after is not None
    assert after.pose_in_odom.x_m == pytest.approx(0.01)


def test_a_successor_goes_on_from_the_last_pose() -> None:
    odometry = OdometryIntegrator()
    odometry.resume(10.0, Pose2D(1.0, 2.0, math.pi / 2))
    after = odometry.add(12.0, Twist2D(0.1, 0.0, 0.0))
    assert after is not None
    assert odometry.in_gap
    assert after.pose_in_odom.x_m == pytest.approx(1.0)
    assert after.pose_in_odom.y_m == pytest.approx(2.025)


@given(st.lists(st.tuples(speed, speed, turn), min_size=1, max_size=40))
def test_the_covariance_stays_one_and_grows(twists: list[tuple[float, float, float]]) -> None:
    odometry = OdometryIntegrator()
    heading_variance = 0.0
    for tick, twist in enumerate(twists):
        odometry.add(0.05 * tick, Twist2D(*twist))
        covariance = odometry.covariance
        assert np.allclose(covariance, covariance.T)
        assert np.linalg.eigvalsh(covariance).min() >= -1e-12
        assert covariance[2, 2] >= heading_variance
        heading_variance = covariance[2, 2]


def test_a_robot_that_stands_grows_no_surer_and_no_less_sure() -> None:
    assert not drive(Twist2D(), 10.0).covariance.any()


def test_heading_error_makes_the_far_end_uncertain_sideways() -> None:
    covariance = drive(Twist2D(0.2, 0.0, 0.0), 50.0).covariance
    assert covariance[1, 1] > 5.0 * covariance[0, 0]


def test_the_firmwares_clock_tells_the_interval_when_lines_come_late_and_in_pairs() -> None:
    """Ten intervals of 50 ms at growing speed; every second line arrives with the one after it."""
    exact, late = OdometryIntegrator(), OdometryIntegrator()
    for i in range(11):
        twist = Twist2D(0.1 * i, 0.0, 0.2 * i)
        exact.add(0.05 * i, twist)
        late.add(0.05 * i + (0.05 if i % 2 else 0.0), twist, 2**32 - 200_000 + 50_000 * i & 2**32 - 1)
    assert late.pose_in_odom.x_m == pytest.approx(exact.pose_in_odom.x_m, abs=1e-9)
    assert late.pose_in_odom.yaw_rad == pytest.approx(exact.pose_in_odom.yaw_rad, abs=1e-9)
    assert late.gaps == 0


@pytest.mark.parametrize("device_us", [7, 3_000_000_000, None])
def test_a_clock_that_contradicts_the_hosts_is_not_believed(device_us: int | None) -> None:
    integrator = OdometryIntegrator()
    integrator.add(0.0, Twist2D(0.2, 0.0, 0.0), 1_000_000)
    integrator.add(0.1, Twist2D(0.2, 0.0, 0.0), device_us)
    assert integrator.pose_in_odom.x_m == pytest.approx(0.02)


def test_a_gap_is_a_gap_by_either_clock() -> None:
    integrator = OdometryIntegrator(max_gap_s=0.25)
    integrator.add(0.0, Twist2D(0.2, 0.0, 0.0), 0)
    integrator.add(2.0, Twist2D(0.2, 0.0, 0.0), 2_000_000)
    assert integrator.in_gap
    assert integrator.pose_in_odom.x_m == pytest.approx(0.05)
