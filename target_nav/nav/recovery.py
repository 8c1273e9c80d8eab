"""When nothing comes of the driving: back off to where there is room, and keep off the place where it stuck.

Keeping off is what chooses the other side next time. The number of attempts is bounded.
"""

from __future__ import annotations

import math

import numpy as np

from target_nav.config import Config
from target_nav.nav.room import Room
from target_nav.nav.skill import View
from target_nav.nav.speed import over_dead_band, within_limits
from target_nav.state.types import FloatArray, Twist2D
from target_nav.utils.frames import to_child, to_parent

_BACK_OFF_S, _BACK_OFF_M, _BACK_OFF_MPS = 3.0, 0.25, 0.08
_SHUN_S, _SHUN_RADIUS_M = 12.0, 0.1
_AHEAD_M = 0.15
"""The place that is kept off lies so far before the front edge."""
_RING = np.column_stack([np.cos(np.arange(8) * math.pi / 4.0), np.sin(np.arange(8) * math.pi / 4.0)])
_NOTHING: FloatArray = np.empty((0, 2))


class Recovery:
    def __init__(self, config: Config, attempts: int) -> None:
        self._robot = config.robot
        self._room = Room(config)
        self.attempts = attempts
        self.begin()

    def begin(self) -> None:
        self.used = 0
        self._until_s = self._shun_until_s = -math.inf
        self._shunned_m: tuple[float, float] | None = None

    @property
    def is_used_up(self) -> bool:
        return self.used >= self.attempts

    def start(self, view: View, next_in_odom_m: tuple[float, float] | None) -> None:
        """Back off from the way to `next_in_odom_m`, where it was heading; None if it had no way at all."""
        self.used += 1
        pose = view.pose_in_odom
        ahead = to_child(pose, *next_in_odom_m) if next_in_odom_m is not None else (1.0, 0.0)
        ahead_rad = math.atan2(ahead[1], ahead[0])
        direction, _ = self._room.widest(view.obstacles_in_base_m, ahead_rad + math.pi)
        self._direction_in_odom_rad = direction + pose.yaw_rad
        self._from = pose
        self._until_s = view.now_s + _BACK_OFF_S
        self._shunned_m = None
        if next_in_odom_m is not None:
            off_m = min(math.hypot(*ahead), self._robot.front_m + _AHEAD_M)
            self._shunned_m = to_parent(pose, off_m * math.cos(ahead_rad), off_m * math.sin(ahead_rad))
            self._shun_until_s = self._until_s + _SHUN_S

    def step(self, view: View) -> Twist2D | None:
        """The velocity to back off with; None when it is done, or none is on."""
        pose = view.pose_in_odom
        if view.now_s >= self._until_s:
            return None
        if math.hypot(pose.x_m - self._from.x_m, pose.y_m - self._from.y_m) >= _BACK_OFF_M:
            self._until_s = -math.inf
            return None
        direction = self._direction_in_odom_rad - pose.yaw_rad
        vy = _BACK_OFF_MPS * math.sin(direction)
        twist = Twist2D(_BACK_OFF_MPS * math.cos(direction), vy, 0.0)
        return over_dead_band(within_limits(twist, self._robot), self._robot)

    def shunned(self, view: View) -> FloatArray:
        """Points in base_link that stand for the place to keep off, shape (N, 2)."""
        if self._shunned_m is None or view.now_s >= self._shun_until_s:
            return _NOTHING
        centre = np.array(to_child(view.pose_in_odom, *self._shunned_m))
        return np.vstack([centre, centre + _SHUN_RADIUS_M * _RING])
