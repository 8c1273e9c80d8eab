"""The one place that decides which velocity is sent: the most restrictive rule wins.

Rules in this order: an input that is missing, stale or not finite sends zero at once; a request is cut to what the base
can do; the body's predicted way must stay clear of obstacles; and what is sent changes no faster than the limits of
acceleration and jerk. No request means braking to zero. Motion that leads away from an obstacle is always allowed.

Jerk is for comfort, so it never makes a stop longer: where the obstacle rule slows down, or standstill is asked for (by
a guard, an operator, or because nobody asks for motion), only what the base can do counts.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from target_nav.config import Config
from target_nav.nav.footprint import Footprint
from target_nav.nav.ramp import Ramp, RampStep
from target_nav.nav.speed import NOTHING, braking_speed_mps, within_limits
from target_nav.state.types import STOP, FloatArray, MotionRequest, Twist2D

_REACTION_S = 0.20
"""Tick, command and drivetrain: how long the old velocity goes on."""
_SAMPLES = 14
_ROUNDING_M = 1e-4
_TOUCHING_M = 0.005
"""Nearer than this to one thing is no excuse to come as near to another."""
_TARGET_RADIUS_M = 0.045
_TARGET_RING = _TARGET_RADIUS_M * np.column_stack(
    [np.cos(np.arange(12) * math.pi / 6.0), np.sin(np.arange(12) * math.pi / 6.0)]
)
_LONGEST_TICK_S = 0.2
"""A later tick than this is treated as this late: a ramp must not jump after a pause."""
_USEFUL_SHARE = 0.5
"""If the whole motion must be slowed to less than this, going straight or turning alone is tried."""


@dataclass(frozen=True)
class Limited:
    """What to send, and the rule that changed the request ("" if none did)."""

    twist: Twist2D
    limited_by: str = ""


class VelocityLimiter:
    def __init__(self, config: Config) -> None:
        self._ramp = Ramp(config.robot)
        self.configure(config)
        self._measured = STOP

    def configure(self, config: Config) -> None:
        """Other limits from the next tick on; what is being sent goes over to them within those of acceleration."""
        self._robot = config.robot
        self._ramp.configure(config.robot)
        self._avoid = config.avoid
        self._loop = config.loop
        self._body = Footprint.of(config.robot)
        self._radius_m = self._body.circumscribed_radius_m

    def reset(self) -> None:
        """Begin from standstill."""
        self._ramp.last = RampStep()

    def limit(
        self,
        request: MotionRequest | None,
        *,
        dt_s: float,
        scan_age_s: float,
        odom_age_s: float,
        camera_age_s: float,
        obstacles_in_base_m: FloatArray,
        target_in_base: tuple[float, float] | None,
        measured: Twist2D,
    ) -> Limited:
        """The velocity to send in this tick.

        `obstacles_in_base_m` has shape (N, 2) and leaves the target out; `target_in_base` is kept clear of too unless
        the request is meant to go near it. A stale camera limits nothing here: missions guard that.
        """
        zero = self._zero_at_once(request, dt_s, scan_age_s, odom_age_s, obstacles_in_base_m, measured)
        if zero:
            self.reset()
            return Limited(STOP, zero)
        self._measured = measured
        dt = min(max(dt_s, 0.0), _LONGEST_TICK_S)
        points = np.asarray(obstacles_in_base_m, dtype=np.float64).reshape(-1, 2)
        if target_in_base is not None and not (request is not None and request.near_target):
            points = np.vstack([points, _TARGET_RING + np.array(target_in_base)])
        wanted = STOP if request is None else request.twist
        able = within_limits(wanted, self._robot)
        by = "" if able == wanted else "speed"
        points = self._near(points)
        clear, slowed = self._clear(able, points)
        last = self._ramp.last.twist
        for_safety = able == STOP or (bool(slowed) and _slower(clear, last))
        step = self._ramp.brisk(clear, dt) if for_safety else self._ramp.smooth(clear, dt)
        ramped = step.twist
        by = slowed or by
        if not by and not _close(ramped, clear):
            by = "acceleration"
        # The ramp may still carry the last velocity towards something: what is really sent is checked as well.
        held, late = self._clear(ramped, points)
        if late and not _close(held, ramped):
            # With no room left to brake in, braking gently is no use.
            step = RampStep() if self._immediate(ramped, points) else self._ramp.brisk(held, dt)
            by = late
        if request is None and last != STOP:
            by = by or "no request"
        self._ramp.last = step
        return Limited(step.twist, by)

    def _zero_at_once(
        self,
        request: MotionRequest | None,
        dt_s: float,
        scan_age_s: float,
        odom_age_s: float,
        obstacles_m: FloatArray,
        measured: Twist2D,
    ) -> str:
        if request is not None and not request.twist.is_finite():
            return "request not finite"
        # Written so that NaN counts as stale.
        if not scan_age_s <= self._loop.scan_max_age_s:
            return "stale scan"
        if not odom_age_s <= self._loop.odom_max_age_s:
            return "stale odometry"
        if not measured.is_finite():
            return "odometry not finite"
        if not math.isfinite(dt_s):
            return "clock not finite"
        if np.size(obstacles_m) and not np.isfinite(obstacles_m).all():
            return "obstacles not finite"
        return ""

    def _near(self, points: FloatArray) -> FloatArray:
        """Points that the body could come near to within the prediction."""
        if len(points) == 0:
            return points
        reach = self._radius_m + self._avoid.slow_clearance_m + self._avoid.stop_clearance_m + 0.05
        kept: FloatArray = points[(points * points).sum(axis=1) < reach * reach]
        return kept

    def _clear(self, twist: Twist2D, points: FloatArray) -> tuple[Twist2D, str]:
        """The twist slowed so that the body stops before anything is nearer than the stop clearance."""
        if len(points) == 0 or _still(twist):
            return twist, ""
        whole = self._share(twist, points)
        if whole >= 1.0:
            return twist, ""
        best, share = twist, whole
        if whole < _USEFUL_SHARE:
            straight = Twist2D(twist.vx_mps, twist.vy_mps, 0.0)
            turning = Twist2D(0.0, 0.0, twist.wz_radps)
            for part in (straight, turning):
                if not _still(part) and (part_share := self._share(part, points)) > share + 0.05:
                    best, share = part, part_share
        share = self._over_dead_band(best, share, points)
        return Twist2D(best.vx_mps * share, best.vy_mps * share, best.wz_radps * share), "clearance"

    def _share(self, twist: Twist2D, points: FloatArray) -> float:
        """Which share of the twist's speed is safe, 0 to 1."""
        fastest = twist.speed_mps + abs(twist.wz_radps) * self._radius_m
        free_m = self._free_m(twist, fastest, points) - self._overrun_m(twist)
        if free_m <= 0.0:
            return 0.0
        decel = min(self._robot.max_decel_mps2, self._robot.max_yaw_accel_radps2 * self._radius_m)
        stops = braking_speed_mps(free_m, decel, _REACTION_S)
        zone_m = max(self._avoid.slow_clearance_m - self._avoid.stop_clearance_m, 1e-3)
        slows = self._robot.max_speed_mps * free_m / zone_m
        return min(1.0, min(stops, slows) / fastest)

    def _overrun_m(self, twist: Twist2D) -> float:
        """Extra way because the base still goes faster in that direction than it is told to."""
        if twist.speed_mps == 0.0:
            return 0.0
        along = (
            self._measured.vx_mps * twist.vx_mps + self._measured.vy_mps * twist.vy_mps
        ) / twist.speed_mps
        return max(along - twist.speed_mps, 0.0) * _REACTION_S

    def _free_m(self, twist: Twist2D, fastest_mps: float, points: FloatArray) -> float:
        """How far the body's fastest corner may go along the twist before a point that it approaches is too near."""
        horizon_m = max(self._avoid.slow_clearance_m, 0.1)
        travel = np.linspace(0.0, horizon_m, _SAMPLES + 1)
        clearance = self._body.clearances_along_m(points, twist, travel / fastest_mps)
        now = clearance[0]
        # Where the body is nearer to something than the stop clearance already, it may go on being so, and no more:
        # along a wall or away from it, but not a hair nearer.
        floor = min(self._avoid.stop_clearance_m, max(float(now.min()), _TOUCHING_M))
        edge = np.minimum(floor, now)
        bad = clearance[1:] < edge - _ROUNDING_M
        hit = bad.any(axis=1)
        if not hit.any():
            return math.inf
        first = int(hit.argmax())
        # Between two samples the clearance is taken as linear, for the point that gets too near first.
        before, after = clearance[first][bad[first]], clearance[first + 1][bad[first]]
        fraction = np.clip((before - edge[bad[first]]) / np.maximum(before - after, 1e-9), 0.0, 1.0).min()
        return float(travel[first] + fraction * (travel[first + 1] - travel[first]))

    def _over_dead_band(self, twist: Twist2D, share: float, points: FloatArray) -> float:
        """A slowed motion that the motors could not do is either done at their least speed or not at all."""
        speed, turn = twist.speed_mps, abs(twist.wz_radps)
        least = 1.0
        if speed >= self._robot.min_speed_mps > 0.0:
            least = min(least, self._robot.min_speed_mps / speed)
        elif turn >= self._robot.min_yaw_rate_radps > 0.0:
            least = min(least, self._robot.min_yaw_rate_radps / turn)
        else:
            return share
        if share >= least:
            return share
        slow_mps = (speed + turn * self._radius_m) * least
        free_m = self._free_m(twist, speed + turn * self._radius_m, points)
        return least if free_m > slow_mps * (_REACTION_S + 0.05) else 0.0

    def _immediate(self, twist: Twist2D, points: FloatArray) -> bool:
        """Whether the stop clearance is already used up, so that the ramp must not be waited for."""
        fastest = twist.speed_mps + abs(twist.wz_radps) * self._radius_m
        return fastest > 0.0 and self._free_m(twist, fastest, points) <= fastest * _REACTION_S * 0.5


def _still(twist: Twist2D) -> bool:
    return twist.speed_mps < NOTHING and abs(twist.wz_radps) < NOTHING


def _slower(one: Twist2D, other: Twist2D) -> bool:
    """Whether either part of the motion is slower, or is turned round."""
    along = one.vx_mps * other.vx_mps + one.vy_mps * other.vy_mps
    turn = one.wz_radps * other.wz_radps
    return along < other.speed_mps**2 - NOTHING or turn < other.wz_radps**2 - NOTHING


def _close(one: Twist2D, other: Twist2D) -> bool:
    return (
        abs(one.vx_mps - other.vx_mps) < 1e-6
        and abs(one.vy_mps - other.vy_mps) < 1e-6
        and abs(one.wz_radps - other.wz_radps) < 1e-6
    )
