"""Between ROS messages and this project's types, with everything checked that comes in.

A message that cannot be believed raises BadMessageError, which `RosNode.subscribe` counts, logs now and then, and
drops: for the rest of the stack it never came, and ages do the rest.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from target_nav.app.ros_clock import RosClock, StampLike
from target_nav.state.types import FloatArray, Odometry, Pose2D, Scan, Twist2D

ODOM_FRAME, BASE_FRAME, LASER_FRAME, CAMERA_FRAME = "odom", "base_link", "laser", "camera_link"

FUTURE_LIMIT_S = 1.0
PAST_LIMIT_S = 10.0
"""A stamp farther off is not late: its clock is another one."""

MAX_BEAMS = 20_000


class BadMessageError(Exception):
    """A message that must not be used. `kind` is short and fixed, for counting."""

    def __init__(self, kind: str, message: str) -> None:
        super().__init__(message)
        self.kind = kind


# --- in ---


def stamp_from_msg(stamp: StampLike, clock: RosClock) -> float:
    """Monotonic seconds of a header's stamp.

    Raises:
        BadMessageError: more than 1 s in the future or 10 s in the past.
    """
    stamp_s = clock.to_monotonic(stamp)
    age_s = clock.now_s() - stamp_s
    if age_s < -FUTURE_LIMIT_S:
        raise BadMessageError(
            "stamp.future",
            f"stamped {-age_s:.3f} s ahead (limit {FUTURE_LIMIT_S:g} s); do the machines' clocks agree?",
        )
    if age_s > PAST_LIMIT_S:
        raise BadMessageError(
            "stamp.past",
            f"stamped {age_s:.3f} s ago (limit {PAST_LIMIT_S:g} s); does its driver use the wall clock?",
        )
    return stamp_s


def twist_from_msg(message: Any) -> Twist2D:
    """geometry_msgs/Twist; what does not lie in the plane is ignored.

    Raises:
        BadMessageError: a component is not finite.
    """
    twist = Twist2D(message.linear.x, message.linear.y, message.angular.z)
    if not twist.is_finite():
        raise BadMessageError("twist.not_finite", f"velocity {twist} is not finite")
    return twist


def odometry_from_msg(message: Any, clock: RosClock) -> Odometry:
    """nav_msgs/Odometry.

    Raises:
        BadMessageError: a number is not finite, the quaternion is no rotation, the stamp is far off.
    """
    position, q = message.pose.pose.position, message.pose.pose.orientation
    norm = math.hypot(q.x, q.y, q.z, q.w)
    if not abs(norm - 1.0) < 0.1:
        raise BadMessageError("odometry.quaternion", f"orientation has length {norm:g}; a rotation's is 1")
    yaw_rad = math.atan2(2.0 * (q.w * q.z + q.x * q.y), norm * norm - 2.0 * (q.y * q.y + q.z * q.z))
    pose = Pose2D(position.x, position.y, yaw_rad)
    if not pose.is_finite():
        raise BadMessageError("odometry.not_finite", f"pose {pose} is not finite")
    twist = twist_from_msg(message.twist.twist)
    return Odometry(stamp_from_msg(message.header.stamp, clock), pose, twist)


def scan_from_msg(message: Any, clock: RosClock) -> Scan:
    """sensor_msgs/LaserScan. Ranges outside the sensor's own limits, zeros and NaN become `inf`: drop-outs.

    Raises:
        BadMessageError: no beams or absurdly many, an angle step of 0 or more than a turn in all, limits that make
        no
            sense, a stamp far off.
    """
    count = len(message.ranges)
    if not 0 < count <= MAX_BEAMS:
        raise BadMessageError("scan.count", f"{count} beams; it must be 1 ... {MAX_BEAMS}")
    step_rad = message.angle_increment
    if not (math.isfinite(message.angle_min) and math.isfinite(step_rad) and step_rad != 0.0):
        raise BadMessageError(
            "scan.angles", f"angles start at {message.angle_min} and step by {step_rad} rad"
        )
    if abs(step_rad) * (count - 1) > 2.0 * math.pi * 1.01:
        raise BadMessageError("scan.angles", f"{count} beams, {step_rad:g} rad apart, are more than a turn")
    low_m, high_m = message.range_min, message.range_max
    if not (math.isfinite(low_m) and math.isfinite(high_m) and 0.0 <= low_m < high_m):
        raise BadMessageError("scan.limits", f"range limits are {low_m} ... {high_m} m")
    beam_s = message.time_increment
    if beam_s == 0.0 and message.scan_time > 0.0:
        beam_s = message.scan_time / count
    if not (math.isfinite(beam_s) and 0.0 <= beam_s * count < PAST_LIMIT_S):
        raise BadMessageError("scan.time", f"beams are {beam_s} s apart")
    ranges_m = np.array(message.ranges, dtype=np.float64)
    ranges_m[~((ranges_m >= low_m) & (ranges_m <= high_m))] = math.inf
    stamp_s = stamp_from_msg(message.header.stamp, clock)
    return Scan(stamp_s, message.angle_min, step_rad, beam_s, low_m, high_m, ranges_m)


# --- out ---


def stamp_to_msg(stamp_s: float, clock: RosClock) -> Any:
    """builtin_interfaces/Time."""
    from builtin_interfaces.msg import Time

    seconds, nanoseconds = divmod(clock.to_wall_ns(stamp_s), 1_000_000_000)
    return Time(sec=seconds, nanosec=nanoseconds)


def twist_to_msg(twist: Twist2D) -> Any:
    """geometry_msgs/Twist."""
    from geometry_msgs.msg import Twist

    message = Twist()
    message.linear.x, message.linear.y = float(twist.vx_mps), float(twist.vy_mps)
    message.angular.z = float(twist.wz_radps)
    return message


def scan_to_msg(scan: Scan, clock: RosClock, frame: str = LASER_FRAME) -> Any:
    """sensor_msgs/LaserScan."""
    from sensor_msgs.msg import LaserScan

    message = LaserScan()
    message.header.stamp = stamp_to_msg(scan.stamp_s, clock)
    message.header.frame_id = frame
    count = len(scan.ranges_m)
    message.angle_min = float(scan.angle_min_rad)
    message.angle_increment = float(scan.angle_increment_rad)
    message.angle_max = float(scan.angle_min_rad + max(count - 1, 0) * scan.angle_increment_rad)
    message.time_increment = float(scan.time_increment_s)
    message.scan_time = float(scan.time_increment_s * count)
    message.range_min, message.range_max = float(scan.range_min_m), float(scan.range_max_m)
    message.ranges.frombytes(scan.ranges_m.astype(np.float32).tobytes())
    return message


def odometry_to_msg(
    odometry: Odometry,
    clock: RosClock,
    pose_covariance: FloatArray | None = None,
    twist_covariance: FloatArray | None = None,
) -> Any:
    """nav_msgs/Odometry. Covariances have shape (3, 3), over x, y, yaw; None leaves them zero: unknown."""
    from nav_msgs.msg import Odometry as OdometryMessage

    message = OdometryMessage()
    message.header.stamp = stamp_to_msg(odometry.stamp_s, clock)
    message.header.frame_id, message.child_frame_id = ODOM_FRAME, BASE_FRAME
    pose = odometry.pose_in_odom
    message.pose.pose.position.x, message.pose.pose.position.y = float(pose.x_m), float(pose.y_m)
    _set_yaw(message.pose.pose.orientation, pose.yaw_rad)
    message.twist.twist = twist_to_msg(odometry.twist_in_base)
    if pose_covariance is not None:
        message.pose.covariance = _to_six(pose_covariance)
    if twist_covariance is not None:
        message.twist.covariance = _to_six(twist_covariance)
    return message


def transform_to_msg(
    stamp_s: float, parent: str, child: str, pose: Pose2D, clock: RosClock, z_m: float = 0.0
) -> Any:
    """geometry_msgs/TransformStamped: the pose of `child` in `parent`."""
    from geometry_msgs.msg import TransformStamped

    message = TransformStamped()
    message.header.stamp = stamp_to_msg(stamp_s, clock)
    message.header.frame_id, message.child_frame_id = parent, child
    translation = message.transform.translation
    translation.x, translation.y, translation.z = float(pose.x_m), float(pose.y_m), float(z_m)
    _set_yaw(message.transform.rotation, pose.yaw_rad)
    return message


def _set_yaw(quaternion: Any, yaw_rad: float) -> None:
    quaternion.z, quaternion.w = math.sin(0.5 * yaw_rad), math.cos(0.5 * yaw_rad)


def _to_six(planar: FloatArray) -> FloatArray:
    """Row-major 6x6 over x, y, z, roll, pitch, yaw. What does not move in the plane is known well: 1e-6."""
    full = np.diag(np.full(6, 1e-6))
    rows = np.ix_((0, 1, 5), (0, 1, 5))
    full[rows] = planar
    return full.reshape(-1)
