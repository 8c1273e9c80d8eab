"""Worlds for view models: everything fresh and friendly, and then what a test changes."""

from __future__ import annotations

import dataclasses
import math
from typing import Any

import numpy as np

from target_nav.config import Config
from target_nav.gui.source import Link, World
from target_nav.state.live_settings import fingerprint
from target_nav.state.snapshots import (
    AvoidSnapshot,
    CameraFrame,
    LaserSnapshot,
    NavSnapshot,
    NodeStatus,
    ProcessRow,
    ProcessTable,
    TreeRow,
    TreeState,
)
from target_nav.state.types import (
    Detection,
    DetectionFrame,
    NavState,
    Pose2D,
    TargetSpec,
    Track,
    Twist2D,
)

NOW_S = 100.0
ORIGIN = Pose2D()


def track(**changes: Any) -> Track:
    values: dict[str, Any] = {
        "stamp_s": NOW_S, "x_m": 2.0, "y_m": 0.0, "covariance_m2": (0.04, 0.0, 0.0, 0.01), "confirmed": True,
        "hits": 9, "last_seen_s": NOW_S - 0.1, "last_ranged_s": NOW_S - 0.2, "range_m": 2.0, "bearing_rad": 0.0,
    }  # fmt: skip
    return Track(**{**values, **changes})


def nav(**changes: Any) -> NavSnapshot:
    values: dict[str, Any] = {
        "stamp_s": NOW_S, "tick": 7, "state": NavState.NAVIGATING, "outcome": None, "running_leaf": "Navigate",
        "reason": "target 2.0 m off", "requested": True, "pose_in_odom": Pose2D(), "twist_sent": Twist2D(0.15),
        "limited_by": "", "track": track(), "spec": TargetSpec(), "scan_age_s": 0.2, "odom_age_s": 0.05,
        "camera_age_s": 0.1, "rate_hz": 20.0, "jitter_p99_s": 0.001, "overruns": 0, "mission": "bowling_pin",
        "settings_crc": fingerprint(Config()),
    }  # fmt: skip
    return NavSnapshot(**{**values, **changes})


def detection(**changes: Any) -> Detection:
    values: dict[str, Any] = {
        "class_name": "bowling_pin", "score": 0.93, "track_id": 1, "u_px": 320.0, "v_px": 240.0, "width_px": 20.0,
        "height_px": 70.0, "range_m": 2.2, "range_sigma_m": 0.08, "bearing_rad": 0.0, "bearing_sigma_rad": 0.01,
        "clipped": False, "confirmed": True,
    }  # fmt: skip
    return Detection(**{**values, **changes})


def frame(*detections: Detection, frame_id: int = 1) -> DetectionFrame:
    return DetectionFrame(NOW_S - 0.1, frame_id, detections)


def laser(points: Any = ((1.0, 0.0), (0.0, 1.0)), pose: Pose2D = ORIGIN) -> LaserSnapshot:
    return LaserSnapshot(NOW_S - 0.2, pose, np.array(points, dtype=np.float64).reshape(-1, 2))


def avoid(pose: Pose2D = ORIGIN, **changes: Any) -> AvoidSnapshot:
    points = np.array([[1.0, 0.0], [0.0, 1.0], [-1.0, 0.0], [0.5, 0.5]])
    values: dict[str, Any] = {
        "stamp_s": NOW_S, "pose_in_odom": pose, "active": True, "direction_rad": 0.3, "free_ahead_m": 1.2,
        "along_the_way": False, "outline_count": 3, "points_in_base_m": points,
    }  # fmt: skip
    return AvoidSnapshot(**{**values, **changes})


def tree(*rows: tuple[str, int, NodeStatus, bool]) -> TreeState:
    made = tuple(TreeRow(name, "Sequence", depth, status, active, "") for name, depth, status, active in rows)
    return TreeState(NOW_S, 7, len(made), made)


PICTURE = CameraFrame(NOW_S - 0.1, 3, np.zeros((480, 640, 3), np.uint8))
TREE = tree(
    ("root", 0, NodeStatus.RUNNING, True),
    ("check", 1, NodeStatus.SUCCESS, True),
    ("drive", 1, NodeStatus.RUNNING, True),
    ("give up", 1, NodeStatus.INVALID, False),
)
PROCESSES = ProcessTable(NOW_S, (ProcessRow("nav", "running", 11, 0), ProcessRow("camera", "running", 12, 0)))
LIMITS_S = {
    "nav": 0.5, "laser": 0.8, "avoid": 0.8, "tree": 1.0, "det": 1.0, "camera": 1.0, "processes": 4.0,
}  # fmt: skip


def link(name: str, value: Any, age_s: float = 0.05, problem: str = "") -> Link[Any]:
    return Link(
        name, value, age_s if value is not None else math.inf, LIMITS_S[name], value is not None, problem
    )


def world(**changes: Any) -> World:
    """`changes` by channel: a value, None (there never was one), or a whole `Link`."""
    values: dict[str, Any] = {
        "nav": nav(), "laser": laser(), "avoid": avoid(), "tree": TREE, "det": frame(detection()),
        "camera": PICTURE, "processes": PROCESSES,
    }  # fmt: skip
    other = {name: changes.pop(name) for name in ("gone", "now_s") if name in changes}
    links = {
        name: value if isinstance(value, Link) else link(name, value)
        for name, value in {**values, **changes}.items()
    }
    return World(**{"now_s": NOW_S, **other, **links})


def stale(name: str, value: Any, age_s: float = 9.0) -> Link[Any]:
    return link(name, value, age_s)


def changed(value: Any, **changes: Any) -> Any:
    return dataclasses.replace(value, **changes)
