"""The drivetrain: PWM in, encoder ticks out, and a base that does not quite go where its wheels say.

Errors are drawn once for a run, within the measured ranges of `DriveSimConfig`: the robot moves farther or less far
than its encoders say, strafes less, and turns a little as it goes. Slips come by chance. A base that is held by an
obstacle stands while its wheels go on: at 90:1 the motors are stronger than the rollers' grip.
"""

from __future__ import annotations

import math

import numpy as np

from target_nav.config import DriveSimConfig, RobotConfig
from target_nav.sim.contact import ContactMonitor
from target_nav.sim.wheels import TICK_M, Base, Wheels, top_wheel_speed_mps
from target_nav.state.types import Pose2D

MAX_PWM = 255

MOTOR_GAIN_SPREAD = 0.05
"""Motors of one batch differ by some per cent at the same PWM, which is what the firmware's PI control is for."""

OVER_REPORT_RANGE = (5.0 / 8.0, 10.0 / 8.0)
"""Measured 5-10 % around the 8 % that `lateral_over_report` has by default."""

DRIFT_RANGE = (0.65, 1.31)
"""Measured 0.3-0.6 degrees a metre around the 0.46 that `heading_drift_rad_per_m` has by default."""

SLIP_DURATION_S = 0.2
"""A slip turns the base over some time, not in an instant."""

STANDSTILL_MPS = 1e-4
"""Below this a wheel that is not driven stands: friction ends what an exponential would drag on."""


