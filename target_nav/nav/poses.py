"""Where the robot was: a short buffer of odometry that answers "which pose did it have at that time?".

A measurement is placed with the pose of the moment it was taken, never with that of the moment it arrived: a detection
100 ms late, placed with the pose of its arrival at 0.5 rad/s, is 3 degrees off.
"""

from __future__ import annotations

import math
from bisect import bisect_left
from itertools import pairwise

import numpy as np

from target_nav.state.types import FloatArray, Odometry, Pose2D, Twist2D
from target_nav.utils.frames import interpolate, wrap_angle

SPAN_S = 3.0
"""How far the buffer reaches back; the oldest measurement anybody asks for is a scan of about one second ago."""
EXTRAPOLATION_S = 0.1
"""Two periods of 20 Hz odometry: a constant velocity over longer is a guess."""
PREDICTION_S = 0.25
"""`predict` moves the newest pose on by this much at most; older odometry is refused by the freshness guard anyway."""
GAP_S = 0.5
"""Between two samples farther apart than this nobody knows where the robot was."""
RESTART_AFTER = 10
"""So many messages in a row that are older than the newest one: it is the newest one whose clock was wrong."""

# A pose that moves farther in one step than its own twist can explain was reset. The constant terms cover twists that
# are zero at both ends of a step in which the robot moved.
JUMP_M, JUMP_MPS = 0.10, 0.3
JUMP_RAD, JUMP_RADPS = 0.15, 0.5
JUMP_TWIST_FACTOR = 1.5


def moved_by(pose: Pose2D, twist_in_base: Twist2D, dt_s: float) -> Pose2D:
    """`pose` after `dt_s` of a constant twist, by the midpoint rule (error of order (wz dt)^2 / 24 of the way)."""
    heading_rad = pose.yaw_rad + 0.5 * twist_in_base.wz_radps * dt_s
    c, s = math.cos(heading_rad), math.sin(heading_rad)
    return Pose2D(
        pose.x_m + (c * twist_in_base.vx_mps - s * twist_in_base.vy_mps) * dt_s,
        pose.y_m + (s * twist_in_base.vx_mps + c * twist_in_base.vy_mps) * dt_s,
        wrap_angle(pose.yaw_rad + twist_in_base.wz_radps * dt_s),
    )


