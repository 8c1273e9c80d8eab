"""Where the robot is by its own wheels: body velocities integrated into a pose.

The firmware reports the mean velocity of the interval that ends with its line, so a line's twist is applied
to the time *before* its stamp. How long that was, the firmware's own clock tells, where the line has it: on a
busy host lines come late and in pairs, and a turn that is counted 20 ms too long is half a degree. Over one
interval the twist is constant and the motion is an arc, integrated exactly (exponential map of SE(2); e.g. Lynch
and Park, Modern Robotics, 2017, section 3.3.3).
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from target_nav.state.types import FloatArray, Odometry, Pose2D, Twist2D
from target_nav.utils.frames import compose


@dataclass(frozen=True)
class OdometryScale:
    """Calibration: what one reported unit is worth. Mecanum bases over-report strafing: `lateral` < 1."""

    forward: float = 1.0
    lateral: float = 1.0
    yaw: float = 1.0

    def __post_init__(self) -> None:
        for name, value in (("forward", self.forward), ("lateral", self.lateral), ("yaw", self.yaw)):
            if not (math.isfinite(value) and value > 0.0):
                raise ValueError(f"odometry scale {name} is {value}; it must be finite and over 0")

    def apply(self, twist: Twist2D) -> Twist2D:
        return Twist2D(twist.vx_mps * self.forward, twist.vy_mps * self.lateral, twist.wz_radps * self.yaw)


@dataclass(frozen=True)
class OdometryNoise:
    """How fast odometry loses itself: standard deviations that grow with the square root of the way (measured)."""

    forward_m_per_sqrt_m: float = 0.02
    lateral_m_per_sqrt_m: float = 0.08
    yaw_rad_per_sqrt_m: float = 0.01
    yaw_rad_per_sqrt_rad: float = 0.02

    def step(self, step: Pose2D) -> FloatArray:
        """Covariance, shape (3, 3) over x, y, yaw in base_link, of one small motion."""
        dx, dy, turn = abs(step.x_m), abs(step.y_m), abs(step.yaw_rad)
        yaw = self.yaw_rad_per_sqrt_m**2 * math.hypot(dx, dy) + self.yaw_rad_per_sqrt_rad**2 * turn
        return np.diag([self.forward_m_per_sqrt_m**2 * dx, self.lateral_m_per_sqrt_m**2 * dy, yaw])

    def velocity(self, twist: Twist2D) -> FloatArray:
        """Covariance, shape (3, 3), of one reported velocity: its quantum of 1 mm/s and a share of itself."""
        floor = 1e-6
        return np.diag(
            [
                floor + (self.forward_m_per_sqrt_m * twist.vx_mps) ** 2,
                floor + (self.lateral_m_per_sqrt_m * twist.vy_mps) ** 2,
                floor + (self.yaw_rad_per_sqrt_rad * twist.wz_radps) ** 2,
            ]
        )


def arc(twist: Twist2D, dt_s: float) -> Pose2D:
    """The pose reached from the origin by a constant body twist over `dt_s` (yaw not wrapped)."""
    angle = twist.wz_radps * dt_s
    dx, dy = twist.vx_mps * dt_s, twist.vy_mps * dt_s
    if abs(angle) < 1e-4:
        # sin(a)/a and (1 - cos(a))/a lose their digits here; their series are exact to 1e-17.
        along, across = 1.0 - angle * angle / 6.0, angle / 2.0 - angle**3 / 24.0
    else:
        along, across = math.sin(angle) / angle, (1.0 - math.cos(angle)) / angle
    return Pose2D(along * dx - across * dy, across * dx + along * dy, angle)


DEVICE_CLOCK_US = 2**32
"""The firmware's clock counts microseconds and wraps round here."""


class OdometryIntegrator:
    """Integrates stamped body twists. A pose in odom drifts but never jumps.

    After a gap (two stamps farther apart than `max_gap_s`) nobody knows what the robot did in between: only
    `max_gap_s` of it is integrated, `in_gap` is set for that message and `gaps` counts it.
    """

    def __init__(
        self,
        scale: OdometryScale | None = None,
        max_gap_s: float = 0.25,
        noise: OdometryNoise | None = None,
    ) -> None:
        if not (math.isfinite(max_gap_s) and max_gap_s > 0.0):
            raise ValueError(f"max_gap_s is {max_gap_s}; it must be finite and over 0")
        self._scale = scale or OdometryScale()
        self._max_gap_s = max_gap_s
        self._noise = noise or OdometryNoise()
        self._pose = Pose2D()
        self._covariance: FloatArray = np.zeros((3, 3))
        self._stamp_s: float | None = None
        self._device_us: int | None = None
        self.in_gap = False
        self.gaps = 0
        self.rejected = 0

    @property
    def pose_in_odom(self) -> Pose2D:
        return self._pose

    @property
    def covariance(self) -> FloatArray:
        """Of the pose since the last reset, shape (3, 3) over x, y, yaw in odom. A copy."""
        return self._covariance.copy()

    def add(self, stamp_s: float, twist: Twist2D, device_us: int | None = None) -> Odometry | None:
        """Advance to `stamp_s`, which ended an interval driven at `twist` in base_link.

        `device_us` is the firmware's clock at the interval's end. Two in a row tell the interval, unless the host's
        stamps contradict by more than `max_gap_s`: a firmware that was reset, a line that was damaged.

        The first message after the start or a reset only sets the clock. None: the message was ignored and
        counted in `rejected`, being not finite or older than the one before.
        """
        if not (math.isfinite(stamp_s) and twist.is_finite()):
            self.rejected += 1
            return None
        scaled = self._scale.apply(twist)
        if self._stamp_s is not None:
            dt_s = stamp_s - self._stamp_s
            if dt_s < 0.0:
                self.rejected += 1
                return None
            dt_s = self._by_device(dt_s, device_us)
            self.in_gap = dt_s > self._max_gap_s
            self.gaps += self.in_gap
            self._advance(arc(scaled, min(dt_s, self._max_gap_s)))
        self._stamp_s, self._device_us = stamp_s, device_us
        return Odometry(stamp_s, self._pose, scaled)

    def resume(self, stamp_s: float, pose_in_odom: Pose2D) -> None:
        """Go on from a pose that a predecessor had at `stamp_s`; what was driven since is a gap."""
        self._stamp_s, self._device_us, self._pose = stamp_s, None, pose_in_odom

    def reset(self) -> None:
        """The robot's present pose becomes odom's origin; the clock and the counters go on."""
        self._pose = Pose2D()
        self._covariance = np.zeros((3, 3))

    def _by_device(self, host_s: float, device_us: int | None) -> float:
        if device_us is None or self._device_us is None:
            return host_s
        device_s = (device_us - self._device_us) % DEVICE_CLOCK_US * 1e-6
        return device_s if abs(device_s - host_s) <= self._max_gap_s else host_s

    def _advance(self, step: Pose2D) -> None:
        """Move by `step`, given in base_link, and let the covariance grow: F P F' + R Q R'."""
        before, self._pose = self._pose, compose(self._pose, step)
        c, s = math.cos(before.yaw_rad), math.sin(before.yaw_rad)
        transition = np.eye(3)
        transition[0, 2], transition[1, 2] = before.y_m - self._pose.y_m, self._pose.x_m - before.x_m
        rotation = np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])
        self._covariance = (
            transition @ self._covariance @ transition.T + rotation @ self._noise.step(step) @ rotation.T
        )