class Drive:
    """The plant. `step` moves it by one fixed step; everything public is the truth at the last step."""

    def __init__(
        self,
        robot: RobotConfig,
        sim: DriveSimConfig,
        start: Pose2D,
        contact: ContactMonitor,
        rng: np.random.Generator,
        step_s: float,
    ) -> None:
        self._base = Base.of(robot)
        self._reach_m = robot.circumscribed_radius_m
        self._sim = sim
        self._contact = contact
        self._rng = rng
        self._step_s = step_s
        # A first-order lag over one step at constant drive, exactly: the share that is left of the difference at its
        # end, and its mean.
        self._keep = math.exp(-step_s / sim.lag_s) if sim.lag_s > 0.0 else 0.0
        self._keep_mean = (1.0 - self._keep) * sim.lag_s / step_s if sim.lag_s > 0.0 else 0.0

        sign = 1.0 if rng.random() < 0.5 else -1.0
        self.forward_scale = 1.0 + float(rng.uniform(-1.0, 1.0)) * sim.forward_scale_error
        self.lateral_scale = 1.0 / (1.0 + float(rng.uniform(*OVER_REPORT_RANGE)) * sim.lateral_over_report)
        self.drift_rad_per_m = sign * float(rng.uniform(*DRIFT_RANGE)) * sim.heading_drift_rad_per_m
        gains = rng.uniform(1.0 - MOTOR_GAIN_SPREAD, 1.0 + MOTOR_GAIN_SPREAD, 4)
        self._mps_per_pwm = [float(gain) * top_wheel_speed_mps(robot) / MAX_PWM for gain in gains]

        self.x_m, self.y_m, self.yaw_rad = start.x_m, start.y_m, start.yaw_rad
        """The true pose; yaw is not wrapped."""
        self.vx_mps = self.vy_mps = self.wz_radps = 0.0
        self.path_m = 0.0
        self.jammed: set[int] = set()
        """Wheels that are held fast, by index: a fault for tests of the stall detection."""
        self._speeds = [0.0, 0.0, 0.0, 0.0]
        self._travels = [0.0, 0.0, 0.0, 0.0]
        self._slip_radps = 0.0
        self._slip_steps = 0
        self._to_next_slip_m = self._draw_slip_distance()

    @property
    def pose(self) -> Pose2D:
        return Pose2D(self.x_m, self.y_m, math.remainder(self.yaw_rad, 2.0 * math.pi))

    @property
    def ticks(self) -> tuple[int, int, int, int]:
        """Encoder counts."""
        a, b, c, d = self._travels
        return (
            math.floor(a / TICK_M),
            math.floor(b / TICK_M),
            math.floor(c / TICK_M),
            math.floor(d / TICK_M),
        )

    def step(self, pwm: tuple[int, int, int, int]) -> None:
        """One step with constant PWM: wheels, encoders, then the base, unless something is in its way."""
        if not any(pwm) and not any(self._speeds) and not self._slip_steps:
            self.vx_mps = self.vy_mps = self.wz_radps = 0.0
            return
        wheels = self._turn_wheels(pwm)
        vx, vy, wz = self._base.body_speeds(wheels)
        vx *= self.forward_scale
        vy *= self.lateral_scale
        # The wheels' own way, so that turning on the spot slips as well.
        travel_m = 0.25 * (abs(wheels[0]) + abs(wheels[1]) + abs(wheels[2]) + abs(wheels[3])) * self._step_s
        wz += self.drift_rad_per_m * travel_m / self._step_s + self._slip(travel_m)
        self._move(vx, vy, wz)

    def _turn_wheels(self, pwm: tuple[int, int, int, int]) -> Wheels:
        """Mean rim speeds over the step."""
        deadband, keep, keep_mean = self._sim.deadband_mps, self._keep, self._keep_mean
        speeds, travels = self._speeds, self._travels
        means = [0.0, 0.0, 0.0, 0.0]
        for i in range(4):
            drive = pwm[i] * self._mps_per_pwm[i]
            if -deadband < drive < deadband:
                drive = 0.0
            if i in self.jammed:
                speeds[i] = 0.0
                continue
            difference = speeds[i] - drive
            if drive == 0.0 and -STANDSTILL_MPS < difference < STANDSTILL_MPS:
                speeds[i] = 0.0
                continue
            means[i] = drive + difference * keep_mean
            speeds[i] = drive + difference * keep
            travels[i] += means[i] * self._step_s
        return (means[0], means[1], means[2], means[3])

    def _slip(self, travel_m: float) -> float:
        """What a slip adds to the turning rate now, rad/s."""
        self._to_next_slip_m -= travel_m
        if self._to_next_slip_m <= 0.0:
            self._to_next_slip_m = self._draw_slip_distance()
            lost_rad = float(self._rng.standard_normal()) * self._sim.slip_heading_rad
            self._slip_steps = max(round(SLIP_DURATION_S / self._step_s), 1)
            self._slip_radps = lost_rad / (self._slip_steps * self._step_s)
        if self._slip_steps == 0:
            return 0.0
        self._slip_steps -= 1
        return self._slip_radps

    def _draw_slip_distance(self) -> float:
        rate = self._sim.slip_rate_per_m
        return float(self._rng.exponential(1.0 / rate)) if rate > 0.0 else math.inf

    def _move(self, vx: float, vy: float, wz: float) -> None:
        """The exact arc of a constant body twist (the exponential map of SE(2)), if the way is free."""
        dt = self._step_s
        angle = wz * dt
        if abs(angle) < 1e-6:
            along, across = 1.0, 0.5 * angle
        else:
            along, across = math.sin(angle) / angle, (1.0 - math.cos(angle)) / angle
        forward = (along * vx - across * vy) * dt
        left = (across * vx + along * vy) * dt
        c, s = math.cos(self.yaw_rad), math.sin(self.yaw_rad)
        x, y = self.x_m + c * forward - s * left, self.y_m + s * forward + c * left
        yaw = self.yaw_rad + angle
        way_m = math.sqrt(vx * vx + vy * vy) * dt
        if not self._contact.admits(x, y, yaw, way_m + abs(angle) * self._reach_m):
            self.vx_mps = self.vy_mps = self.wz_radps = 0.0
            return
        self.x_m, self.y_m, self.yaw_rad = x, y, yaw
        self.vx_mps, self.vy_mps, self.wz_radps = vx, vy, wz
        self.path_m += way_m
