"""A scripted blackboard: the nav loop's keys, set by a test."""

from __future__ import annotations

from typing import Any

import numpy as np

from target_nav.app.world_board import WorldBoard
from target_nav.config import Config
from target_nav.state import keys
from target_nav.state.types import Pose2D, TargetSpec, Track, Twist2D


class ScriptedBoard(WorldBoard):
    """All keys hold something harmless: fresh inputs, the robot at the origin, nothing in the way, no target."""

    def __init__(self, config: Config | None = None) -> None:
        super().__init__()
        for key, value in {
            keys.NOW_S: 0.0,
            keys.DT_S: 0.05,
            keys.REQUESTED: True,
            keys.SCAN_AGE_S: 0.1,
            keys.ODOM_AGE_S: 0.02,
            keys.CAMERA_AGE_S: 0.1,
            keys.POSE: Pose2D(),
            keys.TWIST: Twist2D(),
            keys.OBSTACLES: np.empty((0, 2)),
            keys.SCAN_TAKEN: False,
            keys.SPEC: TargetSpec(),
            keys.CONFIG: config or Config(),
        }.items():
            self.write(key, value)

    def advance(self, dt_s: float = 0.05) -> float:
        now_s: float = self.read(keys.NOW_S) + dt_s
        self.write(keys.NOW_S, now_s)
        self.write(keys.DT_S, dt_s)
        return now_s


def track_at(x_m: float, y_m: float, now_s: float = 0.0, **changes: Any) -> Track:
    """A confirmed track, seen just now by a robot at the origin."""
    fields: dict[str, Any] = {
        "stamp_s": now_s,
        "x_m": x_m,
        "y_m": y_m,
        "covariance_m2": (1e-4, 0.0, 0.0, 1e-4),
        "confirmed": True,
        "hits": 10,
        "last_seen_s": now_s,
        "last_ranged_s": now_s,
        "range_m": float(np.hypot(x_m, y_m)),
        "bearing_rad": float(np.arctan2(y_m, x_m)),
    }
    return Track(**{**fields, **changes})
