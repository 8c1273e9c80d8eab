"""Driving by hand: which keys or fields are held now, and the velocity that makes.

Held is what moves: while something is held `due` gives a velocity every 50 ms, when the last is released zero once, and
then nothing. The deadman that stops a robot whose panel has died is in the nav process, not here.
"""

from __future__ import annotations

import math

from target_nav.config import Config
from target_nav.state.types import STOP, Twist2D

PERIOD_S = 0.05
"""A quarter of the deadman's time."""

DIRECTIONS: dict[str, tuple[int, int, int]] = {
    "forward": (1, 0, 0), "back": (-1, 0, 0), "left": (0, 1, 0), "right": (0, -1, 0),
    "turn_left": (0, 0, 1), "turn_right": (0, 0, -1),
}  # fmt: skip
"""Direction to the signs of vx, vy, wz; left and right strafe."""

KEYS = {
    "Up": "forward", "w": "forward", "Down": "back", "s": "back", "Left": "left", "a": "left", "Right": "right",
    "d": "right", "q": "turn_left", "e": "turn_right", "Page_Up": "turn_left", "Page_Down": "turn_right",
}  # fmt: skip
"""Key names as X and GTK have them; a browser's ArrowUp and its like need their own table."""


class ManualPad:
    def __init__(self) -> None:
        self._held: set[tuple[str, str]] = set()
        self._next_s = -math.inf
        self._moving = False

    @property
    def held(self) -> frozenset[str]:
        return frozenset(direction for direction, _ in self._held)

    def hold(self, direction: str, by: str = "") -> None:
        """`by` tells two holders of one direction apart: a key and a finger. Raises KeyError for no direction."""
        DIRECTIONS[direction]
        if not self._held:
            self._next_s = -math.inf
        self._held.add((direction, by))

    def release(self, direction: str, by: str = "") -> None:
        self._held.discard((direction, by))

    def release_all(self) -> None:
        self._held.clear()

    def twist(self, config: Config) -> Twist2D:
        """The velocity of what is held; opposite directions cancel."""
        sums = [sum(DIRECTIONS[direction][axis] for direction in self.held) for axis in range(3)]
        manual = config.manual
        lateral = sums[1] if config.robot.drive != "differential" else 0
        return Twist2D(
            sums[0] * manual.speed_mps, lateral * manual.speed_mps, sums[2] * manual.yaw_rate_radps
        )

    def due(self, now_s: float, config: Config) -> Twist2D | None:
        """What to say now: a velocity while something is held, zero once when nothing is any more, else None."""
        twist = self.twist(config)
        if twist == STOP:
            was, self._moving = self._moving, False
            return STOP if was else None
        if now_s < self._next_s:
            return None
        self._next_s = now_s + PERIOD_S
        self._moving = True
        return twist
