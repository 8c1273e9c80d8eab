"""While searching: stop and look when something may be there, and say when it is.

A detector's first box of a target is unsure. Turning on would carry it out of the picture before it is confirmed, and
believing it at once would end the search at every false box. So the robot faces it for a moment, then decides.
"""

from __future__ import annotations

import math
from enum import Enum

from target_nav.config import RobotConfig
from target_nav.nav.skill import View
from target_nav.nav.speed import YawControl
from target_nav.state.types import Track, Twist2D
from target_nav.utils.frames import to_child

_RECENT_S = 0.6
"""Six frames of the camera: seen now, not some time ago."""
_LOOK_S = 1.2
_IGNORE_S = 2.0
"""After a look that came to nothing, so long nothing unsure is looked at: at 0.5 rad/s that is a picture's width."""


class Sight(Enum):
    NOTHING = "nothing"
    LOOKING = "looking"
    FOUND = "found"


class Glimpse:
    def __init__(self, robot: RobotConfig) -> None:
        self._yaw = YawControl(robot, top_radps=0.4, rest_rad=0.05)
        self.reset()

    def reset(self) -> None:
        self._since_s: float | None = None
        self._ignore_until_s = -math.inf
        self._yaw.reset()

    def look(self, view: View) -> Sight:
        track = view.track
        recent = track is not None and view.now_s - track.last_seen_s <= _RECENT_S
        if track is not None and track.confirmed and recent:
            return Sight.FOUND
        if not recent or view.now_s < self._ignore_until_s:
            self._since_s = None
            return Sight.NOTHING
        if self._since_s is None:
            self._since_s = view.now_s
            self._yaw.reset()
        if view.now_s - self._since_s > _LOOK_S:
            self._since_s = None
            self._ignore_until_s = view.now_s + _IGNORE_S
            return Sight.NOTHING
        return Sight.LOOKING

    def twist(self, view: View) -> Twist2D:
        """Stand and face what may be the target."""
        if view.track is None:
            return Twist2D()
        return Twist2D(
            0.0, 0.0, self._yaw.rate_radps(bearing_to(view, view.track), view.twist_in_base.wz_radps)
        )


def bearing_to(view: View, track: Track) -> float:
    x, y = to_child(view.pose_in_odom, track.x_m, track.y_m)
    return math.atan2(y, x)
