"""Driving by hand: a velocity that lives only as long as somebody says, again and again, that the key is still held.

The deadman is here, below every screen: whatever becomes of the panel, the last word is forgotten after `timeout_s`.
What comes out is a request like any leaf's, so the limiter's clearance, age and acceleration rules hold for it too.
"""

from __future__ import annotations

import math

from target_nav.config import ManualConfig
from target_nav.state.types import MotionRequest, NavState, Twist2D

OWNER = "manual drive"
_FUTURE_S = 0.05
"""A stamp farther ahead than this is of another clock."""


def manual_text(twist: Twist2D) -> str:
    """The argument of a MANUAL command."""
    return f"{twist.vx_mps:.4g},{twist.vy_mps:.4g},{twist.wz_radps:.4g}"


def manual_twist(argument: str) -> Twist2D | None:
    """The velocity of a MANUAL command; None if that is none."""
    parts = argument.split(",")
    try:
        values = [float(part) for part in parts]
    except ValueError:
        return None
    if len(values) != 3 or not all(map(math.isfinite, values)):
        return None
    return Twist2D(*values)


class ManualDrive:
    """STOP counts for whoever holds a key at that moment, at this screen or another: he has to let go first."""

    def __init__(self, config: ManualConfig) -> None:
        self._timeout_s = config.timeout_s
        self._heard_s = -math.inf
        self._must_let_go = False
        self.release()

    def configure(self, config: ManualConfig) -> None:
        self._timeout_s = config.timeout_s

    def hold(self, stamp_s: float, twist: Twist2D) -> None:
        """It is held, as of `stamp_s`: the time at which the screen said so, not the time of its arrival."""
        silent_s, self._heard_s = stamp_s - self._heard_s, stamp_s
        if twist == Twist2D() or silent_s > self._timeout_s:
            self._must_let_go = False
        if not self._must_let_go:
            self._stamp_s, self._twist = stamp_s, twist

    def release(self) -> None:
        """Nothing is held."""
        self._stamp_s, self._twist = -math.inf, Twist2D()

    def stop(self) -> None:
        """Nothing counts as held until it was let go."""
        self.release()
        self._must_let_go = True

    def request(self, now_s: float) -> MotionRequest | None:
        """What to ask of the wheels in this tick; None once nobody holds."""
        age_s = now_s - self._stamp_s
        if not -_FUTURE_S <= age_s <= self._timeout_s or self._twist == Twist2D():
            return None
        return MotionRequest(OWNER, NavState.IDLE, self._twist, "driven by hand")
