"""A target that moves: straight on at a steady velocity for a while, and no nearer to walls and things than it may.

It pushes nothing and nobody steers it. It does not heed the robot: where it drives into one, that is a collision.
"""

from __future__ import annotations

import math
from dataclasses import replace

from target_nav.sim.arena_types import Arena, PlacedObject
from target_nav.sim.world import World

KEPT_FREE_M = 0.05
"""It stops so far from walls, obstacles and decoys."""


class MovingTarget:
    """Where the target is by now; `world`, and all that sees by it, are told."""

    def __init__(self, arena: Arena, world: World) -> None:
        self.place: PlacedObject | None = arena.target
        self._world = world
        self._velocity_mps = arena.target.velocity_mps if arena.target is not None else (0.0, 0.0)
        self._left_s = arena.target.moves_s if arena.target is not None else 0.0
        self.moves = self.place is not None and self._velocity_mps != (0.0, 0.0) and self._left_s > 0.0

    def step(self, dt_s: float) -> float:
        """Go on for `dt_s`; how far it went in metres. Once it stands it stays."""
        if not self.moves or self.place is None:
            return 0.0
        dt_s = min(dt_s, self._left_s)
        self._left_s -= dt_s
        dx, dy = self._velocity_mps[0] * dt_s, self._velocity_mps[1] * dt_s
        x_m, y_m = self.place.x_m + dx, self.place.y_m + dy
        if self._world.room_round_target_m(x_m, y_m) < KEPT_FREE_M:
            self.moves = False
            return 0.0
        self.moves = self._left_s > 0.0
        self.place = replace(self.place, x_m=x_m, y_m=y_m)
        self._world.move_target(x_m, y_m)
        return math.hypot(dx, dy)
