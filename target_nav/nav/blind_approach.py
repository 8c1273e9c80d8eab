"""The last metre: by dead reckoning to the stand-off in front of the target, for the camera no longer sees it whole.

The target's place in odom is frozen at the start and refined by what still measures it: the LiDAR in both directions,
the camera only across the line of sight. The base drives along a fixed heading, strafes lateral error out before the
end, slows down along a braking curve that never falls under the motors' dead-band, stops early by what it will still
coast, and corrects from standstill until it is there. A base that cannot strafe steers at the target instead.
"""

from __future__ import annotations

import math

import numpy as np

from target_nav.config import Config
from target_nav.nav.footprint import FAR_M, Footprint
from target_nav.nav.guarded import GuardedSkill
from target_nav.nav.skill import SkillStatus, SkillStep, View
from target_nav.nav.speed import YawControl, braking_speed_mps, over_dead_band, within_limits
from target_nav.nav.staging import without_own
from target_nav.state.types import STOP, Track, Twist2D
from target_nav.utils.frames import to_child, wrap_angle

_RANGED_RECENTLY_S = 0.6
"""Three turns of the LiDAR."""
_SEEN_RECENTLY_S = 0.4
_JUMP_M, _JUMP_FOR_S = 0.15, 0.5
"""A track that says so long that the target is that far from where it was: it was pushed aside."""
_COAST_S = 0.10
"""What the drivetrain goes on for after a command to stop."""
_ALONG_M, _ACROSS_M, _YAW_RAD = 0.006, 0.008, 0.03
"""Where driving stops ..."""
_ALONG_DONE_M, _ACROSS_DONE_M, _YAW_DONE_RAD = 0.012, 0.015, 0.07
"""... and within which a standing base is there; between the two it is left alone."""
_STILL_MPS, _STILL_RADPS, _STILL_FOR_S = 0.01, 0.03, 0.25
_STRAIGHTEN_M = 0.10
"""Nearer to the end than this, lateral error goes first."""
_AIM_AGAIN_RAD = math.radians(25.0)
_TURN_FIRST_RAD = 0.5
_BLOCKED_FOR_S = 1.0
_OWN_RADIUS_M = 0.08
_ACROSS_GAIN_HZ, _ACROSS_TOP_MPS = 1.5, 0.10
_DECEL_SHARE = 0.15
"""Of the braking limit: the last decimetres are driven gently, for the LiDAR measures five times a second only."""


