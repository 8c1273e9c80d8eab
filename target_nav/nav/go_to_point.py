"""Drives to a place in odom round obstacles, and stands there. What comes into view does not matter."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np

from target_nav.config import Config
from target_nav.nav.drive import Driver
from target_nav.nav.drive_step import Drive
from target_nav.nav.guarded import GuardedSkill
from target_nav.nav.progress import Progress
from target_nav.nav.recovery import Recovery
from target_nav.nav.skill import SkillStatus, SkillStep, View
from target_nav.state.types import STOP, Avoidance, FloatArray

if TYPE_CHECKING:
    from target_nav.nav.arc_drive import ArcDriver

_STANDING_S, _NO_NEARER_S = 4.0, 25.0
_ATTEMPTS = 3
_MORE_ROOM_M = 0.06
_AIM_SHARE = 0.5
"""Of what counts as there: the driving ends no farther off."""


class GoToPoint(GuardedSkill):
    def __init__(
        self,
        config: Config,
        *,
        x_m: float,
        y_m: float,
        within_m: float,
        speed_mps: float,
        time_limit_s: float,
    ) -> None:
        """Succeeds with base_link within `within_m` of the place; fails after `time_limit_s`, or when nothing comes of
        the driving.
        """
        self._turning_m = config.robot.circumscribed_radius_m + config.avoid.stop_clearance_m
        self._place_m = (x_m, y_m)
        self._at_goal_m = _AIM_SHARE * within_m
        self._within_m, self._speed_mps, self._time_limit_s = within_m, speed_mps, time_limit_s
        self._driver = _driver_for(config)
        self._progress = Progress(standing_s=_STANDING_S, no_nearer_s=_NO_NEARER_S)
        self._recovery = Recovery(config, _ATTEMPTS)
        # driven to more closely than asked for, or it would stop right at the edge
        self._spots: FloatArray = np.array([[x_m, y_m, 0.0]])

    @property
    def avoidance(self) -> Avoidance | None:
        """What VFH saw and chose when it last drove."""
        return self._driver.avoidance

    def _begin(self, view: View) -> None:
        self._started_s = view.now_s
        self._could_turn = True
        self._driver.forget()
        self._progress.begin()
        self._recovery.begin()

    def _step(self, view: View) -> SkillStep:
        pose = view.pose_in_odom
        away_m = math.dist((pose.x_m, pose.y_m), self._place_m)
        if away_m <= self._within_m:
            return SkillStep(SkillStatus.SUCCESS, STOP, f"there, {away_m:.2f} m off")
        if view.now_s - self._started_s > self._time_limit_s:
            words = f"{away_m:.2f} m off after {self._time_limit_s:.1f} s (limit)"
            return SkillStep(SkillStatus.FAILURE, STOP, words)
        back = self._recovery.step(view)
        if back is not None:
            return SkillStep(SkillStatus.RUNNING, back, "backing off")
        drive = self._drive(view)
        stalled = self._progress.stalled(view.now_s, pose, drive.cost_to_go_m)
        if not stalled:
            words = f"{away_m:.2f} m to go" + (f", {drive.reason}" if drive.reason else "")
            return SkillStep(SkillStatus.RUNNING, drive.twist, words)
        if self._recovery.is_used_up:
            why = "no way" if math.isinf(drive.cost_to_go_m) else stalled
            return SkillStep(SkillStatus.FAILURE, STOP, f"stuck {away_m:.2f} m off: {why}")
        self._recovery.start(view, self._driver.next_m)
        self._driver.forget()
        self._progress.restart()
        return SkillStep(
            SkillStatus.RUNNING, STOP, f"{stalled}: recovery {self._recovery.used} of {_ATTEMPTS}"
        )

    def _drive(self, view: View) -> Drive:
        shunned = self._recovery.shunned(view)
        if isinstance(self._driver, Driver):
            # looks where it goes, but where there is no room to turn it goes sideways as it stands
            face_rad = None if self._can_turn(view.obstacles_in_base_m) else 0.0
            return self._driver.drive(
                view,
                lambda _: self._spots,
                speed_mps=self._speed_mps,
                face_rad=face_rad,
                extra_points_m=shunned,
                at_goal_m=self._at_goal_m,
            )
        return self._driver.drive(
            view,
            lambda _: self._spots,
            speed_mps=self._speed_mps,
            extra_points_m=shunned,
            at_goal_m=self._at_goal_m,
        )

    def _can_turn(self, points_m: FloatArray) -> bool:
        """Once it could not, it needs a good deal more room to begin again: half turned it would be stuck."""
        near_m = float(np.hypot(points_m[:, 0], points_m[:, 1]).min()) if len(points_m) else math.inf
        self._could_turn = near_m > self._turning_m + (0.0 if self._could_turn else _MORE_ROOM_M)
        return self._could_turn


def _driver_for(config: Config) -> Driver | ArcDriver:
    """A base that cannot strafe is driven in arcs."""
    if config.robot.drive != "differential":
        return Driver(config)
    # brings in scipy, which the other kind of base does not need
    from target_nav.nav.arc_drive import ArcDriver

    return ArcDriver(config)
