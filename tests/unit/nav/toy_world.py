"""A toy world that closes the loop round the skills: boxes, walls and a pin; a robot with lag, dead-band and odometry
that errs; LiDAR and camera with the figures measured on the real parts. 20 Hz, virtual time, everything from one seed.

Tracker, obstacle memory and limiter are the real ones. The package's simulator is not used, so the two can disagree.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np

from target_nav.config import Config
from target_nav.nav.limiter import Limited, VelocityLimiter
from target_nav.nav.obstacles import ObstacleMemory
from target_nav.nav.poses import PoseHistory
from target_nav.nav.skill import Skill, SkillStatus, SkillStep, View
from target_nav.nav.tracker import TargetTracker
from target_nav.state.types import (
    STOP,
    Detection,
    DetectionFrame,
    FloatArray,
    MotionRequest,
    NavState,
    Odometry,
    Pose2D,
    Scan,
    TargetSpec,
    Twist2D,
)
from target_nav.utils.frames import compose, to_child

SPEC = TargetSpec()
PIN_RADIUS_M = 0.5 * SPEC.width_m
TICK_S = 0.05
SIGMA_M = (
    (0.15, 0.5, 1.0, 1.5, 2.5, 3.5, 4.5, 6.0),
    (0.0013, 0.0019, 0.0035, 0.0055, 0.0095, 0.0165, 0.0255, 0.031),
)
LOST = ((2.0, 3.0, 4.0, 5.0), (0.16, 0.235, 0.30, 0.44))

Segment = tuple[float, float, float, float]


def box(x: float, y: float, length: float, width: float, yaw: float = 0.0) -> list[Segment]:
    """The four sides of a box round (x, y)."""
    pose = Pose2D(x, y, yaw)
    corners = [
        (length / 2, width / 2),
        (-length / 2, width / 2),
        (-length / 2, -width / 2),
        (length / 2, -width / 2),
    ]
    placed = [
        (pose.x_m + math.cos(yaw) * a - math.sin(yaw) * b, pose.y_m + math.sin(yaw) * a + math.cos(yaw) * b)
        for a, b in corners
    ]
    return [(*placed[i], *placed[(i + 1) % 4]) for i in range(4)]


def pillar(x: float, y: float, radius: float, sides: int = 12) -> list[Segment]:
    angles = [2.0 * math.pi * i / sides for i in range(sides + 1)]
    ring = [(x + radius * math.cos(a), y + radius * math.sin(a)) for a in angles]
    return [(*ring[i], *ring[i + 1]) for i in range(sides)]


def room(half: float = 3.0) -> list[Segment]:
    return box(0.0, 0.0, 2.0 * half, 2.0 * half)


@dataclass
class ToyWorld:
    """Where everything is, in truth. `noise` scales LiDAR noise, drop-outs and box jitter; 0 is a perfect world."""

    walls: list[Segment] = field(default_factory=room)
    pin: tuple[float, float] | None = (1.0, 0.0)
    start: Pose2D = Pose2D(-2.0, 0.0, 0.0)
    noise: float = 1.0
    seed: int = 0
    config: Config = field(default_factory=Config)
    false_rate: float = 0.0
    drift: float = 1.0
    """Factor on the errors of odometry."""

    def __post_init__(self) -> None:
        self.rng = np.random.default_rng(self.seed)
        pin = pillar(*self.pin, PIN_RADIUS_M, 10) if self.pin is not None else []
        self.solid = np.array([*self.walls, *pin], dtype=np.float64).reshape(-1, 4)
        self.opaque = np.array(self.walls, dtype=np.float64).reshape(-1, 4)
        sim, signs = self.config.drive_sim, self.rng.choice([-1.0, 1.0], 3)
        self.forward_scale = 1.0 + self.drift * signs[0] * sim.forward_scale_error
        self.lateral_scale = 1.0 + self.drift * sim.lateral_over_report
        self.heading_drift = self.drift * signs[1] * sim.heading_drift_rad_per_m
        self.mount_error = self.noise * signs[2] * self.config.camera.mount_error_rad
        self.now_s = 100.0
        self.true_pose, self.true_twist = self.start, STOP
        self.pose_in_odom, self.odom_twist = Pose2D(), STOP
        self.poses = PoseHistory()
        self.tracker, self.memory = TargetTracker(self.config), ObstacleMemory(self.config)
        self.limiter = VelocityLimiter(self.config)
        self.frames: list[DetectionFrame] = []
        self.frame: DetectionFrame | None = None
        self.scan: Scan | None = None
        self.next_scan_s = self.next_frame_s = self.now_s
        self.path: list[Pose2D] = [self.true_pose]
        self.asked: list[Twist2D] = []
        self.sent: list[Twist2D] = []
        self.limited: list[str] = []
        self.min_clearance_m = math.inf
        for _ in range(12):
            self._sense()
            self.now_s += TICK_S

    # -- what is measured ----------------------------------------------------------------------------------------

    def view(self) -> View:
        points = self.memory.points_in_base(self.pose_in_odom, self.track, SPEC)
        return View(self.now_s, TICK_S, self.pose_in_odom, self.odom_twist, self.track, points, self.frame)

    def _sense(self) -> None:
        self.poses.add(Odometry(self.now_s, self.pose_in_odom, self.odom_twist))
        if self.now_s >= self.next_scan_s:
            self.next_scan_s += 1.0 / self.config.lidar.rate_hz
            self.scan = self._scan()
        if self.now_s >= self.next_frame_s:
            self.next_frame_s += 1.0 / self.config.camera.rate_hz
            self.frames.append(self._picture())
        while self.frames and self.now_s - self.frames[0].stamp_s >= self.config.camera.latency_s:
            self.frame = self.frames.pop(0)
        self.memory.update(self.now_s, self.poses, self.scan)
        self.track = self.tracker.update(self.now_s, self.poses, SPEC, self.frame, self.scan)

    def _scan(self) -> Scan:
        lidar = self.config.lidar
        step = 2.0 * math.pi / lidar.beams
        angles = -math.pi + np.arange(lidar.beams) * step
        ranges = cast(self.true_pose.x_m, self.true_pose.y_m, angles + self.true_pose.yaw_rad, self.solid)
        finite = np.where(np.isfinite(ranges), ranges, 99.0)
        ranges = ranges + self.noise * np.interp(finite, *SIGMA_M) * self.rng.normal(size=lidar.beams)
        ranges[self.rng.random(lidar.beams) < self.noise * np.interp(finite, *LOST)] = np.inf
        ranges[ranges < lidar.range_min_m] = np.inf
        return Scan(self.now_s, -math.pi, step, 0.0, lidar.range_min_m, lidar.range_max_m, ranges)

    def _picture(self) -> DetectionFrame:
        camera = self.config.camera
        at = compose(self.true_pose, Pose2D(camera.x_m, camera.y_m, camera.yaw_rad))
        found: list[Detection] = []
        if self.pin is not None:
            ahead, left = to_child(at, *self.pin)
            range_m, bearing = math.hypot(ahead, left), math.atan2(left, ahead)
            seen = ahead > 0.05 and abs(bearing) < camera.half_fov_rad and range_m < camera.max_range_m
            if seen and self.rng.random() >= self.noise * camera.miss_probability:
                free = cast(at.x_m, at.y_m, np.array([at.yaw_rad + bearing]), self.opaque)[0]
                if free > range_m:
                    found.append(self._detection(range_m, bearing))
        if self.rng.random() < self.false_rate:
            found.append(self._detection(self.rng.uniform(1.0, 3.5), self.rng.uniform(-0.45, 0.45)))
        return DetectionFrame(self.now_s, round(self.now_s * 100), tuple(found))

    def _detection(self, range_m: float, bearing: float) -> Detection:
        camera = self.config.camera
        jitter = math.exp(self.noise * camera.box_jitter * self.rng.normal())
        height = camera.focal_px * SPEC.height_m / range_m * jitter
        width = min(height * SPEC.width_m / SPEC.height_m, float(camera.width_px))
        clipped = height > camera.height_px
        height = min(height, float(camera.height_px))
        measured = camera.focal_px * SPEC.height_m / height
        heading = bearing + self.mount_error + self.noise * 0.009 * self.rng.normal()
        u_px = camera.width_px / 2 - camera.focal_px * math.tan(heading)
        return Detection(
            SPEC.class_name, 0.9, 1, u_px, camera.height_px / 2, width, height, measured, 0.04 * measured,
            heading, 0.01, clipped, True,
        )  # fmt: skip

    # -- what moves ----------------------------------------------------------------------------------------------

    def apply(self, request: MotionRequest | None) -> Limited:
        """Limit, drive for one tick, sense again."""
        track = self.track
        target = (
            to_child(self.pose_in_odom, track.x_m, track.y_m)
            if track is not None and track.confirmed
            else None
        )
        limited = self.limiter.limit(
            request, dt_s=TICK_S, scan_age_s=0.1, odom_age_s=0.0, camera_age_s=0.1,
            obstacles_in_base_m=self.memory.points_in_base(self.pose_in_odom, track, SPEC),
            target_in_base=target, measured=self.odom_twist,
        )  # fmt: skip
        self.sent.append(limited.twist)
        self.limited.append(limited.limited_by)
        self._move(limited.twist)
        self.now_s += TICK_S
        self._sense()
        return limited

    def _move(self, command: Twist2D) -> None:
        robot, sim = self.config.robot, self.config.drive_sim
        arm = robot.front_m + robot.half_width_m
        wheels = np.array(
            [command.vx_mps + sy * command.vy_mps + sw * arm * command.wz_radps
             for sy, sw in ((-1, -1), (1, 1), (1, -1), (-1, 1))]
        )  # fmt: skip
        if robot.drive == "differential":
            assert command.vy_mps == 0.0
        wheels[np.abs(wheels) < sim.deadband_mps] = 0.0
        vx, vy = float(wheels.mean()), float((-wheels[0] + wheels[1] + wheels[2] - wheels[3]) / 4)
        wz = float((-wheels[0] + wheels[1] - wheels[2] + wheels[3]) / (4 * arm))
        part = 1.0 - math.exp(-TICK_S / sim.lag_s) if sim.lag_s > 0 else 1.0
        old = self.true_twist
        self.true_twist = new = Twist2D(
            old.vx_mps + part * (vx - old.vx_mps),
            old.vy_mps + part * (vy - old.vy_mps),
            old.wz_radps + part * (wz - old.wz_radps),
        )
        self.true_pose = _moved(self.true_pose, new)
        reported = Twist2D(
            new.vx_mps * self.forward_scale,
            new.vy_mps * self.lateral_scale,
            new.wz_radps + self.heading_drift * new.speed_mps,
        )
        self.odom_twist = reported
        self.pose_in_odom = _moved(self.pose_in_odom, reported)
        self.path.append(self.true_pose)
        self.min_clearance_m = min(self.min_clearance_m, self.clearance_m())

    def clearance_m(self) -> float:
        """Body to the nearest thing, the pin included; 0 when it touches."""
        robot, pose = self.config.robot, self.true_pose
        ends = self.solid.reshape(-1, 2)
        c, s = math.cos(pose.yaw_rad), math.sin(pose.yaw_rad)
        local = ((ends - (pose.x_m, pose.y_m)) @ np.array([[c, -s], [s, c]])).reshape(-1, 2, 2)
        share = np.linspace(0.0, 1.0, 100)[:, None, None]
        points = (local[:, 0] * (1.0 - share) + local[:, 1] * share)[0:].reshape(-1, 2)
        dx = np.maximum(points[:, 0] - robot.front_m, -robot.rear_m - points[:, 0])
        dy = np.abs(points[:, 1]) - robot.half_width_m
        distance = np.hypot(np.maximum(dx, 0.0), np.maximum(dy, 0.0))
        return float(distance.min())

    def stop_error_m(self, stand_off_m: float) -> float:
        """Front edge to the pin's surface, minus the stand-off; the pin is taken where it is in truth."""
        assert self.pin is not None
        x, y = to_child(self.true_pose, *self.pin)
        robot = self.config.robot
        dx, dy = x - robot.front_m, max(abs(y) - robot.half_width_m, 0.0)
        return math.hypot(max(dx, 0.0), dy) - PIN_RADIUS_M - stand_off_m

    def run(self, skill: Skill, limit_s: float = 60.0, *, near_target: bool = False) -> SkillStep:
        """Tick a skill until it ends or `limit_s` have gone by."""
        skill.start(self.view())
        until_s = self.now_s + limit_s
        while True:
            step = skill.step(self.view())
            if step.status is not SkillStatus.RUNNING or self.now_s >= until_s:
                return step
            self.asked.append(step.twist)
            self.apply(MotionRequest("toy", NavState.NAVIGATING, step.twist, step.reason, near_target))

    def coast(self, seconds: float = 1.0) -> None:
        """No request, as between two missions."""
        for _ in range(round(seconds / TICK_S)):
            self.apply(None)


