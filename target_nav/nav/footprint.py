"""The robot's body as a rectangle round base_link, and what it would touch.

Everything that asks "does it fit?" asks here, so avoidance, approach and the limiter cannot disagree about the body.
Points are obstacles in base_link, shape (N, 2), metres.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from target_nav.config import RobotConfig
from target_nav.state.types import FloatArray, Twist2D

FAR_M = 1e6
"""Free distance where nothing is in the way."""
TOUCH_M = 1e-4
"""A point this near to a margin counts as outside it, so that rounding does not glue the robot to a wall."""
_PARALLEL = 1e-9


def as_points(points_m: FloatArray) -> FloatArray:
    """Points as finite float64 of shape (N, 2): an empty array of any shape becomes (0, 2), non-finite rows go."""
    points = np.asarray(points_m, dtype=np.float64)
    if points.size == 0:
        return points if points.shape == (0, 2) else np.empty((0, 2))
    if points.ndim != 2 or points.shape[1] != 2:
        points = points.reshape(-1, 2)
    finite = np.isfinite(points).all(axis=1)
    return points if finite.all() else points[finite]


@dataclass(frozen=True)
class Footprint:
    front_m: float
    rear_m: float
    half_width_m: float

    @classmethod
    def of(cls, robot: RobotConfig) -> Footprint:
        return cls(robot.front_m, robot.rear_m, robot.half_width_m)

    @property
    def circumscribed_radius_m(self) -> float:
        return math.hypot(max(self.front_m, self.rear_m), self.half_width_m)

    def clearances_m(self, points_m: FloatArray) -> FloatArray:
        """Distance of each point to the body's outline, shape (N,); negative inside the body."""
        return _outline_distance(self, points_m[:, 0], points_m[:, 1])

    def free_distances_m(
        self, points_m: FloatArray, directions_rad: FloatArray, margin_m: float
    ) -> FloatArray:
        """How far the body can translate without turning in each direction, shape (K,); `FAR_M` if nothing is met.

        The body is grown by `margin_m` (square corners). A point that is already inside the margin only forbids the
        directions that come nearer to it: its own margin shrinks to what is left. Slab method of ray and box.
        """
        if len(points_m) == 0:
            return np.full(len(directions_rad), FAR_M)
        x, y = points_m[:, 0], np.abs(points_m[:, 1])
        left_over = np.maximum(np.maximum(x - self.front_m, -self.rear_m - x), y - self.half_width_m)
        margin = np.minimum(margin_m, left_over - TOUCH_M)
        c, s = np.cos(directions_rad), np.sin(directions_rad)
        # A direction to the right is one to the left in a mirrored world, to the last bit; -0.0 is to the right.
        aside = np.copysign(1.0, s)[:, None] * points_m[:, 1]
        ahead = np.where(c > 0, self.front_m, -self.rear_m)
        behind = np.where(c > 0, -self.rear_m, self.front_m)
        inv_c, inv_s = (1.0 / _away_from_zero(c))[:, None], (1.0 / np.maximum(np.abs(s), _PARALLEL))[:, None]
        grow_x, grow_y = np.abs(inv_c) * margin, inv_s * margin
        enter = np.maximum(
            (x - ahead[:, None]) * inv_c - grow_x, (aside - self.half_width_m) * inv_s - grow_y
        )
        leave = np.minimum(
            (x - behind[:, None]) * inv_c + grow_x, (aside + self.half_width_m) * inv_s + grow_y
        )
        met = (enter < leave) & (leave > 0.0) & (enter > -TOUCH_M)
        free: FloatArray = np.where(met, np.maximum(enter, 0.0), FAR_M).min(axis=1)
        return free

    def free_distances_turned_m(
        self, points_m: FloatArray, directions_rad: FloatArray, margin_m: float
    ) -> FloatArray:
        """The same for a body that first turns its front to each direction; 0 where it could not stand turned so."""
        if len(points_m) == 0:
            return np.full(len(directions_rad), FAR_M)
        c, s = np.cos(directions_rad)[:, None], np.sin(directions_rad)[:, None]
        x = c * points_m[:, 0] + s * points_m[:, 1]
        y = np.abs(c * points_m[:, 1] - s * points_m[:, 0])
        left_over = np.maximum(np.maximum(x - self.front_m, -self.rear_m - x), y - self.half_width_m)
        margin = np.minimum(margin_m, left_over - TOUCH_M)
        met = (y < self.half_width_m + margin) & (x > 0.0)
        free = np.where(met, np.maximum(x - self.front_m - margin, 0.0), FAR_M)
        turned: FloatArray = np.where(left_over < 0.0, 0.0, free).min(axis=1)
        return turned

    def clearances_along_m(self, points_m: FloatArray, twist: Twist2D, times_s: FloatArray) -> FloatArray:
        """Distance of each point to the body after moving with a constant twist, shape (T, N).

        Constant body velocity along an arc: Lynch and Park, Modern Robotics, section 3.2.
        """
        turn = twist.wz_radps * times_s
        small = np.abs(turn) < 1e-6
        safe = np.where(small, 1.0, turn)
        along = np.where(small, 1.0, np.sin(safe) / safe)
        across = np.where(small, 0.5 * turn, (1.0 - np.cos(safe)) / safe)
        x0 = (along * twist.vx_mps - across * twist.vy_mps) * times_s
        y0 = (across * twist.vx_mps + along * twist.vy_mps) * times_s
        c, s = np.cos(turn)[:, None], np.sin(turn)[:, None]
        dx, dy = points_m[:, 0] - x0[:, None], points_m[:, 1] - y0[:, None]
        return _outline_distance(self, c * dx + s * dy, c * dy - s * dx)


def _outline_distance(body: Footprint, x_m: FloatArray, y_m: FloatArray) -> FloatArray:
    dx = np.maximum(x_m - body.front_m, -body.rear_m - x_m)
    dy = np.abs(y_m) - body.half_width_m
    outside = np.hypot(np.maximum(dx, 0.0), np.maximum(dy, 0.0))
    distance: FloatArray = outside + np.minimum(np.maximum(dx, dy), 0.0)
    return distance


def _away_from_zero(values: FloatArray) -> FloatArray:
    return np.where(np.abs(values) < _PARALLEL, _PARALLEL, values)
