"""The values that cross a boundary: between processes, between steps of a tick, between a leaf and a skill.

All frozen. SI units. Frames follow REP-103 and REP-105: x forward, y left, angles counter-clockwise. Every measurement
carries `stamp_s`, the monotonic time (`CLOCK_MONOTONIC`, seconds) at which it was *taken*, not received.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from enum import Enum, IntEnum

import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]


@dataclass(frozen=True)
class Pose2D:
    """A pose in the plane; the name of a variable says in which frame (`pose_in_odom`)."""

    x_m: float = 0.0
    y_m: float = 0.0
    yaw_rad: float = 0.0

    def is_finite(self) -> bool:
        return math.isfinite(self.x_m) and math.isfinite(self.y_m) and math.isfinite(self.yaw_rad)


@dataclass(frozen=True)
class Twist2D:
    """A velocity of base_link, expressed in base_link."""

    vx_mps: float = 0.0
    vy_mps: float = 0.0
    wz_radps: float = 0.0

    def is_finite(self) -> bool:
        return math.isfinite(self.vx_mps) and math.isfinite(self.vy_mps) and math.isfinite(self.wz_radps)

    @property
    def speed_mps(self) -> float:
        return math.hypot(self.vx_mps, self.vy_mps)


STOP = Twist2D()


@dataclass(frozen=True)
class Odometry:
    """What odometry says: a pose that drifts but never jumps, and the velocity it was integrated from."""

    stamp_s: float
    pose_in_odom: Pose2D
    twist_in_base: Twist2D


@dataclass(frozen=True, eq=False)
class Scan:
    """One turn of the LiDAR, in the laser's own frame.

    Beam i was taken at `stamp_s + i * time_increment_s` in direction `angle_min_rad + i * angle_increment_rad`.
    `ranges_m` is float64 of shape (N,). A beam without a return is `inf` or NaN: it is a drop-out, never free space.
    """

    stamp_s: float
    angle_min_rad: float
    angle_increment_rad: float
    time_increment_s: float
    range_min_m: float
    range_max_m: float
    ranges_m: FloatArray


@dataclass(frozen=True)
class TargetSpec:
    """What the mission looks for. The class picks the detector's label, the size scales distance and checks shape.

    `lidar_width_m` is its width at the LiDAR's height, where that is not its largest; 0: as wide as everywhere.
    """

    class_name: str = "bowling_pin"
    height_m: float = 0.28
    width_m: float = 0.08
    lidar_width_m: float = 0.0

    @property
    def width_at_lidar_m(self) -> float:
        return self.lidar_width_m or self.width_m


@dataclass(frozen=True)
class Facing:
    """One pose of a flat target that fits its picture.

    `facing_rad` is the direction of its outward normal on the ground, in the camera's frame (pi: straight at the
    camera); `error_px` is the root mean square by which its corners miss where they were seen.
    """

    facing_rad: float
    error_px: float


@dataclass(frozen=True)
class RawDetection:
    """One box as the detector process saw it, in pixels of the full frame. (u_px, v_px) is the box's centre."""

    class_name: str
    score: float
    u_px: float
    v_px: float
    width_px: float
    height_px: float
    facing: Facing | None = None
    """Where a flat target's face looks, the better fitting of two poses; None where the detector knows none."""
    other_facing: Facing | None = None
    """The other pose that fits: a square seen from afar has two."""


@dataclass(frozen=True)
class RawDetectionFrame:
    """All boxes of one camera frame; an empty tuple means the detector looked and saw nothing."""

    stamp_s: float
    frame_id: int
    detections: tuple[RawDetection, ...] = ()


@dataclass(frozen=True)
class Detection:
    """One object the camera process stands behind, placed in the camera's frame.

    `range_m` is measured on the ground from the camera to the object's *surface-independent* centre axis;
    `bearing_rad` is its direction, left positive, in the camera's frame. `clipped` boxes touch the picture's border:
    their range is a lower bound on how wrong it can be and must not be believed; their bearing may be used.
    """

    class_name: str
    score: float
    track_id: int
    u_px: float
    v_px: float
    width_px: float
    height_px: float
    range_m: float
    range_sigma_m: float
    bearing_rad: float
    bearing_sigma_rad: float
    clipped: bool
    confirmed: bool
    facing: Facing | None = None
    other_facing: Facing | None = None
    """As in `RawDetection`."""


@dataclass(frozen=True)
class DetectionFrame:
    """What the camera process hands over for one frame. `stamp_s` is when the frame was exposed."""

    stamp_s: float
    frame_id: int
    detections: tuple[Detection, ...] = ()


