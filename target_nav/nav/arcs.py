"""Where a base that cannot strafe could be in the next second: many ways of driving, and how each would go.

Each way holds one forward speed and two turning rates, one after the other, reached within the limits of acceleration:
a curve and a counter-curve, which is what passing a post or entering a gap takes. A dynamic window (Fox, Burgard and
Thrun, "The Dynamic Window Approach to Collision Avoidance", 1997) with a second segment.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from target_nav.config import RobotConfig
from target_nav.nav.footprint import Footprint
from target_nav.nav.nearest_point import NearestPoint
from target_nav.state.types import FloatArray, Pose2D, Twist2D

STEP_S = 0.125
STEPS = 10
_FIRST_STEPS = 3
"""So long the first turning rate is held."""
_DEAD_TIME_S = 0.06
"""Tick, command and drivetrain: so long the present motion goes on."""
_SPEEDS = np.array([0.08, 0.18, 0.32, 0.5, 0.75, 1.0])
_FIRST = np.array([-1.0, -0.5, -0.22, -0.08, 0.0, 0.08, 0.22, 0.5, 1.0])
_SECOND = np.array([-0.7, 0.0, 0.7])
_SPIN = np.array([-1.0, -0.4, 0.4, 1.0])
_SIDEWAYS_MPS2 = 3.0
"""Centripetal acceleration: what wheels on a smooth floor hold."""


@dataclass(frozen=True, eq=False)
class Arcs:
    """K ways of driving, T + 1 moments each. Poses are in odom, the moment 0 is when a command takes effect."""

    speeds_mps: FloatArray
    """(K,)"""
    rates_radps: FloatArray
    """(K,): the first turning rate, which is the one to command."""
    x_m: FloatArray
    """(T + 1, K)"""
    y_m: FloatArray
    yaw_rad: FloatArray
    way_m: FloatArray
    """(T + 1, K): how far it has gone by then."""


def roll_out(pose: Pose2D, twist: Twist2D, robot: RobotConfig, top_mps: float) -> Arcs:
    """All ways from a pose and a velocity, none faster than `top_mps`."""
    speed, first, second = _commands(robot, top_mps)
    count = len(speed)
    v, w = np.full(count, twist.vx_mps), np.full(count, twist.wz_radps)
    yaw = np.full(count, pose.yaw_rad + _DEAD_TIME_S * twist.wz_radps)
    middle = pose.yaw_rad + 0.5 * _DEAD_TIME_S * twist.wz_radps
    x = np.full(count, pose.x_m + _DEAD_TIME_S * twist.vx_mps * math.cos(middle))
    y = np.full(count, pose.y_m + _DEAD_TIME_S * twist.vx_mps * math.sin(middle))
    way = np.zeros(count)
    xs, ys, yaws, ways = [x], [y], [yaw], [way]
    faster, slower = robot.max_accel_mps2 * STEP_S, robot.max_decel_mps2 * STEP_S
    turn = robot.max_yaw_accel_radps2 * STEP_S
    for step in range(STEPS):
        rate = first if step < _FIRST_STEPS else second
        # np.clip costs three times as much on arrays of this size
        next_v = np.minimum(np.maximum(speed, v - slower), v + faster)
        next_w = np.minimum(np.maximum(rate, w - turn), w + turn)
        length = 0.5 * STEP_S * (v + next_v)
        bend = 0.5 * STEP_S * (w + next_w)
        heading = yaw + 0.5 * bend
        x, y, yaw = x + length * np.cos(heading), y + length * np.sin(heading), yaw + bend
        way = way + np.abs(length)
        v, w = next_v, next_w
        xs.append(x)
        ys.append(y)
        yaws.append(yaw)
        ways.append(way)
    return Arcs(speed, first, np.stack(xs), np.stack(ys), np.stack(yaws), np.stack(ways))


def _commands(robot: RobotConfig, top_mps: float) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Speed, first and second turning rate of each way, shape (K,) each; turning on the spot comes last."""
    speeds = np.maximum(_SPEEDS * top_mps, min(robot.min_speed_mps, top_mps))
    most = np.minimum(robot.max_yaw_rate_radps, _SIDEWAYS_MPS2 / np.maximum(speeds, 1e-3))
    v, a, b = np.meshgrid(np.arange(len(speeds)), _FIRST, _SECOND, indexing="ij")
    index = v.ravel()
    spin = _SPIN * min(robot.max_yaw_rate_radps, 2.0)
    nothing = np.zeros(len(spin))
    return (
        np.concatenate([speeds[index], nothing]),
        np.concatenate([most[index] * a.ravel(), spin]),
        np.concatenate([most[index] * b.ravel(), spin]),
    )


def clearances_m(arcs: Arcs, near: NearestPoint, body: Footprint) -> FloatArray:
    """Room between the body's outline and the nearest points at each moment, shape (T + 1, K); negative inside.

    Points nearest to the middle and to the four corners are measured against the rectangle.
    """
    c, s = np.cos(arcs.yaw_rad), np.sin(arcs.yaw_rad)
    best: FloatArray = np.full(c.shape, np.inf)
    for ahead, left in (
        (0.5 * (body.front_m - body.rear_m), 0.0),
        (body.front_m, body.half_width_m),
        (body.front_m, -body.half_width_m),
        (-body.rear_m, body.half_width_m),
        (-body.rear_m, -body.half_width_m),
    ):
        px, py = near.nearest_to(arcs.x_m + c * ahead - s * left, arcs.y_m + s * ahead + c * left)
        dx, dy = px - arcs.x_m, py - arcs.y_m
        along, across = c * dx + s * dy, np.abs(c * dy - s * dx)
        over_x = np.maximum(along - body.front_m, -body.rear_m - along)
        over_y = across - body.half_width_m
        outside = np.sqrt(np.maximum(over_x, 0.0) ** 2 + np.maximum(over_y, 0.0) ** 2)
        np.minimum(best, outside + np.minimum(np.maximum(over_x, over_y), 0.0), out=best)
    return best
