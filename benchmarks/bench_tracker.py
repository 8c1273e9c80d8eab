"""What it costs to know where the target and the obstacles are, and what a nearest-return range would cost in error.

One robot drives through a room with five pins, a noisy 360-beam LiDAR at 5.5 Hz and a camera at 10 Hz that sees all
five; the tracker is ticked at 20 Hz. Peers: five filterpy filters of position alone with scipy's assignment; a loop
over the beams; the points of the last three seconds without a grid; and the reference's way to a range, which is to
believe the return in the target's direction.
"""

from __future__ import annotations

import math
import time
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from filterpy.kalman import KalmanFilter
from scipy.optimize import linear_sum_assignment

from benchmarks import OURS, Row, time_call
from target_nav.config import Config
from target_nav.nav.obstacles import ObstacleMemory
from target_nav.nav.poses import PoseHistory, moved_by
from target_nav.nav.scan_points import deskewed_points_in_odom
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
from target_nav.utils.frames import compose, points_to_child, points_to_parent, to_child

CONFIG = Config()
SPEC = TargetSpec()
TWIST = Twist2D(0.05, 0.0, 0.02)
START_S = 10.0
SECONDS = 10.0
PINS = ((2.0, 0.3), (2.5, -0.6), (3.0, 0.8), (3.0, -0.2), (1.8, -0.5))
ROOM = (-1.0, -1.2, 4.0, 1.2)
LOW_BOX = (1.3, 0.3, 0.2)
"""x, y, radius: the LiDAR sees it before the first pin, the camera looks over it."""


@dataclass(frozen=True, eq=False)
class Moment:
    now_s: float
    odometry: Odometry
    frame: DetectionFrame | None
    scan: Scan | None


def run() -> list[Row]:
    moments = recording(low_box=False)
    return [
        *update_costs(moments),
        *deskewing(moments),
        *obstacle_memory(moments),
        *error_behind_a_low_box(recording(low_box=True)),
    ]


def pose_at(stamp_s: float) -> Pose2D:
    return moved_by(Pose2D(), TWIST, stamp_s - START_S)


def recording(low_box: bool) -> list[Moment]:
    """Every tick of the drive, with the newest frame and scan there are by then."""
    rng = np.random.default_rng(1)
    turn_s, frame_s = 1.0 / CONFIG.lidar.rate_hz, 1.0 / CONFIG.camera.rate_hz
    frames, scans = -1, -1
    frame: DetectionFrame | None = None
    scan: Scan | None = None
    moments = []
    for tick in range(round(SECONDS * CONFIG.loop.rate_hz)):
        now_s = START_S + tick / CONFIG.loop.rate_hz
        elapsed_s = now_s - START_S + 1e-9
        if (newest := math.floor((elapsed_s - CONFIG.camera.latency_s) / frame_s)) > frames:
            frames, frame = newest, frame_of(START_S + newest * frame_s, newest, rng)
        if (newest := math.floor(elapsed_s / turn_s) - 1) > scans:
            scans, scan = newest, scan_of(START_S + newest * turn_s, rng, low_box)
        moments.append(Moment(now_s, Odometry(now_s, pose_at(now_s), TWIST), frame, scan))
    return moments


def frame_of(stamp_s: float, frame_id: int, rng: np.random.Generator) -> DetectionFrame:
    camera = compose(pose_at(stamp_s), Pose2D(CONFIG.camera.x_m, CONFIG.camera.y_m, CONFIG.camera.yaw_rad))
    return DetectionFrame(stamp_s, frame_id, tuple(detection_of(to_child(camera, *pin), rng) for pin in PINS))


def detection_of(pin_in_camera: tuple[float, float], rng: np.random.Generator) -> Detection:
    range_m = math.hypot(*pin_in_camera) * (1.0 + 0.035 * float(rng.normal()))
    bearing_rad = math.atan2(pin_in_camera[1], pin_in_camera[0]) + 0.009 * float(rng.normal())
    pixels_per_m = CONFIG.camera.focal_px / range_m
    return Detection(
        class_name=SPEC.class_name,
        score=0.9,
        track_id=0,
        u_px=320.0 - CONFIG.camera.focal_px * math.tan(bearing_rad),
        v_px=240.0,
        width_px=SPEC.width_m * pixels_per_m,
        height_px=SPEC.height_m * pixels_per_m,
        range_m=range_m,
        range_sigma_m=0.035 * range_m,
        bearing_rad=bearing_rad,
        bearing_sigma_rad=0.0096,
        clipped=False,
        confirmed=True,
    )


