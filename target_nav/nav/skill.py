"""The shape every skill has: a frozen view of the world in, a velocity and a verdict out. No clock, no I/O, no tree."""

from __future__ import annotations

from dataclasses import dataclass
from enum import Enum
from typing import Protocol

from target_nav.state.types import STOP, DetectionFrame, FloatArray, Pose2D, Track, Twist2D


class SkillStatus(Enum):
    RUNNING = "running"
    SUCCESS = "success"
    FAILURE = "failure"


@dataclass(frozen=True, eq=False)
class View:
    """What a skill may know in one tick. `obstacles_in_base_m` has shape (N, 2) and leaves the target out."""

    now_s: float
    dt_s: float
    pose_in_odom: Pose2D
    twist_in_base: Twist2D
    track: Track | None
    obstacles_in_base_m: FloatArray
    detections: DetectionFrame | None
    is_busy: bool = False
    """A new scan, or something else that is heavy, is in this tick already: what can wait a tick should."""


@dataclass(frozen=True)
class SkillStep:
    status: SkillStatus
    twist: Twist2D = STOP
    reason: str = ""


class Skill(Protocol):
    """`start` once when its leaf begins, then `step` once a tick until the status is not RUNNING."""

    def start(self, view: View) -> None: ...

    def step(self, view: View) -> SkillStep: ...