def _moved(pose: Pose2D, twist: Twist2D) -> Pose2D:
    turn = twist.wz_radps * TICK_S
    half = Pose2D(pose.x_m, pose.y_m, pose.yaw_rad + 0.5 * turn)
    return compose(half, Pose2D(twist.vx_mps * TICK_S, twist.vy_mps * TICK_S, 0.5 * turn))


def cast(x: float, y: float, angles: FloatArray, segments: FloatArray) -> FloatArray:
    """Distance to the first segment each ray meets, inf if none."""
    if len(segments) == 0:
        return np.full(len(angles), np.inf)
    c, s = np.cos(angles)[:, None], np.sin(angles)[:, None]
    ax, ay = segments[:, 0] - x, segments[:, 1] - y
    ex, ey = segments[:, 2] - segments[:, 0], segments[:, 3] - segments[:, 1]
    with np.errstate(divide="ignore", invalid="ignore"):
        bottom = c * ey - s * ex
        along = (ax * ey - ay * ex) / bottom
        share = (ax * s - ay * c) / bottom
        hit = np.where((along > 0.0) & (share >= 0.0) & (share <= 1.0), along, np.inf)
    return hit.min(axis=1)


def save_picture(world: ToyWorld, path: str, extra: Sequence[tuple[float, float]] = ()) -> None:
    """The way driven, for a person to look at. Needs matplotlib."""
    import matplotlib.pyplot as plt

    figure, axes = plt.subplots(figsize=(7, 7))
    for x1, y1, x2, y2 in world.solid:
        axes.plot([x1, x2], [y1, y2], "k-", lw=1)
    axes.plot([p.x_m for p in world.path], [p.y_m for p in world.path], "b-", lw=1)
    robot = world.config.robot
    for pose in world.path[:: max(len(world.path) // 12, 1)]:
        corners = [(robot.front_m, robot.half_width_m), (-robot.rear_m, robot.half_width_m),
                   (-robot.rear_m, -robot.half_width_m), (robot.front_m, -robot.half_width_m)]  # fmt: skip
        placed = [compose(pose, Pose2D(a, b)) for a, b in corners]
        axes.plot([p.x_m for p in [*placed, placed[0]]], [p.y_m for p in [*placed, placed[0]]], "g-", lw=0.6)
    for x, y in extra:
        axes.plot(x, y, "r+")
    axes.set_aspect("equal")
    figure.savefig(path, dpi=80)
    plt.close(figure)