def scan_of(stamp_s: float, rng: np.random.Generator, low_box: bool) -> Scan:
    lidar = CONFIG.lidar
    step_rad, beam_s = 2.0 * math.pi / lidar.beams, 1.0 / lidar.rate_hz / lidar.beams
    poses = [pose_at(stamp_s + beam * beam_s) for beam in range(lidar.beams)]
    x, y = np.array([pose.x_m for pose in poses]), np.array([pose.y_m for pose in poses])
    direction = np.array([pose.yaw_rad for pose in poses]) - math.pi + step_rad * np.arange(lidar.beams)
    c, s = np.cos(direction), np.sin(direction)
    left, right, low, high = ROOM[0] - x, ROOM[2] - x, ROOM[1] - y, ROOM[3] - y
    with np.errstate(divide="ignore", invalid="ignore"):
        ranges = np.minimum(np.where(c > 0.0, right, left) / c, np.where(s > 0.0, high, low) / s)
        things = [(*pin, 0.5 * SPEC.width_m) for pin in PINS] + [LOW_BOX] * low_box
        for px, py, radius in things:
            along, across = (px - x) * c + (py - y) * s, (py - y) * c - (px - x) * s
            hit = along - np.sqrt(radius**2 - across**2)
            ranges = np.where((hit > 0.0) & (hit < ranges), hit, ranges)
    ranges = ranges + 0.005 * rng.normal(size=lidar.beams)
    ranges[rng.random(lidar.beams) < 0.18] = np.inf
    return Scan(stamp_s, -math.pi, step_rad, beam_s, lidar.range_min_m, lidar.range_max_m, ranges)


def first_poses() -> PoseHistory:
    poses = PoseHistory()
    for tick in range(20):
        stamp_s = START_S - 1.0 + 0.05 * tick
        poses.add(Odometry(stamp_s, pose_at(stamp_s), TWIST))
    return poses


# --- cost ------------------------------------------------------------------------------------------------------------


def update_costs(moments: list[Moment]) -> list[Row]:
    """Medians by what is new in a tick, over three drives, and the mean of all ticks."""
    times: dict[str, list[float]] = {"nothing": [], "a frame": [], "a scan": [], "both": []}
    for _ in range(3):
        tracker, poses, last = TargetTracker(CONFIG), first_poses(), moments[0]
        for moment in moments:
            poses.add(moment.odometry)
            new = (moment.frame is not last.frame, moment.scan is not last.scan)
            last = moment
            start_s = time.perf_counter()
            tracker.update(moment.now_s, poses, SPEC, moment.frame, moment.scan)
            took_s = time.perf_counter() - start_s
            kind = {(False, False): "nothing", (True, False): "a frame", (False, True): "a scan"}.get(
                new, "both"
            )
            times[kind].append(took_s)
    every = [took_s for kind in times.values() for took_s in kind]
    note = "5 pins, 360 beams"
    rows = [
        Row(f"track, {kind} new", OURS, 1e6 * float(np.median(took)), "us", note)
        for kind, took in times.items()
    ]
    rows.append(Row("track, mean of all ticks", OURS, 1e6 * float(np.mean(every)), "us", "at 20 Hz; " + note))
    rows.append(
        Row(
            "track, a frame new",
            "filterpy + scipy",
            1e6 * time_call(plain_filters()),
            "us",
            "position alone: no bias of the camera, no LiDAR, no life cycle",
        )
    )
    return rows


def plain_filters() -> Callable[[], None]:
    """Five position filters, their Mahalanobis distances to five detections, an assignment, five updates."""
    filters = []
    for x_m, y_m in PINS:
        kalman = KalmanFilter(dim_x=2, dim_z=2)
        kalman.x, kalman.H, kalman.P = np.array([[x_m], [y_m]]), np.eye(2), 0.01 * np.eye(2)
        kalman.R, kalman.Q = 0.005 * np.eye(2), 1e-5 * np.eye(2)
        filters.append(kalman)
    measured = [np.array([[x_m + 0.01], [y_m]]) for x_m, y_m in PINS]

    def once() -> None:
        costs = np.empty((5, 5))
        for row, kalman in enumerate(filters):
            kalman.predict()
            inverse = np.linalg.inv(kalman.P + kalman.R)
            for column, z in enumerate(measured):
                off = z - kalman.x
                costs[row, column] = (off.T @ inverse @ off)[0, 0]
        for row, column in zip(*linear_sum_assignment(costs)):
            filters[row].update(measured[column])

    return once


def deskewing(moments: list[Moment]) -> list[Row]:
    poses, scan = history_of(moments)

    def beam_by_beam() -> FloatArray:
        points = []
        for beam, range_m in enumerate(scan.ranges_m):
            pose = poses.at(scan.stamp_s + beam * scan.time_increment_s)
            if pose is not None and scan.range_min_m <= range_m <= scan.range_max_m:
                angle = pose.yaw_rad + scan.angle_min_rad + beam * scan.angle_increment_rad
                points.append((pose.x_m + range_m * math.cos(angle), pose.y_m + range_m * math.sin(angle)))
        return np.array(points)

    ours = time_call(lambda: deskewed_points_in_odom(scan, poses, CONFIG.lidar))
    return [
        Row("deskew 360 beams", OURS, 1e6 * ours, "us"),
        Row("deskew 360 beams", "loop over beams", 1e6 * time_call(beam_by_beam), "us"),
    ]


