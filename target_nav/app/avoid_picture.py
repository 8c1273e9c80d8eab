"""What VFH sees and chooses, as a picture for a screen."""

from __future__ import annotations

import numpy as np

from target_nav.state.snapshots import AvoidSnapshot
from target_nav.state.types import Avoidance, FloatArray, Pose2D

_OUTLINE_MOST_M = 3.0
"""The histogram says "far" for a way that nothing is in; a picture needs an end."""


def avoid_snapshot(
    now_s: float, pose: Pose2D, avoidance: Avoidance | None, obstacles_in_base_m: FloatArray
) -> AvoidSnapshot:
    """Without `avoidance` (a leaf that does not steer) there are obstacles, and no outline."""
    if avoidance is None:
        return AvoidSnapshot(now_s, pose, False, 0.0, 0.0, False, 0, obstacles_in_base_m)
    angles = avoidance.directions_rad
    reach_m = np.minimum(avoidance.free_m, _OUTLINE_MOST_M)[:, None]
    outline = reach_m * np.column_stack((np.cos(angles), np.sin(angles)))
    return AvoidSnapshot(
        stamp_s=now_s,
        pose_in_odom=pose,
        active=True,
        direction_rad=avoidance.direction_rad,
        free_ahead_m=min(avoidance.free_ahead_m, _OUTLINE_MOST_M),
        along_the_way=avoidance.along_the_way,
        outline_count=len(outline),
        points_in_base_m=np.vstack((outline, obstacles_in_base_m)),
    )