class BlindApproach(GuardedSkill):
    def __init__(
        self,
        config: Config,
        *,
        stand_off_m: float,
        speed_mps: float,
        timeout_s: float,
        target_radius_m: float,
    ) -> None:
        """Succeeds standing with the front edge `stand_off_m` from the target's surface, facing it.

        Fails after `timeout_s`, when something stands in between, and when the target was pushed aside.
        """
        self._robot = config.robot
        self._avoid = config.avoid
        self._body = Footprint.of(config.robot)
        self._holonomic = config.robot.drive != "differential"
        self._distance_m = config.robot.front_m + stand_off_m + target_radius_m
        self._speed_mps, self._timeout_s = speed_mps, timeout_s
        self._yaw = YawControl(config.robot, top_radps=0.5, rest_rad=_YAW_RAD / 3.0)

    def _begin(self, view: View) -> None:
        self._started_s = view.now_s
        self._target_m: tuple[float, float] | None = None
        self._heading_rad = view.pose_in_odom.yaw_rad
        self._jumped_since_s: float | None = None
        self._blocked_since_s: float | None = None
        self._still_since_s: float | None = None
        self._yaw.reset()
        if view.track is not None:
            self._target_m = (view.track.x_m, view.track.y_m)
            self._aim(view)

    def _step(self, view: View) -> SkillStep:
        if self._target_m is None:
            return SkillStep(
                SkillStatus.FAILURE, STOP, "no target to approach: there was no track at the start"
            )
        pushed = self._refine(view, view.track)
        if pushed:
            return SkillStep(SkillStatus.FAILURE, STOP, pushed)
        along_m, across_m, yaw_error = self._errors(view)
        passed_s = view.now_s - self._started_s
        if passed_s > self._timeout_s:
            words = f"timed out after {passed_s:.1f} s: {along_m:.3f} m to go, {across_m:.3f} m aside"
            return SkillStep(SkillStatus.FAILURE, STOP, words)
        blocked = self._blocked(view, along_m, across_m, yaw_error)
        if blocked:
            return SkillStep(SkillStatus.FAILURE, STOP, blocked)
        twist = self._twist(view, along_m, across_m, yaw_error)
        if self._there(view, twist, along_m, across_m, yaw_error):
            words = f"standing {along_m:+.3f} m from the stand-off, {across_m:+.3f} m aside"
            return SkillStep(SkillStatus.SUCCESS, STOP, words)
        return SkillStep(SkillStatus.RUNNING, twist, f"{along_m:.2f} m to go")

    def _refine(self, view: View, track: Track | None) -> str:
        """Take over what still measures the target; why to give up, or nothing."""
        if track is None or not track.confirmed or self._target_m is None:
            return ""
        ranged = view.now_s - track.last_ranged_s <= _RANGED_RECENTLY_S
        seen = view.now_s - track.last_seen_s <= _SEEN_RECENTLY_S
        dx, dy = track.x_m - self._target_m[0], track.y_m - self._target_m[1]
        if ranged and math.hypot(dx, dy) > _JUMP_M:
            self._jumped_since_s = view.now_s if self._jumped_since_s is None else self._jumped_since_s
            if view.now_s - self._jumped_since_s >= _JUMP_FOR_S:
                return f"target pushed aside: it is {math.hypot(dx, dy):.2f} m from where it was"
            return ""
        self._jumped_since_s = None
        if ranged:
            self._target_m = (track.x_m, track.y_m)
        elif seen:
            # A clipped box says nothing about range, but its bearing is good.
            c, s = self._sight(view)
            across = c * dy - s * dx
            self._target_m = (self._target_m[0] - s * across, self._target_m[1] + c * across)
        return ""

    def _sight(self, view: View) -> tuple[float, float]:
        """Unit vector from base_link to the target, in odom."""
        assert self._target_m is not None
        dx, dy = self._target_m[0] - view.pose_in_odom.x_m, self._target_m[1] - view.pose_in_odom.y_m
        length = max(math.hypot(dx, dy), 1e-6)
        return dx / length, dy / length

    def _aim(self, view: View) -> None:
        c, s = self._sight(view)
        self._heading_rad = math.atan2(s, c)

    def _errors(self, view: View) -> tuple[float, float, float]:
        """Way still to go along the heading, offset across it (left positive), and heading error."""
        assert self._target_m is not None
        pose = view.pose_in_odom
        dx, dy = self._target_m[0] - pose.x_m, self._target_m[1] - pose.y_m
        if not self._holonomic or abs(wrap_angle(math.atan2(dy, dx) - self._heading_rad)) > _AIM_AGAIN_RAD:
            self._aim(view)
        c, s = math.cos(self._heading_rad), math.sin(self._heading_rad)
        yaw_error = wrap_angle(self._heading_rad - pose.yaw_rad)
        return c * dx + s * dy - self._distance_m, c * dy - s * dx, yaw_error

    def _blocked(self, view: View, along_m: float, across_m: float, yaw_error: float) -> str:
        """Whether something has stood between the body and its place for a while."""
        way_m = math.hypot(along_m, across_m)
        assert self._target_m is not None
        target = to_child(view.pose_in_odom, *self._target_m)
        points = without_own(view.obstacles_in_base_m, target, _OWN_RADIUS_M)
        if len(points) == 0 or way_m < _ALONG_DONE_M or abs(yaw_error) > _TURN_FIRST_RAD:
            self._blocked_since_s = None
            return ""
        direction = math.atan2(across_m, along_m) + yaw_error
        # A little less than navigation asked for, or what it has just allowed would fail here.
        margin_m = max(self._avoid.stop_clearance_m - 0.005, 0.0)
        free_m = float(self._body.free_distances_m(points, np.array([direction]), margin_m)[0])
        if free_m >= min(way_m - _ALONG_DONE_M, FAR_M):
            self._blocked_since_s = None
            return ""
        self._blocked_since_s = view.now_s if self._blocked_since_s is None else self._blocked_since_s
        if view.now_s - self._blocked_since_s < _BLOCKED_FOR_S:
            return ""
        return f"obstacle in between: {free_m:.2f} m free, {way_m:.2f} m to go"

    def _twist(self, view: View, along_m: float, across_m: float, yaw_error: float) -> Twist2D:
        c, s = math.cos(yaw_error), math.sin(yaw_error)
        moved = view.twist_in_base
        # What it will still coast, along and across the heading: base_link's velocity turned by the heading error.
        coast_along = _COAST_S * (c * moved.vx_mps + s * moved.vy_mps)
        coast_across = _COAST_S * (c * moved.vy_mps - s * moved.vx_mps)
        wz = self._yaw.rate_radps(yaw_error, moved.wz_radps)
        along = self._along_mps(along_m, along_m - coast_along)
        across = self._across_mps(across_m, across_m - coast_across) if self._holonomic else 0.0
        if self._blocked_since_s is not None:
            along = min(along, 0.0)
        if across and abs(along_m) < _STRAIGHTEN_M:
            along *= max(0.0, 1.0 - (abs(across_m) - _ACROSS_M) / (3.0 * _ACROSS_M))
        facing = max(0.0, 1.0 - abs(yaw_error) / _TURN_FIRST_RAD)
        along, across = along * facing, across * facing
        vx, vy = c * along - s * across, s * along + c * across
        if not self._holonomic:
            vx, vy = along, 0.0
        return within_limits(over_dead_band(Twist2D(vx, vy, wz), self._robot), self._robot)

    def _along_mps(self, error_m: float, after_coast_m: float) -> float:
        if abs(error_m) < _ALONG_M or error_m * after_coast_m <= 0.0 or abs(after_coast_m) < 0.5 * _ALONG_M:
            return 0.0
        decel = _DECEL_SHARE * self._robot.max_decel_mps2
        top = self._speed_mps if error_m > 0.0 else min(self._speed_mps, 0.05)
        speed = min(top, max(braking_speed_mps(abs(after_coast_m), decel, 2.0 * _COAST_S), self._least_mps))
        return math.copysign(speed, error_m)

    def _across_mps(self, error_m: float, after_coast_m: float) -> float:
        if abs(error_m) < _ACROSS_M or error_m * after_coast_m <= 0.0:
            return 0.0
        speed = min(max(_ACROSS_GAIN_HZ * abs(after_coast_m), self._least_mps), _ACROSS_TOP_MPS)
        return math.copysign(speed, error_m)

    @property
    def _least_mps(self) -> float:
        """A little above the dead-band: exactly at it, half the motors would stand."""
        return min(1.2 * self._robot.min_speed_mps, self._robot.max_speed_mps)

    def _there(self, view: View, twist: Twist2D, along_m: float, across_m: float, yaw_error: float) -> bool:
        """Standing long enough, within the wider tolerance."""
        moved = view.twist_in_base
        still = twist == STOP and moved.speed_mps < _STILL_MPS and abs(moved.wz_radps) < _STILL_RADPS
        if not still:
            self._still_since_s = None
            return False
        self._still_since_s = view.now_s if self._still_since_s is None else self._still_since_s
        aside_ok = abs(across_m) <= _ACROSS_DONE_M
        placed = abs(along_m) <= _ALONG_DONE_M and aside_ok and abs(yaw_error) <= _YAW_DONE_RAD
        return placed and view.now_s - self._still_since_s >= _STILL_FOR_S
