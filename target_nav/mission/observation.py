"""What a tick of a scripted mission left to be seen."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

from py_trees.behaviour import Behaviour
from py_trees.common import Status

from target_nav.state.types import MotionRequest, NavState, Outcome


@dataclass(frozen=True)
class Observation:
    """What one tick left to be seen. `statuses` and `messages` go with the index's `nodes`."""

    now_s: float
    state: NavState
    leaf: Behaviour | None
    leaf_message: str
    statuses: tuple[Status, ...]
    messages: tuple[str, ...]
    outcome: Outcome | None
    request: MotionRequest | None
    board: Mapping[str, Any] = field(repr=False)

    @property
    def leaf_name(self) -> str:
        return self.leaf.name if self.leaf is not None else ""

    @property
    def reason(self) -> str:
        """Why the robot does what it does, in words: of the motion request, or else of the leaf."""
        if self.request is not None and self.request.reason:
            return self.request.reason
        return self.leaf_message