class PoseHistory:
    """The last three seconds of odometry, in the odom frame (REP-105)."""

    def __init__(self, span_s: float = SPAN_S) -> None:
        self._span_s = span_s
        self._odometry: list[Odometry] = []
        self._stamps_s: list[float] = []
        self._yaws_rad: list[float] = []  # without jumps at +-pi, so that they can be interpolated
        self._behind = 0
        self.epoch = 0
        """Changes whenever odom's origin does: everything placed before means nothing after."""
        self.rejected: dict[str, int] = {"non_finite": 0, "out_of_order": 0, "jump": 0}
        """Messages ignored, and jumps of the pose, since the start."""

    def add(self, odometry: Odometry) -> None:
        """Take one message; a jump of the pose starts the buffer anew.

        One that is not finite, or not newer than the newest, is ignored and counted.
        """
        stamp_s = odometry.stamp_s
        if not (
            math.isfinite(stamp_s)
            and odometry.pose_in_odom.is_finite()
            and odometry.twist_in_base.is_finite()
        ):
            self.rejected["non_finite"] += 1
            return
        if self._stamps_s and stamp_s <= self._stamps_s[-1]:
            self.rejected["out_of_order"] += 1
            self._behind += 1
            if self._behind < RESTART_AFTER:
                return
            self.clear()
        self._behind = 0
        if self._odometry and _is_jump(self._odometry[-1], odometry):
            self.rejected["jump"] += 1
            self.clear()
        yaw_rad = odometry.pose_in_odom.yaw_rad
        if self._yaws_rad:
            yaw_rad = self._yaws_rad[-1] + wrap_angle(yaw_rad - self._yaws_rad[-1])
        self._odometry.append(odometry)
        self._stamps_s.append(stamp_s)
        self._yaws_rad.append(yaw_rad)
        expired = bisect_left(self._stamps_s, stamp_s - self._span_s)
        if expired:
            del self._odometry[:expired], self._stamps_s[:expired], self._yaws_rad[:expired]

    def clear(self) -> None:
        """Forget all; call it when odometry is reset on purpose. Changes `epoch`."""
        self._odometry.clear()
        self._stamps_s.clear()
        self._yaws_rad.clear()
        self._behind = 0
        self.epoch += 1

    @property
    def latest(self) -> Odometry | None:
        return self._odometry[-1] if self._odometry else None

    def at(self, stamp_s: float) -> Pose2D | None:
        """The pose at `stamp_s`, or None: before or after the buffer by more than 0.1 s, or in a gap of odometry."""
        if not self._stamps_s or not math.isfinite(stamp_s):
            return None
        index = bisect_left(self._stamps_s, stamp_s)
        if index == 0 or index == len(self._stamps_s):
            end = self._odometry[0 if index == 0 else -1]
            dt_s = stamp_s - end.stamp_s
            return (
                moved_by(end.pose_in_odom, end.twist_in_base, dt_s) if abs(dt_s) <= EXTRAPOLATION_S else None
            )
        before, after = self._odometry[index - 1], self._odometry[index]
        if after.stamp_s == stamp_s:
            return after.pose_in_odom
        gap_s = after.stamp_s - before.stamp_s
        if gap_s > GAP_S:
            return None
        return interpolate(before.pose_in_odom, after.pose_in_odom, (stamp_s - before.stamp_s) / gap_s)

    def at_each(self, stamps_s: FloatArray) -> FloatArray | None:
        """`at` for ascending stamps of shape (N,), N > 0: rows of (x_m, y_m, yaw_rad), or None if one is not covered.

        The yaw of these rows does not wrap.
        """
        if not self._stamps_s:
            return None
        first_s, last_s = float(stamps_s[0]), float(stamps_s[-1])
        if not (math.isfinite(first_s) and math.isfinite(last_s)):
            return None
        start, stop = bisect_left(self._stamps_s, first_s), bisect_left(self._stamps_s, last_s)
        low, high = max(start - 1, 0), min(stop + 1, len(self._stamps_s))
        knots = [
            (stamp_s, odometry.pose_in_odom.x_m, odometry.pose_in_odom.y_m, yaw_rad)
            for stamp_s, odometry, yaw_rad in zip(
                self._stamps_s[low:high], self._odometry[low:high], self._yaws_rad[low:high]
            )
        ]
        if start == 0 and first_s < knots[0][0]:
            if knots[0][0] - first_s > EXTRAPOLATION_S:
                return None
            knots.insert(0, self._extrapolated(0, first_s))
        if stop == len(self._stamps_s):
            if last_s - knots[-1][0] > EXTRAPOLATION_S:
                return None
            knots.append(self._extrapolated(-1, last_s))
        if any(after[0] - before[0] > GAP_S for before, after in pairwise(knots)):
            return None
        table = np.array(knots)
        poses = np.empty((len(stamps_s), 3))
        for column in range(3):
            poses[:, column] = np.interp(stamps_s, table[:, 0], table[:, column + 1])
        return poses

    def predict(self, now_s: float) -> Pose2D | None:
        """The newest pose moved on to `now_s` by its twist, by 0.25 s at most; None while there is no odometry."""
        if not self._odometry or not math.isfinite(now_s):
            return None
        newest = self._odometry[-1]
        dt_s = now_s - newest.stamp_s
        if dt_s < 0.0:
            return self.at(now_s) or newest.pose_in_odom
        return moved_by(newest.pose_in_odom, newest.twist_in_base, min(dt_s, PREDICTION_S))

    def _extrapolated(self, index: int, stamp_s: float) -> tuple[float, float, float, float]:
        end = self._odometry[index]
        dt_s = stamp_s - end.stamp_s
        pose = moved_by(end.pose_in_odom, end.twist_in_base, dt_s)
        return stamp_s, pose.x_m, pose.y_m, self._yaws_rad[index] + end.twist_in_base.wz_radps * dt_s


def _is_jump(before: Odometry, after: Odometry) -> bool:
    dt_s = after.stamp_s - before.stamp_s
    first, second = before.twist_in_base, after.twist_in_base
    speed_mps = JUMP_TWIST_FACTOR * max(first.speed_mps, second.speed_mps) + JUMP_MPS
    yaw_rate_radps = JUMP_TWIST_FACTOR * max(abs(first.wz_radps), abs(second.wz_radps)) + JUMP_RADPS
    start, end = before.pose_in_odom, after.pose_in_odom
    moved_m = math.hypot(end.x_m - start.x_m, end.y_m - start.y_m)
    turned_rad = abs(wrap_angle(end.yaw_rad - start.yaw_rad))
    return moved_m > JUMP_M + speed_mps * dt_s or turned_rad > JUMP_RAD + yaw_rate_radps * dt_s
