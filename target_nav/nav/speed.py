"""How fast: braking curves, the motors' dead-band, and the limits of the base. Pure functions of numbers."""

from __future__ import annotations

import math

from target_nav.config import RobotConfig
from target_nav.state.types import STOP, Twist2D

NOTHING = 1e-6
"""m/s or rad/s: what arithmetic leaves over of a zero, and no motion that anybody wants."""


def braking_speed_mps(distance_m: float, decel_mps2: float, reaction_s: float = 0.0) -> float:
    """The fastest speed that still stops within `distance_m`: solves v * reaction + v^2 / (2 a) = d for v."""
    if not distance_m > 0.0:
        return 0.0
    lost = decel_mps2 * reaction_s
    return math.sqrt(lost * lost + 2.0 * decel_mps2 * distance_m) - lost


def clearance_speed_mps(
    clearance_m: float, top_mps: float, least_mps: float, stop_m: float, slow_m: float
) -> float:
    """Linear between `least_mps` at a clearance of `stop_m` and `top_mps` from `slow_m` on."""
    if not clearance_m > stop_m:
        return min(least_mps, top_mps)
    share = min((clearance_m - stop_m) / max(slow_m - stop_m, 1e-6), 1.0)
    return min(top_mps, least_mps + share * max(top_mps - least_mps, 0.0))


def within_limits(twist: Twist2D, robot: RobotConfig) -> Twist2D:
    """The same direction and curvature of motion, slowed until every axis is within its limit; not finite: STOP."""
    if not twist.is_finite():
        return STOP
    vy = 0.0 if robot.drive == "differential" else twist.vy_mps
    scale = 1.0
    for value, limit in (
        (twist.vx_mps, robot.max_speed_mps),
        (vy, robot.max_lateral_speed_mps),
        (math.hypot(twist.vx_mps, vy), robot.max_speed_mps),
    ):
        if abs(value) > limit:
            scale = min(scale, limit / abs(value))
    wz = max(-robot.max_yaw_rate_radps, min(robot.max_yaw_rate_radps, twist.wz_radps))
    return Twist2D(twist.vx_mps * scale, vy * scale, wz)


def over_dead_band(twist: Twist2D, robot: RobotConfig) -> Twist2D:
    """Any motion that is wanted is made fast enough for the motors to turn; zero, or next to it, is zero."""
    vx, vy, wz = twist.vx_mps, twist.vy_mps, twist.wz_radps
    speed = math.hypot(vx, vy)
    if not speed >= NOTHING:
        vx = vy = speed = 0.0
    if not abs(wz) >= NOTHING:
        wz = 0.0
    if 0.0 < speed < robot.min_speed_mps:
        vx, vy = vx * robot.min_speed_mps / speed, vy * robot.min_speed_mps / speed
    # A base that is rolling already turns on small differences; one that stands does not.
    if speed < robot.min_speed_mps and 0.0 < abs(wz) < robot.min_yaw_rate_radps:
        wz = math.copysign(robot.min_yaw_rate_radps, wz)
    return Twist2D(vx, vy, wz)


class YawControl:
    """Turns to a heading and holds it: proportional, over the dead-band, with a rest zone so that it does not hunt."""

    def __init__(
        self, robot: RobotConfig, *, gain: float = 2.0, top_radps: float = 0.8, rest_rad: float = 0.02
    ) -> None:
        """`rest_rad`: turning ends within this error and begins again at three times it."""
        self._least = robot.min_yaw_rate_radps
        self._top = min(top_radps, robot.max_yaw_rate_radps)
        self._gain = gain
        self._rest_rad = rest_rad
        self._turning = False

    def reset(self) -> None:
        self._turning = False

    def rate_radps(self, error_rad: float, measured_radps: float = 0.0, lag_s: float = 0.1) -> float:
        """Yaw rate for a heading error; what the base will still turn during `lag_s` is taken off first."""
        ahead = error_rad - measured_radps * lag_s
        if abs(error_rad) > 3.0 * self._rest_rad:
            self._turning = True
        elif abs(ahead) < self._rest_rad or ahead * error_rad < 0.0:
            self._turning = False
        if not self._turning:
            return 0.0
        return math.copysign(min(max(self._gain * abs(ahead), self._least), self._top), ahead)
