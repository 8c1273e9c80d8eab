"""What comes in from ROS is checked; what goes out comes back the same."""

from __future__ import annotations

import math
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from target_nav.app.ros_clock import RosClock
from target_nav.app.ros_convert import (
    BadMessageError,
    odometry_from_msg,
    odometry_to_msg,
    scan_from_msg,
    scan_to_msg,
    stamp_from_msg,
    transform_to_msg,
    twist_from_msg,
    twist_to_msg,
)
from target_nav.state.types import Odometry, Pose2D, Scan, Twist2D

CLOCK = RosClock()
coordinate = st.floats(-100.0, 100.0)
angle = st.floats(-math.pi, math.pi)


def stamp(age_s: float = 0.0) -> Any:
    sec, nanosec = divmod(CLOCK.to_wall_ns(CLOCK.now_s() - age_s), 1_000_000_000)
    return SimpleNamespace(sec=sec, nanosec=nanosec)


def twist_message(x: float = 0.0, y: float = 0.0, z: float = 0.0) -> Any:
    return SimpleNamespace(
        linear=SimpleNamespace(x=x, y=y, z=0.0), angular=SimpleNamespace(x=0.0, y=0.0, z=z)
    )


def scan_message(**changes: Any) -> Any:
    message = {
        "header": SimpleNamespace(stamp=stamp(), frame_id="laser"),
        "angle_min": -math.pi,
        "angle_increment": math.pi / 2,
        "time_increment": 0.05,
        "scan_time": 0.2,
        "range_min": 0.15,
        "range_max": 12.0,
        "ranges": [1.0, 2.0, 3.0, 4.0],
    }
    return SimpleNamespace(**{**message, **changes})


def odometry_message(**changes: Any) -> Any:
    message = {
        "header": SimpleNamespace(stamp=stamp()),
        "pose": SimpleNamespace(
            pose=SimpleNamespace(
                position=SimpleNamespace(x=1.0, y=2.0, z=0.0),
                orientation=SimpleNamespace(x=0.0, y=0.0, z=math.sin(0.25), w=math.cos(0.25)),
            )
        ),
        "twist": SimpleNamespace(twist=twist_message(0.1, 0.0, 0.2)),
    }
    return SimpleNamespace(**{**message, **changes})


def kind_of(convert: Any, *arguments: Any) -> str:
    with pytest.raises(BadMessageError) as caught:
        convert(*arguments)
    return caught.value.kind


def test_a_twist_keeps_what_lies_in_the_plane() -> None:
    assert twist_from_msg(twist_message(0.1, -0.2, 0.3)) == Twist2D(0.1, -0.2, 0.3)


@pytest.mark.parametrize("bad", [math.nan, math.inf, -math.inf])
def test_a_twist_that_is_not_finite_is_refused(bad: float) -> None:
    for values in ((bad, 0.0, 0.0), (0.0, bad, 0.0), (0.0, 0.0, bad)):
        assert kind_of(twist_from_msg, twist_message(*values)) == "twist.not_finite"


@pytest.mark.parametrize(
    ("age_s", "kind"),
    [(-1.5, "stamp.future"), (11.0, "stamp.past"), (1e9, "stamp.past"), (-1e9, "stamp.future")],
)
def test_a_stamp_that_is_far_off_is_refused(age_s: float, kind: str) -> None:
    assert kind_of(stamp_from_msg, stamp(age_s), CLOCK) == kind


def test_a_message_without_a_stamp_is_refused() -> None:
    assert kind_of(stamp_from_msg, SimpleNamespace(sec=0, nanosec=0), CLOCK) == "stamp.past"


@pytest.mark.parametrize("age_s", [-0.9, 0.0, 9.0])
def test_a_stamp_that_is_merely_late_is_kept(age_s: float) -> None:
    assert CLOCK.now_s() - stamp_from_msg(stamp(age_s), CLOCK) == pytest.approx(age_s, abs=0.1)


def test_a_scan_is_taken_over() -> None:
    scan = scan_from_msg(scan_message(), CLOCK)
    assert scan.ranges_m.dtype == np.float64
    assert scan.ranges_m.tolist() == [1.0, 2.0, 3.0, 4.0]
    assert (scan.angle_min_rad, scan.angle_increment_rad) == (-math.pi, math.pi / 2)
    assert (scan.range_min_m, scan.range_max_m, scan.time_increment_s) == (0.15, 12.0, 0.05)


def test_what_is_no_range_is_a_drop_out() -> None:
    ranges = [math.nan, math.inf, -math.inf, 0.0, 0.1, 12.5, -3.0, 5.0]
    message = scan_message(ranges=ranges, angle_increment=0.1)
    assert scan_from_msg(message, CLOCK).ranges_m.tolist() == [math.inf] * 7 + [5.0]


def test_a_driver_that_tells_only_the_turns_time_gets_its_beams_timed() -> None:
    assert scan_from_msg(scan_message(time_increment=0.0), CLOCK).time_increment_s == pytest.approx(0.05)


@pytest.mark.parametrize(
    ("changes", "kind"),
    [
        ({"ranges": []}, "scan.count"),
        ({"ranges": [1.0] * 20_001, "angle_increment": 1e-4}, "scan.count"),
        ({"angle_increment": 0.0}, "scan.angles"),
        ({"angle_increment": math.nan}, "scan.angles"),
        ({"angle_min": math.inf}, "scan.angles"),
        ({"angle_increment": 3.0}, "scan.angles"),
        ({"range_min": math.nan}, "scan.limits"),
        ({"range_min": 5.0, "range_max": 5.0}, "scan.limits"),
        ({"time_increment": -0.1}, "scan.time"),
        ({"time_increment": math.nan}, "scan.time"),
        ({"header": SimpleNamespace(stamp=stamp(-1e6))}, "stamp.future"),
    ],
)
def test_a_scan_that_cannot_be_is_refused(changes: dict[str, Any], kind: str) -> None:
    assert kind_of(scan_from_msg, scan_message(**changes), CLOCK) == kind