@dataclass(frozen=True)
class Track:
    """Where the target is believed to be, in odom.

    `covariance_m2` is row-major (xx, xy, yx, yy). `last_seen_s` is the stamp of the newest camera detection that was
    accepted, `last_ranged_s` that of the newest LiDAR range, `-inf` if there was none yet.
    """

    stamp_s: float
    x_m: float
    y_m: float
    covariance_m2: tuple[float, float, float, float]
    confirmed: bool
    hits: int
    last_seen_s: float
    last_ranged_s: float
    range_m: float
    """From base_link's origin to the target's centre, at `stamp_s`."""
    bearing_rad: float
    """From base_link's x axis to the target, at `stamp_s`."""
    facing_in_odom_rad: float | None = None
    """Direction of a flat target's outward normal; None while it is not known, or the target has no face."""
    facing_sigma_rad: float | None = None
    """Its standard deviation; given with it."""

    @property
    def sigma_m(self) -> float:
        """Largest standard deviation: the square root of the covariance's larger eigenvalue."""
        xx, xy, _, yy = self.covariance_m2
        mean = 0.5 * (xx + yy)
        spread = math.hypot(0.5 * (xx - yy), xy)
        return math.sqrt(max(mean + spread, 0.0))


class NavState(IntEnum):
    """What the robot does, read off the running motion leaf. The numbers are those in shared memory."""

    IDLE = 0
    NAVIGATING = 1
    SEARCHING = 2
    SPIRAL_SEARCH = 3
    BLIND_APPROACH = 4
    ARRIVED = 5


@dataclass(frozen=True, eq=False)
class Avoidance:
    """What VFH saw and chose in one tick, for a person to look at.

    `directions_rad` and `free_m`, shape (S,): the histogram, how far the body can go in each direction of base_link.
    """

    direction_rad: float
    free_ahead_m: float
    along_the_way: bool
    directions_rad: FloatArray
    free_m: FloatArray


@dataclass(frozen=True)
class MotionRequest:
    """What a motion leaf wants the wheels to do. `owner` is the leaf's id; only the owner may clear its request.

    `near_target` says that closeness to the target is intended, so the limiter's clearance rule leaves the target out.
    """

    owner: str
    state: NavState
    twist: Twist2D
    reason: str = ""
    near_target: bool = False
    avoidance: Avoidance | None = field(default=None, compare=False)


class OutcomeKind(str, Enum):
    SUCCEEDED = "succeeded"
    FAILED = "failed"


@dataclass(frozen=True)
class Outcome:
    """How a mission ended, in words for a person."""

    kind: OutcomeKind
    reason: str


class CommandKind(IntEnum):
    """What an operator may ask of the nav process. The numbers are those in shared memory."""

    GO = 1
    STOP = 2
    RESET_ODOM = 3
    PAUSE = 4
    RESUME = 5
    STEP = 6
    """One tick of the tree, then PAUSE."""
    RELOAD = 7
    """Take the mission's file as it is now, if it is right."""
    MANUAL = 8
    """Drive at `vx,vy,wz` (m/s, m/s, rad/s) for as long as this comes again; only while no mission is wanted."""
    SETTING = 9
    """`key=value` (JSON) of the configuration, one that may be changed in a running process."""
    LOAD = 10
    """Tick another mission, named by its path or its name in trees/; only while no mission is wanted."""
    TARGET = 11
    """Look for `class,height_m,width_m,lidar_width_m` instead of the mission's target; empty: the mission's again."""
    FIRMWARE = 12
    """A line for the firmware, as in `TMOTOR,FL,100`; only while no mission is wanted."""


@dataclass(frozen=True)
class Command:
    stamp_s: float
    kind: CommandKind
    argument: str = ""


@dataclass(frozen=True, eq=False)
class Inputs:
    """Everything one tick sees of the world. `scan`, `odometry` and `detections` are the newest there are, or None.

    `odometry_since` are the messages that came since the last tick, oldest first, for the buffer of poses.
    """

    now_s: float
    scan: Scan | None = None
    odometry: Odometry | None = None
    odometry_since: tuple[Odometry, ...] = ()
    detections: DetectionFrame | None = None
    commands: tuple[Command, ...] = ()


@dataclass(frozen=True, eq=False)
class TickRecord:
    """What one tick decided. `statuses` maps a behaviour's path in the tree to its status name, visited ones only."""

    now_s: float
    state: NavState
    running_leaf: str
    requested: Twist2D
    sent: Twist2D
    limited_by: str
    track: Track | None
    outcome: Outcome | None
    reason: str
    root_status: str
    statuses: dict[str, str] = field(default_factory=dict)
