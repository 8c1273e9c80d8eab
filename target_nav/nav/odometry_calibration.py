"""Calibration of wheel odometry: legs to drive, and the scales that follow from what was really driven.

A leg is driven by odometry itself, so it is off by just what is looked for: a person (or the simulator's truth)
measures the way that was really gone. Turns go both ways, for a base that drifts to one side turns too far one way and
too little the other (the idea of UMBmark: Borenstein and Feng, IEEE Trans. Robotics and Automation 12(6), 1996).
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from enum import Enum

from target_nav.config import RobotConfig
from target_nav.errors import ConfigError
from target_nav.nav.odometry import OdometryScale
from target_nav.state.types import Pose2D, Twist2D

ACCEL_MPS2 = 0.2
ACCEL_RADPS2 = 0.6
"""Gentle: a wheel that slips is what is not to be measured."""

HEADING_GAIN_PER_S = 1.5
"""A leg keeps its heading, or a square would not be one."""

LAG_S = 0.1
"""Motors and odometry together: this much before its end a leg is over."""

LOWEST, HIGHEST = 0.7, 1.4
"""No base is farther off: a scale beyond is a mistake in measuring."""


class Axis(Enum):
    FORWARD = "forward"
    LEFT = "left"
    TURN = "turn"


@dataclass(frozen=True)
class Leg:
    """One straight way or one turn on the spot. `amount` in metres, or radians counter-clockwise; negative: the other
    way. `speed` in m/s or rad/s."""

    axis: Axis
    amount: float
    speed: float


@dataclass(frozen=True)
class LegPose:
    """Where odometry is: `yaw_rad` counts whole turns."""

    x_m: float
    y_m: float
    yaw_rad: float


class Unwrapped:
    """Follows a pose whose yaw is wrapped, and counts its turns."""

    def __init__(self, pose: Pose2D) -> None:
        self.pose = LegPose(pose.x_m, pose.y_m, pose.yaw_rad)

    def follow(self, pose: Pose2D) -> LegPose:
        turned = math.remainder(pose.yaw_rad - self.pose.yaw_rad, 2.0 * math.pi)
        self.pose = LegPose(pose.x_m, pose.y_m, self.pose.yaw_rad + turned)
        return self.pose


class LegDriver:
    """Drives one leg, by odometry, from `start` on.

    Args:
        heading_rad: the direction in odom in which the leg is meant to begin; it may differ from where the robot looks.
    """

    def __init__(
        self, leg: Leg, robot: RobotConfig, start: LegPose, heading_rad: float, now_s: float
    ) -> None:
        self._leg, self._start, self._heading_rad, self._begin_s = leg, start, heading_rad, now_s
        turn = leg.axis is Axis.TURN
        top = {
            Axis.FORWARD: robot.max_speed_mps,
            Axis.LEFT: robot.max_lateral_speed_mps,
            Axis.TURN: robot.max_yaw_rate_radps,
        }[leg.axis]
        self._speed = min(leg.speed, top)
        self._creep = min(robot.min_yaw_rate_radps if turn else robot.min_speed_mps, self._speed)
        self._accel = ACCEL_RADPS2 if turn else ACCEL_MPS2

    @property
    def limit_s(self) -> float:
        """A leg that takes longer is not driven as it was told."""
        return 2.0 * (abs(self._leg.amount) / self._speed + self._speed / self._accel) + 5.0

    def done(self, pose: LegPose) -> float:
        """How much of the leg odometry has seen, in its unit; negative the wrong way."""
        if self._leg.axis is Axis.TURN:
            return math.copysign(1.0, self._leg.amount) * (pose.yaw_rad - self._start.yaw_rad)
        direction = self._heading_rad + (0.5 * math.pi if self._leg.axis is Axis.LEFT else 0.0)
        dx, dy = pose.x_m - self._start.x_m, pose.y_m - self._start.y_m
        return math.copysign(1.0, self._leg.amount) * (dx * math.cos(direction) + dy * math.sin(direction))

    def twist(self, pose: LegPose, now_s: float) -> Twist2D | None:
        """The velocity to keep now; None: the leg is over."""
        wanted = abs(self._leg.amount)
        if self._leg.axis is Axis.TURN:
            # From where it was meant to begin, so that four corners make a whole turn.
            wanted += math.copysign(1.0, self._leg.amount) * (self._heading_rad - self._start.yaw_rad)
        rest = wanted - self.done(pose)
        if rest <= self._creep * LAG_S:
            return None
        ramp = self._creep + self._accel * (now_s - self._begin_s)
        speed = max(self._creep, min(self._speed, ramp, math.sqrt(2.0 * self._accel * rest)))
        speed = math.copysign(speed, self._leg.amount)
        if self._leg.axis is Axis.TURN:
            return Twist2D(0.0, 0.0, speed)
        turn = HEADING_GAIN_PER_S * (self._heading_rad - pose.yaw_rad)
        return Twist2D(speed, 0.0, turn) if self._leg.axis is Axis.FORWARD else Twist2D(0.0, speed, turn)


def square(side_m: float, speed_mps: float, yaw_rate_radps: float) -> tuple[Leg, ...]:
    """A square, counter-clockwise; it ends where it began and looks where it looked."""
    side, corner = Leg(Axis.FORWARD, side_m, speed_mps), Leg(Axis.TURN, 0.5 * math.pi, yaw_rate_radps)
    return (side, corner) * 4


@dataclass(frozen=True)
class Measured:
    """Ways or angles of one kind: what odometry without calibration reported, and what it really was. Both over 0."""

    reported: float
    true: float

    def plus(self, other: Measured) -> Measured:
        return Measured(self.reported + other.reported, self.true + other.true)

    def scale(self, what: str) -> float:
        """What one reported unit is worth.

        Raises:
            ConfigError: it cannot be meant.
        """
        if not (math.isfinite(self.true) and self.reported > 0.0):
            raise ConfigError(
                f"{what}: measured {self.true:g}, reported {self.reported:g}; both must be over 0"
            )
        scale = self.true / self.reported
        if not LOWEST <= scale <= HIGHEST:
            raise ConfigError(
                f"{what}: measured {self.true:.3f} where odometry says {self.reported:.3f}, a factor of {scale:.2f} "
                f"(limits {LOWEST:g} to {HIGHEST:g}); measured in metres, and degrees over whole turns? Else the "
                "wheels' size or the gearbox in the firmware's config.h is another one"
            )
        return scale


def calibrated(
    forward: Measured | None, lateral: Measured | None, yaw: Measured | None, before: OdometryScale
) -> OdometryScale:
    """The scales that were measured; `before` for those that were not.

    Raises:
        ConfigError: a measurement that cannot be meant.
    """
    return OdometryScale(
        forward.scale("forward") if forward else before.forward,
        lateral.scale("sideways") if lateral else before.lateral,
        yaw.scale("turning") if yaw else before.yaw,
    )
