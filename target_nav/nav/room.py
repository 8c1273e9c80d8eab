"""Room to move: where there is most of it, and whether there is enough to turn on the spot."""

from __future__ import annotations

import math

import numpy as np

from target_nav.config import Config
from target_nav.nav.footprint import Footprint
from target_nav.state.types import STOP, FloatArray, Twist2D

_SEES_M = 0.6
"""More room than this is as good as any."""
_PER_RAD_M = 0.05
"""So much room is given up for a direction that is a radian nearer to the wanted one."""
_AWAY_MPS = 0.06


class Room:
    def __init__(self, config: Config) -> None:
        self._body = Footprint.of(config.robot)
        self._margin_m = config.avoid.margin_m
        self._turning_m = self._body.circumscribed_radius_m + config.avoid.stop_clearance_m + 0.01
        holonomic = config.robot.drive != "differential"
        around: FloatArray = np.linspace(-math.pi, math.pi, 24, endpoint=False)
        self._directions = around if holonomic else np.array([-math.pi, 0.0])

    def widest(self, points_m: FloatArray, wanted_rad: float | None = None) -> tuple[float, float]:
        """(direction, free distance) of the most room for the body as it stands; preferably near `wanted_rad`."""
        free = np.minimum(self._body.free_distances_m(points_m, self._directions, self._margin_m), _SEES_M)
        off = np.zeros(len(free))
        if wanted_rad is not None:
            off = np.abs(np.remainder(self._directions - wanted_rad + math.pi, 2.0 * math.pi) - math.pi)
        best = int(np.argmax(free - _PER_RAD_M * off))
        return float(self._directions[best]), float(free[best])

    def for_turning(self, points_m: FloatArray) -> Twist2D:
        """A slow motion away from what a corner would touch while turning on the spot; STOP if nothing would."""
        if len(points_m) == 0:
            return STOP
        away = np.hypot(points_m[:, 0], points_m[:, 1])
        nearest = int(away.argmin())
        if away[nearest] > self._turning_m:
            return STOP
        from_it = math.atan2(-points_m[nearest, 1], -points_m[nearest, 0])
        direction, free = self.widest(points_m, from_it)
        # Never towards it: then it is better to try and turn where it stands.
        if free < 0.02 or abs(math.remainder(direction - from_it, 2.0 * math.pi)) > 0.5 * math.pi:
            return STOP
        return Twist2D(_AWAY_MPS * math.cos(direction), _AWAY_MPS * math.sin(direction), 0.0)