def history_of(moments: list[Moment]) -> tuple[PoseHistory, Scan]:
    poses = first_poses()
    for moment in moments:
        poses.add(moment.odometry)
    scan = moments[-1].scan
    if scan is None:
        raise RuntimeError("the recording has no scan")
    return poses, scan


def obstacle_memory(moments: list[Moment]) -> list[Row]:
    memory, poses, scans = ObstacleMemory(CONFIG), first_poses(), []
    took_s, last = [], moments[0].scan
    for moment in moments:
        poses.add(moment.odometry)
        start_s = time.perf_counter()
        memory.update(moment.now_s, poses, moment.scan)
        if moment.scan is not last and moment.scan is not None:
            took_s.append(time.perf_counter() - start_s)
            points = deskewed_points_in_odom(moment.scan, poses, CONFIG.lidar)
            if points is not None:
                scans.append(points.points_in_odom_m)
        last = moment.scan
    pose, track = pose_at(moments[-1].now_s), track_of(PINS[0])
    kept = memory.points_in_base(pose, track, SPEC)
    raw = scans[-round(CONFIG.avoid.memory_s * CONFIG.lidar.rate_hz) :]
    reach_m = CONFIG.avoid.look_ahead_m + CONFIG.avoid.margin_m + CONFIG.robot.circumscribed_radius_m

    def all_points() -> FloatArray:
        in_base = points_to_child(pose, np.concatenate(raw))
        return in_base[np.hypot(in_base[:, 0], in_base[:, 1]) <= reach_m]

    ours = time_call(lambda: memory.points_in_base(pose, track, SPEC))
    return [
        Row("obstacle memory, a new scan", OURS, 1e6 * float(np.median(took_s)), "us", "deskewing included"),
        Row(
            "obstacle points in base", OURS, 1e6 * ours, "us", f"{len(kept)} points, seen through where free"
        ),
        Row(
            "obstacle points in base",
            "last 3 s of scans",
            1e6 * time_call(all_points),
            "us",
            f"{len(all_points())} points, none ever cleared",
        ),
    ]


def track_of(pin: tuple[float, float]) -> Track:
    return Track(START_S, *pin, (1e-4, 0.0, 0.0, 1e-4), True, 9, START_S, START_S, 2.0, 0.0)


# --- error -----------------------------------------------------------------------------------------------------------


def error_behind_a_low_box(moments: list[Moment]) -> list[Row]:
    """The pin stands 0.7 m behind a box that the camera looks over: 95th percentile of the position's error."""
    tracker, poses = TargetTracker(CONFIG), first_poses()
    ours, naive = [], []
    for moment in moments:
        poses.add(moment.odometry)
        track = tracker.update(moment.now_s, poses, SPEC, only_first(moment.frame), moment.scan)
        if track is not None and track.confirmed:
            ours.append(math.hypot(track.x_m - PINS[0][0], track.y_m - PINS[0][1]))
            believed = nearest_return(moment, poses)
            if believed is not None:
                naive.append(math.hypot(believed[0] - PINS[0][0], believed[1] - PINS[0][1]))
    task, note = "position error p95, a low box in front", "10 s at 20 Hz"
    return [
        Row(task, OURS, 1e3 * float(np.quantile(ours, 0.95)), "mm", note),
        Row(
            task,
            "range at the bearing",
            1e3 * float(np.quantile(naive, 0.95)),
            "mm",
            "believed whenever finite",
        ),
    ]


def only_first(frame: DetectionFrame | None) -> DetectionFrame | None:
    return None if frame is None else DetectionFrame(frame.stamp_s, frame.frame_id, frame.detections[:1])


def nearest_return(moment: Moment, poses: PoseHistory) -> tuple[float, float] | None:
    """The reference's way: the LiDAR's range in the direction of the newest detection."""
    if moment.scan is None or moment.frame is None:
        return None
    seen, scan = moment.frame.detections[0], moment.scan
    beam = round((seen.bearing_rad - scan.angle_min_rad) / scan.angle_increment_rad) % len(scan.ranges_m)
    range_m, pose = float(scan.ranges_m[beam]), poses.at(moment.frame.stamp_s)
    if not math.isfinite(range_m) or pose is None:
        return None
    range_m += 0.5 * SPEC.width_m
    point = np.array([[range_m * math.cos(seen.bearing_rad), range_m * math.sin(seen.bearing_rad)]])
    x_m, y_m = points_to_parent(pose, point)[0].tolist()
    return x_m, y_m
