"""Looks round on the spot: first to where the target was last, then on in the same direction for a turn and a bit."""

from __future__ import annotations

import math

from target_nav.config import Config
from target_nav.nav.glimpse import Glimpse, Sight, bearing_to
from target_nav.nav.guarded import GuardedSkill
from target_nav.nav.room import Room
from target_nav.nav.skill import SkillStatus, SkillStep, View
from target_nav.nav.speed import over_dead_band, within_limits
from target_nav.state.types import STOP, Twist2D
from target_nav.utils.frames import to_child, wrap_angle

_TURNS = 1.15
"""A full turn and a bit: the picture's width, for what stood at its edge when the turn began."""
_FRAMES_IN_VIEW = 8
"""A target that crosses the picture is seen so many times at least: that bounds the yaw rate."""


class TurnSearch(GuardedSkill):
    def __init__(self, config: Config, *, time_limit_s: float, yaw_rate_radps: float) -> None:
        """Succeeds with a confirmed track seen just now; fails after `time_limit_s` or 1.15 turns.

        The yaw rate is cut to what the camera's field of view and frame rate can follow.
        """
        camera, robot = config.camera, config.robot
        most = 2.0 * camera.half_fov_rad * camera.rate_hz / _FRAMES_IN_VIEW
        self._rate_radps = max(min(yaw_rate_radps, most, robot.max_yaw_rate_radps), robot.min_yaw_rate_radps)
        self._robot = robot
        self._time_limit_s = time_limit_s
        self._room = Room(config)
        self._glimpse = Glimpse(robot)
        self._last_known_m: tuple[float, float] | None = None

    def _begin(self, view: View) -> None:
        self._glimpse.reset()
        self._started_s = view.now_s
        self._last_yaw_rad = view.pose_in_odom.yaw_rad
        self._turned_rad = 0.0
        self._remember(view)
        self._sense = 1.0
        if self._last_known_m is not None:
            x, y = to_child(view.pose_in_odom, *self._last_known_m)
            self._sense = math.copysign(1.0, math.atan2(y, x))

    def _step(self, view: View) -> SkillStep:
        self._turned_rad += self._sense * wrap_angle(view.pose_in_odom.yaw_rad - self._last_yaw_rad)
        self._last_yaw_rad = view.pose_in_odom.yaw_rad
        self._remember(view)
        passed_s = view.now_s - self._started_s
        sight = self._glimpse.look(view)
        if sight is Sight.FOUND and view.track is not None:
            where = f"{view.track.range_m:.2f} m off, {math.degrees(bearing_to(view, view.track)):.0f} deg"
            return SkillStep(SkillStatus.SUCCESS, STOP, f"found after {passed_s:.1f} s, {where}")
        if passed_s > self._time_limit_s:
            return self._failed(f"limit {self._time_limit_s:.1f} s", passed_s)
        if sight is Sight.LOOKING:
            return SkillStep(SkillStatus.RUNNING, self._glimpse.twist(view), "something is there, looking")
        if self._turned_rad >= _TURNS * 2.0 * math.pi:
            return self._failed(f"limit {_TURNS:.2f} turns", passed_s)
        away = self._room.for_turning(view.obstacles_in_base_m)
        twist = Twist2D(away.vx_mps, away.vy_mps, self._sense * self._rate_radps)
        words = f"turned {math.degrees(self._turned_rad):.0f} deg" + ("" if away == STOP else ", making room")
        return SkillStep(
            SkillStatus.RUNNING, within_limits(over_dead_band(twist, self._robot), self._robot), words
        )

    def _remember(self, view: View) -> None:
        if view.track is not None:
            self._last_known_m = (view.track.x_m, view.track.y_m)

    def _failed(self, limit: str, passed_s: float) -> SkillStep:
        words = f"not found: turned {math.degrees(self._turned_rad):.0f} deg in {passed_s:.1f} s ({limit})"
        return SkillStep(SkillStatus.FAILURE, STOP, words)
