"""Kinematics of the base: four wheels, front left, front right, rear left, rear right.

Mecanum with rollers at 45 degrees (Lynch and Park, Modern Robotics, 2017, section 13.2): a wheel's rim speed is
vx -+ vy -+ lever * wz. A differential base is the same without vy: the two wheels of a side turn alike.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

from target_nav.config import RobotConfig

Wheels = tuple[float, float, float, float]

WHEEL_RADIUS_M = 0.03
TICKS_PER_TURN = 990
"""11 pulses a motor turn and the 90:1 gearbox; one edge counted, for the board has one interrupt a wheel."""

TICK_M = 2.0 * math.pi * WHEEL_RADIUS_M / TICKS_PER_TURN
"""Rim travel of one encoder tick: 0.19 mm."""


@dataclass(frozen=True)
class Base:
    """`lever_m` is half the wheelbase plus half the track for mecanum, half the track for differential."""

    lever_m: float
    strafes: bool

    @classmethod
    def of(cls, robot: RobotConfig) -> Base:
        """Wheels stand at 70 % of the body's length and 85 % of its width, as on small mecanum kits."""
        half_track_m = 0.85 * robot.half_width_m
        if robot.drive == "differential":
            return cls(half_track_m, strafes=False)
        return cls(half_track_m + 0.35 * (robot.front_m + robot.rear_m), strafes=True)

    def wheel_speeds(self, vx: float, vy: float, wz: float) -> Wheels:
        """Inverse kinematics: rim speeds, in the unit of vx and of lever_m * wz."""
        if not self.strafes:
            vy = 0.0
        turn = self.lever_m * wz
        return (vx - vy - turn, vx + vy + turn, vx + vy - turn, vx - vy + turn)

    def body_speeds(self, wheels: Wheels) -> tuple[float, float, float]:
        """Forward kinematics (least squares over the four wheels): vx, vy, wz."""
        fl, fr, rl, rr = wheels
        vx = 0.25 * (fl + fr + rl + rr)
        vy = 0.25 * (-fl + fr + rl - rr) if self.strafes else 0.0
        return vx, vy, 0.25 * (-fl + fr - rl + rr) / self.lever_m


def top_wheel_speed_mps(robot: RobotConfig) -> float:
    """What a motor does at full PWM: twice the robot's limit, which leaves room to strafe and turn at once."""
    return 2.0 * robot.max_speed_mps
