"""A small world to script tests in: circles and walls, a robot that moves as told, and what its sensors would say.

It has the figures measured on the real parts, and every one of them can be switched off. No part of the package's own
simulator is used, so the two can contradict each other.
"""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field

import numpy as np

from target_nav.config import Config
from target_nav.nav.poses import PoseHistory
from target_nav.nav.tracker import TargetTracker
from target_nav.state.types import (
    Detection,
    DetectionFrame,
    FloatArray,
    Odometry,
    Pose2D,
    Scan,
    TargetSpec,
    Track,
    Twist2D,
)
from target_nav.utils.frames import compose, to_child, to_parent, wrap_angle

SPEC = TargetSpec()
PIN_RADIUS_M = 0.5 * SPEC.width_m
Circle = tuple[float, float, float]
Wall = tuple[float, float, float, float]


def box(x: float, y: float, length: float, width: float) -> list[Wall]:
    """The four sides of a box with sides along the axes."""
    a, b, c, d = x - length / 2, x + length / 2, y - width / 2, y + width / 2
    return [(a, c, b, c), (b, c, b, d), (b, d, a, d), (a, d, a, c)]


@dataclass(frozen=True)
class Drive:
    """A way made of twists held for a while; before it and after it the robot stands."""

    start: Pose2D = Pose2D()
    legs: tuple[tuple[float, Twist2D], ...] = ()
    begin_s: float = 10.0

    def as_odometry_sees_it(self, forward: float, lateral: float, turn_rad_per_m: float) -> Drive:
        """This way with the scales of odometry (1.02: reports 2 % too much) and a heading that drifts."""
        legs = []
        for duration_s, t in self.legs:
            drift = turn_rad_per_m * t.speed_mps
            legs.append((duration_s, Twist2D(t.vx_mps * forward, t.vy_mps * lateral, t.wz_radps + drift)))
        return Drive(self.start, tuple(legs), self.begin_s)

    def twist(self, time_s: float) -> Twist2D:
        left = time_s - self.begin_s
        if left < 0.0:
            return Twist2D()
        for duration_s, twist in self.legs:
            if left < duration_s:
                return twist
            left -= duration_s
        return Twist2D()

    def poses(self, times_s: FloatArray) -> FloatArray:
        """Rows of (x, y, yaw), exact: the exponential of each twist."""
        left = np.maximum(times_s - self.begin_s, 0.0)
        x, y, yaw = (
            np.full(len(left), value) for value in (self.start.x_m, self.start.y_m, self.start.yaw_rad)
        )
        for duration_s, twist in self.legs:
            dt = np.minimum(left, duration_s)
            angle = twist.wz_radps * dt
            small = np.abs(angle) < 1e-9
            safe = np.where(small, 1.0, angle)
            a = np.where(small, 1.0, np.sin(safe) / safe)
            b = np.where(small, 0.5 * angle, (1.0 - np.cos(safe)) / safe)
            dx, dy = (a * twist.vx_mps - b * twist.vy_mps) * dt, (b * twist.vx_mps + a * twist.vy_mps) * dt
            c, s = np.cos(yaw), np.sin(yaw)
            x, y, yaw = x + c * dx - s * dy, y + s * dx + c * dy, yaw + angle
            left = left - dt
        return np.stack((x, y, yaw), axis=1)

    def pose(self, time_s: float) -> Pose2D:
        x, y, yaw = self.poses(np.array([time_s]))[0].tolist()
        return Pose2D(x, y, wrap_angle(yaw))


STANDING = Drive()


@dataclass
class Sensors:
    """How the sensors err. `Sensors.perfect()` does not err at all."""

    seed: int = 0
    lidar_noise: float = 1.0
    dropouts: float = 1.0
    box_jitter: float = 0.035
    bearing_sigma_rad: float = 0.009
    miss_probability: float = 0.06
    scale_error: float = 0.0
    yaw_error_rad: float = 0.0
    latency_s: float = 0.10
    rng: np.random.Generator = field(init=False)

    def __post_init__(self) -> None:
        self.rng = np.random.default_rng(self.seed)

    @staticmethod
    def perfect(**changes: float) -> Sensors:
        values: dict[str, float] = {
            "lidar_noise": 0.0, "dropouts": 0.0, "box_jitter": 0.0, "bearing_sigma_rad": 0.0, "miss_probability": 0.0,
        }  # fmt: skip
        return Sensors(**{**values, **changes})


