"""What processes tell each other through shared memory, beyond detections and commands (`target_nav.ipc`)."""

from __future__ import annotations

from dataclasses import dataclass

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


@dataclass(frozen=True, eq=False)
class LaserSnapshot:
    """Channel `laser`: a scan's points in base_link, shape (N, 2), N <= 1440, and the pose they were seen from."""

    stamp_s: float
    pose_in_odom: Pose2D
    points_in_base_m: FloatArray


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
