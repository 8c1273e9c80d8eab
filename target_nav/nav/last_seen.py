"""The target while it is out of sight: where it was last, and when to give it up.

A target behind a box or out of the picture cannot be seen and is not missed for a while: that is what driving round
a box looks like. One that should be in plain sight and is not is lost after the limit.
"""

from __future__ import annotations

import math

import numpy as np

from target_nav.config import Config
from target_nav.nav.skill import View
from target_nav.state.types import Track
from target_nav.utils.frames import to_child

_JUST_NOW_S = 0.3
_HIDDEN_S = 12.0
"""So long a hidden target may stay unseen on top of the limit; at 0.15 m/s that is once round a big box."""
_HIDES_M = 0.08
"""A point so near to the line of sight hides the target: its own half width and a little."""
_BEFORE_TARGET_M = 0.15
_LONGEST_TICK_S = 0.2


class LastSeen:
    def __init__(self, config: Config, lost_after_s: float) -> None:
        self._half_fov_rad = config.camera.half_fov_rad
        self._lost_after_s = lost_after_s
        self.track: Track | None = None
        """The newest confirmed track, kept while the tracker has none."""

    def begin(self, now_s: float) -> None:
        self.track = None
        self._begun_s = now_s
        self._hidden_s = 0.0

    def lost(self, view: View) -> str:
        """Take this tick's track; why the target counts as lost, or nothing."""
        if view.track is not None and view.track.confirmed:
            if self.track is None or view.track.last_seen_s > self.track.last_seen_s:
                self._hidden_s = 0.0
            self.track = view.track
        unseen_s = view.now_s - (self._begun_s if self.track is None else self.track.last_seen_s)
        if unseen_s > _JUST_NOW_S and self._hidden_s < _HIDDEN_S and self._is_hidden(view):
            self._hidden_s += min(max(view.dt_s, 0.0), _LONGEST_TICK_S)
        # Written so that NaN counts as lost.
        if unseen_s - self._hidden_s <= self._lost_after_s:
            return ""
        what = "target lost" if self.track is not None else "target lost: there was no confirmed track"
        hidden = f", hidden for {self._hidden_s:.1f} s of it" if self._hidden_s else ""
        return f"{what}, not seen for {min(unseen_s, 999.0):.1f} s{hidden} (limit {self._lost_after_s:.1f} s)"

    def _is_hidden(self, view: View) -> bool:
        """Whether the target is out of the picture, or something stands in the line of sight."""
        if self.track is None:
            return False
        target_m = to_child(view.pose_in_odom, self.track.x_m, self.track.y_m)
        points_m = view.obstacles_in_base_m
        range_m = math.hypot(*target_m)
        if abs(math.atan2(target_m[1], target_m[0])) > self._half_fov_rad:
            return True
        if len(points_m) == 0 or range_m < 2.0 * _BEFORE_TARGET_M:
            return False
        c, s = target_m[0] / range_m, target_m[1] / range_m
        along = c * points_m[:, 0] + s * points_m[:, 1]
        across = np.abs(c * points_m[:, 1] - s * points_m[:, 0])
        return bool(((along > 0.0) & (along < range_m - _BEFORE_TARGET_M) & (across < _HIDES_M)).any())