@dataclass
class World:
    pins: Sequence[tuple[float, float]] = ()
    circles: Sequence[Circle] = ()
    walls: Sequence[Wall] = ()
    low_walls: Sequence[Wall] = ()
    """Seen by the LiDAR, and looked over by the camera."""
    decoys: Sequence[tuple[str, float, float]] = ()
    drive: Drive = STANDING
    believed: Drive | None = None
    """The same way as odometry has it, if it is wrong about it."""
    sensors: Sensors = field(default_factory=Sensors.perfect)
    config: Config = field(default_factory=Config)

    def odometry(self, time_s: float) -> Odometry:
        drive = self.believed or self.drive
        return Odometry(time_s, drive.pose(time_s), drive.twist(time_s))

    def in_odom(self, point: tuple[float, float], time_s: float) -> tuple[float, float]:
        """Where a point of the world lies in odom, which drifts."""
        if self.believed is None:
            return point
        return to_parent(self.believed.pose(time_s), *to_child(self.drive.pose(time_s), *point))

    def poses(self, until_s: float, since_s: float = 0.0, rate_hz: float = 20.0) -> PoseHistory:
        history = PoseHistory()
        for index in range(round((until_s - since_s) * rate_hz) + 1):
            history.add(self.odometry(since_s + index / rate_hz))
        return history

    def all_circles(self) -> list[Circle]:
        things = [*self.pins, *((x, y) for _, x, y in self.decoys)]
        return [*self.circles, *((x, y, PIN_RADIUS_M) for x, y in things)]

    def scan(self, stamp_s: float) -> Scan:
        """One turn of the LiDAR that begins at `stamp_s`, each beam cast from where the robot is by then."""
        lidar = self.config.lidar
        count, increment = lidar.beams, 2.0 * math.pi / lidar.beams
        beam_s = 1.0 / lidar.rate_hz / count
        lasers = self.drive.poses(stamp_s + np.arange(count) * beam_s)
        c, s = np.cos(lasers[:, 2]), np.sin(lasers[:, 2])
        lasers[:, 0] += c * lidar.x_m - s * lidar.y_m
        lasers[:, 1] += s * lidar.x_m + c * lidar.y_m
        lasers[:, 2] += lidar.yaw_rad
        directions = lasers[:, 2] - math.pi + np.arange(count) * increment
        ranges = cast(
            lasers[:, 0], lasers[:, 1], directions, self.all_circles(), [*self.walls, *self.low_walls]
        )
        rng, finite = self.sensors.rng, np.where(np.isfinite(ranges), ranges, 99.0)
        sigma = np.interp(finite, (0.15, 0.5, 1.0, 1.5, 2.5, 3.5, 4.5, 6.0), MEASURED_SIGMA_M)
        lost = np.interp(finite, (2.0, 3.0, 4.0, 5.0), (0.16, 0.235, 0.30, 0.44))
        # Heavy tails: the measured noise's 90th percentile is three times its median.
        spread = np.exp(0.857 * rng.normal(size=count))
        ranges = ranges + self.sensors.lidar_noise * sigma * spread * rng.normal(size=count)
        ranges[rng.random(count) < self.sensors.dropouts * lost] = np.inf
        ranges[(ranges < lidar.range_min_m) | (ranges > lidar.range_max_m)] = np.inf
        return Scan(stamp_s, -math.pi, increment, beam_s, lidar.range_min_m, lidar.range_max_m, ranges)

    def frame(self, stamp_s: float, frame_id: int = 0) -> DetectionFrame:
        """What the camera makes of the pins and decoys that are in its picture and not hidden."""
        camera, sensors = self.config.camera, self.sensors
        pose = compose(self.drive.pose(stamp_s), Pose2D(camera.x_m, camera.y_m, camera.yaw_rad))
        found = []
        for name, x, y in [*((SPEC.class_name, x, y) for x, y in self.pins), *self.decoys]:
            ahead_m, left_m = to_child(pose, x, y)
            range_m, bearing = math.hypot(ahead_m, left_m), math.atan2(left_m, ahead_m)
            in_picture = (
                ahead_m > 0.05 and abs(bearing) < camera.half_fov_rad and range_m < camera.max_range_m
            )
            if not in_picture or sensors.rng.random() < sensors.miss_probability:
                continue
            others = [circle for circle in self.all_circles() if circle[:2] != (x, y)]
            free = cast(
                np.array([pose.x_m]),
                np.array([pose.y_m]),
                np.array([pose.yaw_rad + bearing]),
                others,
                self.walls,
            )
            if free[0] > range_m:
                found.append(self._detection(name, range_m, bearing))
        return DetectionFrame(stamp_s, frame_id, tuple(found))

    def _detection(self, name: str, range_m: float, bearing: float) -> Detection:
        camera, sensors = self.config.camera, self.sensors
        height_px = (
            camera.focal_px * SPEC.height_m / range_m * math.exp(sensors.box_jitter * sensors.rng.normal())
        )
        clipped = height_px >= camera.height_px
        height_px = min(height_px, float(camera.height_px))
        measured_m = camera.focal_px * SPEC.height_m / height_px * (1.0 + sensors.scale_error)
        measured_rad = bearing + sensors.yaw_error_rad + sensors.bearing_sigma_rad * sensors.rng.normal()
        return detection(measured_m, measured_rad, name=name, clipped=clipped, config=self.config)

    def run(self, tracker: TargetTracker, seconds: float, spec: TargetSpec = SPEC) -> Iterator[Tick]:
        """Tick a tracker at 20 Hz for so long, from the beginning of the drive, with what arrives when it arrives."""
        poses = self.poses(self.drive.begin_s, since_s=self.drive.begin_s - 1.0)
        turn_s = 1.0 / self.config.lidar.rate_hz
        frame_s = 1.0 / self.config.camera.rate_hz
        begin_s = self.drive.begin_s
        frames, scans = -1, -1
        ticks_s = begin_s + 0.05 * np.arange(1, round(seconds * 20.0) + 1)
        true = self.drive.poses(ticks_s)
        believed = true if self.believed is None else self.believed.poses(ticks_s)
        moving = self.believed or self.drive
        frame: DetectionFrame | None = None
        scan: Scan | None = None
        for now_s, pose, odom in zip(ticks_s.tolist(), true.tolist(), believed.tolist()):
            poses.add(Odometry(now_s, Pose2D(*odom), moving.twist(now_s)))
            newest = math.floor((now_s - begin_s - self.sensors.latency_s) / frame_s + 1e-9)
            if newest > frames:
                frames = newest
                frame = self.frame(begin_s + frames * frame_s, frames)
            newest = math.floor((now_s - begin_s) / turn_s + 1e-9) - 1
            if newest > scans:
                scans = newest
                scan = self.scan(begin_s + scans * turn_s)
            track = tracker.update(now_s, poses, spec, frame, scan)
            yield Tick(now_s, poses, Pose2D(*pose), frame, scan, track)

    def last_tick(self, seconds: float) -> Tick:
        *_, last = self.run(TargetTracker(self.config), seconds)
        return last

    def track_after(self, seconds: float) -> Track | None:
        return self.last_tick(seconds).track


