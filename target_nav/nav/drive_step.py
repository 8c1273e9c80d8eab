"""What a driver hands back each tick, whatever kind of base it drives."""

from __future__ import annotations

from dataclasses import dataclass

from target_nav.state.types import Twist2D


@dataclass(frozen=True)
class Drive:
    """One step. `cost_to_go_m` is infinite when there is no way; `at_goal` when it stands on one of the spots."""

    twist: Twist2D
    cost_to_go_m: float
    at_goal: bool
    reason: str
