"""The blackboard's table of keys: who writes what, in which unit, and who reads it.

A test holds the leaves against this table, so it cannot go out of date.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from target_nav.config import Config
from target_nav.state.types import DetectionFrame, MotionRequest, Outcome, Pose2D, TargetSpec, Track, Twist2D


@dataclass(frozen=True)
class Key:
    """One entry. `writer` and `readers` are `nav loop`, or class names of leaves; `*motion` is every motion leaf."""

    name: str
    type: Any
    unit: str
    writer: str
    readers: tuple[str, ...]
    doc: str
    optional: bool = False
    """The value may be None."""


NOW_S = Key(
    "/clock/now_s",
    float,
    "s",
    "nav loop",
    ("*motion", "TargetTracked", "decorators"),
    "monotonic time of this tick",
)
DT_S = Key("/clock/dt_s", float, "s", "nav loop", ("*motion",), "time since the last tick")
REQUESTED = Key(
    "/command/requested", bool, "", "nav loop", ("MissionRequested",), "GO was the last word, not STOP"
)
SCAN_AGE_S = Key("/input/scan_age_s", float, "s", "nav loop", ("InputsFresh",), "inf: there was none yet")
ODOM_AGE_S = Key("/input/odom_age_s", float, "s", "nav loop", ("InputsFresh",), "inf: there was none yet")
CAMERA_AGE_S = Key("/input/camera_age_s", float, "s", "nav loop", ("InputsFresh",), "inf: there was none yet")
POSE = Key("/robot/pose_in_odom", Pose2D, "m, rad", "nav loop", ("*motion",), "odometry's newest pose")
TWIST = Key(
    "/robot/twist_in_base", Twist2D, "m/s, rad/s", "nav loop", ("*motion",), "odometry's newest velocity"
)
OBSTACLES = Key(
    "/world/obstacles_in_base_m",
    np.ndarray,
    "m",
    "nav loop",
    ("*motion",),
    "points of shape (N, 2), target left out",
)
DETECTIONS = Key(
    "/target/detections",
    DetectionFrame,
    "",
    "nav loop",
    ("*motion",),
    "the camera process's newest frame",
    True,
)
TRACK = Key(
    "/target/track",
    Track,
    "m",
    "nav loop",
    ("*motion", "TargetTracked", "MarkVisited"),
    "None: there is no track",
    True,
)
SPEC = Key(
    "/target/spec", TargetSpec, "m", "SetTarget", ("nav loop", "*motion"), "what the mission looks for"
)
TARGET_CHOICE = Key(
    "/command/target",
    TargetSpec,
    "m",
    "nav loop",
    ("SetTarget",),
    "what the operator wants to be looked for instead of the mission's target",
    True,
)
VISITED = Key(
    "/target/visited",
    tuple,
    "m",
    "MarkVisited",
    ("nav loop",),
    "places (x, y) in odom of targets that no longer count; GO forgets them",
    True,
)
SEARCH = Key(
    "/search/begun",
    tuple,
    "",
    "SpiralSearch",
    ("SpiralSearch",),
    "what was asked for, and the search that is under way; GO forgets it",
    True,
)
REQUEST = Key(
    "/motion/request", MotionRequest, "m/s, rad/s", "*motion", ("nav loop",), "what the wheels shall do", True
)
OUTCOME = Key("/mission/outcome", Outcome, "", "*ending", ("nav loop",), "how the mission ended", True)
CONFIG = Key("/config", Config, "", "nav loop", ("*motion", "InputsFresh"), "the robot's configuration")

ALL: tuple[Key, ...] = (
    NOW_S, DT_S, REQUESTED, SCAN_AGE_S, ODOM_AGE_S, CAMERA_AGE_S, POSE, TWIST, OBSTACLES, DETECTIONS, TRACK, SPEC,
    TARGET_CHOICE, VISITED, SEARCH, REQUEST, OUTCOME, CONFIG,
)  # fmt: skip