@dataclass(frozen=True, eq=False)
class Tick:
    now_s: float
    poses: PoseHistory
    robot: Pose2D
    frame: DetectionFrame | None
    scan: Scan | None
    track: Track | None


MEASURED_SIGMA_M = (0.0013, 0.0019, 0.0035, 0.0055, 0.0095, 0.0165, 0.0255, 0.031)


def cast(
    x: FloatArray, y: FloatArray, yaw: FloatArray, circles: Sequence[Circle], walls: Sequence[Wall]
) -> FloatArray:
    """The distance to the first thing each ray meets, inf if none."""
    c, s = np.cos(yaw), np.sin(yaw)
    nearest = np.full(len(x), np.inf)
    for cx, cy, radius in circles:
        along, across = (cx - x) * c + (cy - y) * s, (cy - y) * c - (cx - x) * s
        with np.errstate(invalid="ignore"):
            hit = along - np.sqrt(radius**2 - across**2)
        nearest = np.where((hit > 0.0) & (hit < nearest), hit, nearest)
    for x1, y1, x2, y2 in walls:
        ex, ey = x2 - x1, y2 - y1
        with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
            determinant = c * ey - s * ex
            hit = ((x1 - x) * ey - (y1 - y) * ex) / determinant
            share = ((x1 - x) * s - (y1 - y) * c) / determinant
        nearest = np.where((hit > 0.0) & (share >= 0.0) & (share <= 1.0) & (hit < nearest), hit, nearest)
    return nearest


def detection(
    range_m: float,
    bearing_rad: float,
    name: str = SPEC.class_name,
    clipped: bool = False,
    confirmed: bool = True,
    config: Config | None = None,
) -> Detection:
    """A detection of the reference target as a camera process would report it."""
    camera = (config or Config()).camera
    height_px = min(camera.focal_px * SPEC.height_m / range_m, float(camera.height_px))
    return Detection(
        class_name=name,
        score=0.9,
        track_id=1,
        u_px=0.5 * camera.width_px - camera.focal_px * math.tan(bearing_rad),
        v_px=0.5 * camera.height_px,
        width_px=camera.focal_px * SPEC.width_m / range_m,
        height_px=height_px,
        range_m=range_m,
        range_sigma_m=0.035 * range_m,
        bearing_rad=wrap_angle(bearing_rad),
        bearing_sigma_rad=0.010,
        clipped=clipped,
        confirmed=confirmed,
    )


def error_m(track: Track | None, pin: tuple[float, float]) -> float:
    """Distance of a track to where the pin really is; inf without a track."""
    return math.inf if track is None else math.hypot(track.x_m - pin[0], track.y_m - pin[1])


def mirrored_odometry(odometry: Odometry) -> Odometry:
    """The same, seen in a mirror along the x axis."""
    pose, twist = odometry.pose_in_odom, odometry.twist_in_base
    return Odometry(
        odometry.stamp_s,
        Pose2D(pose.x_m, -pose.y_m, -pose.yaw_rad),
        Twist2D(twist.vx_mps, -twist.vy_mps, -twist.wz_radps),
    )


def mirrored_scan(scan: Scan) -> Scan:
    """A laser in a mirror turns the other way round."""
    return dataclasses.replace(
        scan, angle_min_rad=-scan.angle_min_rad, angle_increment_rad=-scan.angle_increment_rad
    )


def mirrored_frame(frame: DetectionFrame, config: Config) -> DetectionFrame:
    width_px = config.camera.width_px
    return dataclasses.replace(
        frame,
        detections=tuple(
            dataclasses.replace(seen, bearing_rad=-seen.bearing_rad, u_px=width_px - seen.u_px)
            for seen in frame.detections
        ),
    )
