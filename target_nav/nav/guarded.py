"""The frame round every skill that moves: what is not finite never reaches its arithmetic.

A pose or a velocity that is not finite, or absurd, stops the robot for the tick; a track that is not finite is none;
obstacle points that are not finite are left out. The skill proper begins with the first tick that can be used.
"""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from dataclasses import replace

import numpy as np

from target_nav.nav.footprint import as_points
from target_nav.nav.skill import SkillStatus, SkillStep, View
from target_nav.state.types import STOP

_NONSENSE_M = 1e6
"""Nothing on wheels gets so far: such a number is an error, and squared it would overflow."""


class GuardedSkill(ABC):
    """Implements `Skill`; subclasses write `_begin` and `_step` and are handed usable views only."""

    def start(self, view: View) -> None:
        self._has_begun = False
        if not _problem(view):
            self._begin(_cleaned(view))
            self._has_begun = True

    def step(self, view: View) -> SkillStep:
        problem = _problem(view)
        if problem:
            return SkillStep(SkillStatus.RUNNING, STOP, problem)
        usable = _cleaned(view)
        if not self._has_begun:
            self._begin(usable)
            self._has_begun = True
        return self._step(usable)

    @abstractmethod
    def _begin(self, view: View) -> None: ...

    @abstractmethod
    def _step(self, view: View) -> SkillStep: ...


def _problem(view: View) -> str:
    """Why nothing can be decided in this tick, or nothing."""
    pose = view.pose_in_odom
    if not (pose.is_finite() and abs(pose.x_m) < _NONSENSE_M and abs(pose.y_m) < _NONSENSE_M):
        return f"pose ({pose.x_m:g}, {pose.y_m:g}) m is not finite or out of this world; is odometry running?"
    if not view.twist_in_base.is_finite():
        return "velocity not finite; is odometry running?"
    if not math.isfinite(view.now_s):
        return f"time is {view.now_s}; it must be finite"
    return ""


def _cleaned(view: View) -> View:
    points = as_points(view.obstacles_in_base_m)
    track = view.track
    if track is not None and not (
        np.isfinite(track.covariance_m2).all()
        and abs(track.x_m) < _NONSENSE_M
        and abs(track.y_m) < _NONSENSE_M
    ):
        track = None
    if points is view.obstacles_in_base_m and track is view.track:
        return view
    return replace(view, obstacles_in_base_m=points, track=track)
