"""Notices that nothing comes of the driving: standing still, or going to and fro without getting nearer.

A way that turns out to be longer than it looked begins the count anew, a few times: finding out is progress too.
"""

from __future__ import annotations

import math

from target_nav.state.types import Pose2D
from target_nav.utils.frames import wrap_angle

_SURPRISE_M = 0.5
_SURPRISES = 4


class Progress:
    """Two clocks: one for standing, one for coming no nearer."""

    def __init__(
        self, *, standing_s: float, no_nearer_s: float, step_m: float = 0.06, nearer_m: float = 0.10
    ) -> None:
        self._standing_s, self._no_nearer_s = standing_s, no_nearer_s
        self._step_m, self._nearer_m = step_m, nearer_m
        self._anchor: Pose2D | None = None
        self._surprises = 0

    def begin(self) -> None:
        self.restart()
        self._surprises = 0

    def restart(self) -> None:
        """Begin the count anew; surprises had before still count."""
        self._anchor = None

    def stalled(self, now_s: float, pose: Pose2D, cost_to_go_m: float) -> str:
        """Empty while there is progress, else what is missing. An infinite cost counts as no nearer."""
        if self._anchor is None:
            self._anchor, self._moved_s = pose, now_s
            self._best_m, self._nearer_at_s = cost_to_go_m, now_s
            self._last_m = cost_to_go_m
        turned = abs(wrap_angle(pose.yaw_rad - self._anchor.yaw_rad))
        if (
            math.hypot(pose.x_m - self._anchor.x_m, pose.y_m - self._anchor.y_m) > self._step_m
            or turned > 0.25
        ):
            self._anchor, self._moved_s = pose, now_s
        if cost_to_go_m < self._best_m - self._nearer_m:
            self._best_m, self._nearer_at_s = cost_to_go_m, now_s
        if self._last_m + _SURPRISE_M < cost_to_go_m < math.inf and self._surprises < _SURPRISES:
            self._surprises += 1
            self._best_m, self._nearer_at_s = cost_to_go_m, now_s
        self._last_m = cost_to_go_m
        if now_s - self._moved_s > self._standing_s:
            return f"stood for {now_s - self._moved_s:.1f} s"
        if now_s - self._nearer_at_s > self._no_nearer_s:
            return f"no nearer for {now_s - self._nearer_at_s:.1f} s"
        return ""
