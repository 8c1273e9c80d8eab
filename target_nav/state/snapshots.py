"""What processes tell each other through shared memory, beyond detections and commands (`target_nav.ipc`)."""

from __future__ import annotations

from dataclasses import dataclass
from enum import IntEnum

import numpy as np
from numpy.typing import NDArray

from target_nav.state.types import FloatArray, NavState, Outcome, Pose2D, TargetSpec, Track, Twist2D


@dataclass(frozen=True)
class NavSnapshot:
    """Channel `nav`: what the nav process decided in one tick. `spec` tells the camera process what to look for."""

    stamp_s: float
    tick: int
    state: NavState
    outcome: Outcome | None
    running_leaf: str
    reason: str
    requested: bool
    pose_in_odom: Pose2D
    twist_sent: Twist2D
    limited_by: str
    track: Track | None
    spec: TargetSpec
    scan_age_s: float
    odom_age_s: float
    camera_age_s: float
    rate_hz: float
    jitter_p99_s: float
    overruns: int
    mission: str = ""
    paused: bool = False
    manual: bool = False
    """A person drives, and no mission."""
    settings_crc: int = 0
    """`live_settings.fingerprint` of the configuration in use: whether a changed setting has arrived."""
    notice: str = ""
    """The last thing the operator should know: a command that was refused and why, or what came of one."""
    notice_count: int = 0
    """Notices so far, so that the same words twice are two notices."""


@dataclass(frozen=True, eq=False)
class LaserSnapshot:
    """Channel `laser`: a scan's points in base_link, shape (N, 2), N <= 1440, and the pose they were seen from."""

    stamp_s: float
    pose_in_odom: Pose2D
    points_in_base_m: FloatArray


@dataclass(frozen=True, eq=False)
class AvoidSnapshot:
    """Channel `avoid`: obstacles as VFH sees them, and what it chose. `active`: it chose something in this tick.

    `points_in_base_m`, shape (N, 2), holds two lists: first `outline_count` corners of the room that the body can reach
    going straight from here (the polar histogram), then the obstacles, the target left out.
    """

    stamp_s: float
    pose_in_odom: Pose2D
    active: bool
    direction_rad: float
    free_ahead_m: float
    along_the_way: bool
    outline_count: int
    points_in_base_m: FloatArray

    @property
    def outline_in_base_m(self) -> FloatArray:
        return self.points_in_base_m[: self.outline_count]

    @property
    def obstacles_in_base_m(self) -> FloatArray:
        return self.points_in_base_m[self.outline_count :]


class NodeStatus(IntEnum):
    """What a behaviour of the tree said last."""

    INVALID = 0
    RUNNING = 1
    SUCCESS = 2
    FAILURE = 3


@dataclass(frozen=True)
class TreeRow:
    """One behaviour of the mission's tree. `word` is its word in the mission language; `active`: visited last tick."""

    name: str
    word: str
    depth: int
    status: NodeStatus
    active: bool
    feedback: str


@dataclass(frozen=True)
class TreeState:
    """Channel `tree`: the mission's tree after a tick, depth first. `total` may be more than there is room for."""

    stamp_s: float
    tick: int
    total: int
    rows: tuple[TreeRow, ...]


@dataclass(frozen=True)
class ProcessRow:
    """One process as the supervisor sees it; `condition` is its word for it: running, starting, failed ..."""

    name: str
    condition: str
    pid: int
    restarts: int


@dataclass(frozen=True)
class ProcessTable:
    """Channel `processes`: the supervisor's table, about once a second."""

    stamp_s: float
    rows: tuple[ProcessRow, ...]


@dataclass(frozen=True, eq=False)
class CameraFrame:
    """Channels `camera` and `sim_camera`: one picture, uint8 BGR of shape (height, width, 3)."""

    stamp_s: float
    frame_id: int
    image_bgr: NDArray[np.uint8]


@dataclass(frozen=True)
class Calibration:
    """Channel `calibration`: what the camera process tells the detector. Distortion is OpenCV's k1 k2 p1 p2 k3."""

    stamp_s: float
    focal_x_px: float
    focal_y_px: float
    center_u_px: float
    center_v_px: float
    distortion: tuple[float, float, float, float, float]
    score_min: float
    class_name: str
