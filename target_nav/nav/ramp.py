"""How fast a velocity may change: from what was sent last towards what is wanted, within acceleration and jerk.

In ticks of `dt_s` the acceleration a of a tick is the change of velocity over dt, and jerk the change of a over dt.
Each tick takes the largest acceleration from which it can still be ramped down in time: with steps of j dt,
n = floor(a / (j dt)) more ticks follow, in which the velocity goes on by S(a) = dt (n a - j dt n (n + 1) / 2). Where
the velocity would come to rest that way must lie within the limits of speed. That set is convex and ramping down
leaves the place where it is, so there is always a step that keeps every limit. Twists are complex numbers, vx + i vy.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

from target_nav.config import RobotConfig
from target_nav.state.types import STOP, Twist2D

_CREEP_SHARE = 1.25
"""Of the motors' least speed. No smaller step from or to standstill can be done, and skills stop from that speed."""
_SAME = 1e-9
_ROUNDING = 1e-12
_BISECTIONS = 12
_SHORTEST_TICK_S = 1e-4


@dataclass(frozen=True)
class RampStep:
    """A velocity that may be sent, and the acceleration it means: of (vx, vy), and of wz."""

    twist: Twist2D = STOP
    accel: complex = 0j
    yaw_accel: complex = 0j


@dataclass(frozen=True)
class _Limits:
    speed: float
    aside: float
    up: float
    down: float
    jerk: float
    creep: float

    def allow(self, v: complex) -> bool:
        speed = self.speed + _ROUNDING
        return abs(v) <= speed and abs(v.real) <= speed and abs(v.imag) <= self.aside + _ROUNDING


class Ramp:
    def __init__(self, robot: RobotConfig) -> None:
        self.configure(robot)
        self.last = RampStep()

    def configure(self, robot: RobotConfig) -> None:
        turn = robot.max_yaw_accel_radps2
        self._linear = _Limits(
            robot.max_speed_mps, robot.max_lateral_speed_mps, robot.max_accel_mps2, robot.max_decel_mps2,
            robot.max_jerk_mps3, _CREEP_SHARE * robot.min_speed_mps,
        )  # fmt: skip
        self._yaw = _Limits(
            robot.max_yaw_rate_radps, 0.0, turn, turn, robot.max_yaw_jerk_radps3,
            _CREEP_SHARE * robot.min_yaw_rate_radps,
        )  # fmt: skip

    def smooth(self, wanted: Twist2D, dt_s: float) -> RampStep:
        """A step towards `wanted` within speed, acceleration, braking and jerk.

        Jerk is not counted for a step from or to standstill that is as small as the motors' dead-band.
        """
        sent = self.last.twist
        v, a = _smooth(
            complex(sent.vx_mps, sent.vy_mps),
            self.last.accel,
            complex(wanted.vx_mps, wanted.vy_mps),
            dt_s,
            self._linear,
        )
        w, turn = _smooth(
            complex(sent.wz_radps), self.last.yaw_accel, complex(wanted.wz_radps), dt_s, self._yaw
        )
        return RampStep(Twist2D(v.real, v.imag, w.real), a, turn)

    def brisk(self, wanted: Twist2D, dt_s: float) -> RampStep:
        """The same within acceleration and braking only: for safety. What comes after begins without acceleration."""
        sent = self.last.twist
        dx, dy = wanted.vx_mps - sent.vx_mps, wanted.vy_mps - sent.vy_mps
        change = math.hypot(dx, dy)
        braking = wanted.speed_mps <= sent.speed_mps
        most = (self._linear.down if braking else self._linear.up) * dt_s
        part = 1.0 if change <= most else most / change
        most_turn = self._yaw.up * dt_s
        turn = max(-most_turn, min(most_turn, wanted.wz_radps - sent.wz_radps))
        if part == 1.0 and abs(turn) < most_turn:
            return RampStep(wanted)
        return RampStep(Twist2D(sent.vx_mps + part * dx, sent.vy_mps + part * dy, sent.wz_radps + turn))


def _smooth(v: complex, a: complex, wanted: complex, dt_s: float, limits: _Limits) -> tuple[complex, complex]:
    """Velocity and acceleration after this tick."""
    off = wanted - v
    if not a and abs(off) < _SAME:
        return wanted, 0j
    if dt_s < _SHORTEST_TICK_S:
        return v, a
    if not wanted and abs(v) <= min(limits.creep, limits.down * dt_s):
        return 0j, 0j
    if not v and not a:
        least = min(limits.creep, limits.up * dt_s)
        if least > limits.jerk * dt_s * dt_s:
            return (wanted if abs(wanted) <= least else wanted / abs(wanted) * least), 0j
    step = limits.jerk * dt_s
    most = limits.down if abs(wanted) <= abs(v) else limits.up
    reach = abs(off)
    target = off / reach * min(_largest(reach, dt_s, step), most) if reach > 0.0 else 0j
    away = abs(target - a)
    best = target if away <= step else a + (target - a) * (step / away)
    if not _keeps(v, best, dt_s, step, limits):
        best = _nearest_that_keeps(v, a, best, dt_s, step, limits)
    after = v + best * dt_s
    return (wanted if abs(wanted - after) < _SAME else after), best


def _nearest_that_keeps(
    v: complex, a: complex, wish: complex, dt_s: float, step: float, limits: _Limits
) -> complex:
    """Between ramping the acceleration down, which is always right, and what was wished for."""
    down = a * max(0.0, 1.0 - step / abs(a)) if a else 0j
    low, high = 0.0, 1.0
    for _ in range(_BISECTIONS):
        middle = 0.5 * (low + high)
        if _keeps(v, down + middle * (wish - down), dt_s, step, limits):
            low = middle
        else:
            high = middle
    return down + low * (wish - down)


def _keeps(v: complex, a: complex, dt_s: float, step: float, limits: _Limits) -> bool:
    """Whether all limits can be kept for good with this acceleration in this tick.

    More than the limit of speeding up is for braking only: the speed must fall all the way to where it comes to rest.
    """
    size = abs(a)
    n = math.floor(size / step)
    on = a / size * dt_s * (n * size - 0.5 * step * n * (n + 1)) if n else 0j
    rest = v + a * dt_s + on
    slows = a.real * rest.real + a.imag * rest.imag <= 0.0
    return (size <= limits.up + _ROUNDING or slows) and (limits.allow(rest) or not limits.allow(v))


def _largest(change: float, dt_s: float, step: float) -> float:
    """The largest acceleration in this tick that, ramped down by `step` a tick, changes the velocity by no more."""
    n = math.floor(0.5 * (math.sqrt(1.0 + 8.0 * change / (step * dt_s)) - 1.0))
    return (change / dt_s + 0.5 * step * n * (n + 1)) / (n + 1)
