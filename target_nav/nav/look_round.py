"""Turns once all the way round, whatever comes into view, and then faces the nearest target that it saw."""

from __future__ import annotations

import math

from target_nav.config import Config
from target_nav.nav.guarded import GuardedSkill
from target_nav.nav.room import Room
from target_nav.nav.skill import SkillStatus, SkillStep, View
from target_nav.nav.speed import YawControl, over_dead_band, within_limits
from target_nav.state.types import STOP, Twist2D
from target_nav.utils.frames import to_child, wrap_angle

FRAMES_IN_VIEW = 8
"""A target that crosses the picture is seen so many times at least: that bounds the yaw rate."""
JUST_SEEN_S = 0.6
FACING_RAD = 0.15


class LookRound(GuardedSkill):
    def __init__(self, config: Config, *, time_limit_s: float, yaw_rate_radps: float) -> None:
        """Succeeds facing the nearest confirmed target of the turn; fails if there was none, or after `time_limit_s`.

        The yaw rate is cut to what the camera's field of view and frame rate can follow.
        """
        camera, robot = config.camera, config.robot
        most = 2.0 * camera.half_fov_rad * camera.rate_hz / FRAMES_IN_VIEW
        self._rate_radps = max(min(yaw_rate_radps, most, robot.max_yaw_rate_radps), robot.min_yaw_rate_radps)
        self._robot = robot
        self._time_limit_s = time_limit_s
        self._room = Room(config)
        self._yaw = YawControl(robot, top_radps=self._rate_radps, rest_rad=0.05)

    def _begin(self, view: View) -> None:
        self._started_s = view.now_s
        self._last_yaw_rad = view.pose_in_odom.yaw_rad
        self._turned_rad = 0.0
        self._has_turned = False
        self._nearest_m: tuple[float, float] | None = None
        self._yaw.reset()

    def _step(self, view: View) -> SkillStep:
        self._turned_rad += wrap_angle(view.pose_in_odom.yaw_rad - self._last_yaw_rad)
        self._last_yaw_rad = view.pose_in_odom.yaw_rad
        self._remember(view)
        passed_s = view.now_s - self._started_s
        if passed_s > self._time_limit_s:
            words = f"turned {math.degrees(self._turned_rad):.0f} deg (limit {self._time_limit_s:.1f} s)"
            return SkillStep(SkillStatus.FAILURE, STOP, words)
        self._has_turned = self._has_turned or self._turned_rad >= 2.0 * math.pi
        if not self._has_turned:
            words = f"looking round, turned {math.degrees(self._turned_rad):.0f} deg"
            return SkillStep(SkillStatus.RUNNING, self._turn(view, self._rate_radps), words)
        if self._nearest_m is None:
            return SkillStep(SkillStatus.FAILURE, STOP, f"nothing to be seen all round in {passed_s:.1f} s")
        x, y = to_child(view.pose_in_odom, *self._nearest_m)
        bearing_rad, words = math.atan2(y, x), f"the nearest is {math.hypot(x, y):.2f} m off"
        if abs(bearing_rad) < FACING_RAD:
            return SkillStep(SkillStatus.SUCCESS, STOP, words)
        rate = self._yaw.rate_radps(bearing_rad, view.twist_in_base.wz_radps)
        return SkillStep(SkillStatus.RUNNING, self._turn(view, rate), f"{words}, turning to it")

    def _remember(self, view: View) -> None:
        track = view.track
        if track is None or not track.confirmed or view.now_s - track.last_seen_s > JUST_SEEN_S:
            return
        here = (view.pose_in_odom.x_m, view.pose_in_odom.y_m)
        place = (track.x_m, track.y_m)
        if self._nearest_m is None or math.dist(here, place) < math.dist(here, self._nearest_m):
            self._nearest_m = place

    def _turn(self, view: View, rate_radps: float) -> Twist2D:
        away = self._room.for_turning(view.obstacles_in_base_m)
        twist = over_dead_band(Twist2D(away.vx_mps, away.vy_mps, rate_radps), self._robot)
        return within_limits(twist, self._robot)