def test_odometry_is_taken_over() -> None:
    odometry = odometry_from_msg(odometry_message(), CLOCK)
    assert odometry.pose_in_odom == Pose2D(1.0, 2.0, pytest.approx(0.5))
    assert odometry.twist_in_base == Twist2D(0.1, 0.0, 0.2)


@pytest.mark.parametrize(
    ("changes", "kind"),
    [
        ({"twist": SimpleNamespace(twist=twist_message(math.nan))}, "twist.not_finite"),
        ({"header": SimpleNamespace(stamp=stamp(60.0))}, "stamp.past"),
    ],
)
def test_odometry_that_cannot_be_is_refused(changes: dict[str, Any], kind: str) -> None:
    assert kind_of(odometry_from_msg, odometry_message(**changes), CLOCK) == kind


@pytest.mark.parametrize("w", [0.0, math.nan, 3.0])
def test_a_quaternion_that_is_no_rotation_is_refused(w: float) -> None:
    message = odometry_message()
    message.pose.pose.orientation = SimpleNamespace(x=0.0, y=0.0, z=0.0, w=w)
    assert kind_of(odometry_from_msg, message, CLOCK) == "odometry.quaternion"


def test_a_position_that_is_not_finite_is_refused() -> None:
    message = odometry_message()
    message.pose.pose.position.y = math.inf
    assert kind_of(odometry_from_msg, message, CLOCK) == "odometry.not_finite"


@pytest.mark.ros
@given(coordinate, coordinate, angle, st.floats(-1.0, 1.0))
def test_odometry_survives_the_message(x: float, y: float, yaw: float, speed: float) -> None:
    sent = Odometry(CLOCK.now_s(), Pose2D(x, y, yaw), Twist2D(speed, -speed, speed))
    got = odometry_from_msg(odometry_to_msg(sent, CLOCK), CLOCK)
    assert got.stamp_s == pytest.approx(sent.stamp_s, abs=1e-6)
    assert (got.pose_in_odom.x_m, got.pose_in_odom.y_m) == (x, y)
    assert math.remainder(got.pose_in_odom.yaw_rad - yaw, 2 * math.pi) == pytest.approx(0.0, abs=1e-9)
    assert got.twist_in_base == sent.twist_in_base


@pytest.mark.ros
def test_covariances_lie_where_ros_looks_for_them() -> None:
    covariance = np.array([[1.0, 2.0, 3.0], [2.0, 4.0, 5.0], [3.0, 5.0, 6.0]])
    message = odometry_to_msg(Odometry(CLOCK.now_s(), Pose2D(), Twist2D()), CLOCK, covariance, covariance)
    full = np.asarray(message.pose.covariance).reshape(6, 6)
    assert full[0, 0] == 1.0
    assert full[0, 1] == full[1, 0] == 2.0
    assert full[0, 5] == full[5, 0] == 3.0
    assert full[5, 5] == 6.0
    assert full[2, 2] == full[3, 3] == full[4, 4] == 1e-6
    assert np.array_equal(message.twist.covariance, message.pose.covariance)


@pytest.mark.ros
def test_a_scan_survives_the_message() -> None:
    ranges = np.array([0.5, math.inf, 2.25, 11.0])
    sent = Scan(CLOCK.now_s(), -1.0, 0.5, 0.001, 0.25, 12.0, ranges)
    got = scan_from_msg(scan_to_msg(sent, CLOCK), CLOCK)
    assert got.ranges_m.tolist() == ranges.tolist()
    assert got.stamp_s == pytest.approx(sent.stamp_s, abs=1e-6)
    assert (got.angle_min_rad, got.angle_increment_rad) == (-1.0, 0.5)
    assert got.time_increment_s == pytest.approx(0.001)


@pytest.mark.ros
def test_a_scans_last_angle_is_that_of_its_last_beam() -> None:
    message = scan_to_msg(Scan(CLOCK.now_s(), -1.0, 0.5, 0.01, 0.15, 12.0, np.ones(5)), CLOCK)
    assert message.angle_max == pytest.approx(1.0)
    assert message.scan_time == pytest.approx(0.05)
    assert message.header.frame_id == "laser"


@pytest.mark.ros
def test_a_twist_survives_the_message() -> None:
    assert twist_from_msg(twist_to_msg(Twist2D(0.1, -0.2, 0.3))) == Twist2D(0.1, -0.2, 0.3)


@pytest.mark.ros
def test_a_transform_says_where_the_child_is_in_the_parent() -> None:
    message = transform_to_msg(
        CLOCK.now_s(), "odom", "base_link", Pose2D(1.0, 2.0, math.pi / 2), CLOCK, z_m=0.3
    )
    assert (message.header.frame_id, message.child_frame_id) == ("odom", "base_link")
    translation, rotation = message.transform.translation, message.transform.rotation
    assert (translation.x, translation.y, translation.z) == (1.0, 2.0, 0.3)
    assert (rotation.z, rotation.w) == (pytest.approx(math.sqrt(0.5)), pytest.approx(math.sqrt(0.5)))
