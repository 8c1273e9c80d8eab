"""The model on the simulator's pictures: is the pin found, how far off is its range, once and after tracking."""

from __future__ import annotations

import math
from pathlib import Path

import cv2
import numpy as np

from deploy.model.limits import Figure
from deploy.model.sim_frames import any_arena
from target_nav.config import Config
from target_nav.detectors.detector import Detector, ImageBgr
from target_nav.detectors.pipeline import DetectionPipeline
from target_nav.nav.poses import PoseHistory
from target_nav.nav.tracker import TargetTracker
from target_nav.sim.arena import Arena, Bounds, PlacedObject
from target_nav.sim.render import Renderer
from target_nav.sim.render_look import Look
from target_nav.state.types import Detection, Odometry, Pose2D, RawDetectionFrame, TargetSpec, Twist2D

Rng = np.random.Generator
PIN = "bowling_pin"
NEAR_M, FAR_M = 0.6, 4.0
SAME_RAD = math.radians(2.0)
VISIBLE_MIN = 0.7
"""A pin of which less is seen is not counted as missed."""
BEARING_MAX_RAD = 0.42
CONFIG = Config()
APPROACH_MPS, RATE_HZ = 0.15, 10.0


def judge_rendered(detector: Detector, count: int, score: float, rng: Rng, draw: Path | None) -> list[Figure]:
    """Rooms with obstacles and decoys, the pin at any range between the limits, one picture each."""
    found = seen = false = 0
    errors: list[float] = []
    ranges: list[tuple[float, bool]] = []
    for index in range(count):
        renderer, pose, range_m, bearing_rad = _scene(rng, NEAR_M, FAR_M)
        picture = renderer.draw(pose, 0.1 * index, rng)
        boxes = [box for box in renderer.true_boxes(pose) if box.class_name == PIN]
        truth = min(boxes, key=lambda box: abs(box.range_m - range_m), default=None)
        objects = _objects(detector, picture, score)
        hit = next((d for d in objects if abs(d.bearing_rad - bearing_rad) < SAME_RAD), None)
        if truth is not None and truth.visible >= VISIBLE_MIN and truth.in_picture > 0.99:
            seen += 1
            found += hit is not None
            ranges.append((range_m, hit is not None))
            if hit is not None and not hit.clipped:
                errors.append(hit.range_m / range_m - 1.0)
        others = [d for d in objects if all(abs(d.bearing_rad - b.bearing_rad) > SAME_RAD for b in boxes)]
        false += len(others)
        if draw is not None and (
            others or (hit is None and truth is not None and truth.visible >= VISIBLE_MIN)
        ):
            _save(draw / f"rendered_{index}.png", picture, objects)
    far = [hit for range_m, hit in ranges if range_m > 3.0]
    return [
        Figure("rendered 0.6-4 m: detection rate", found / max(seen, 1), low=0.98,
               note=f"{found} of {seen} pins; beyond 3 m {sum(far)} of {len(far)}; {false} false boxes in {count}"),
        Figure("rendered: range error p95, one frame", _p95(errors), high=0.05, note=f"median {_median(errors):+.4f}"),
    ]  # fmt: skip


def judge_tracked(detector: Detector, count: int, score: float, rng: Rng) -> list[Figure]:
    """The robot drives up to a pin; after 2 s of pictures, what does the nav process's tracker say?

    Odometry is perfect here and the camera's mount too: this is the model's error, not theirs.
    """
    errors: list[float] = []
    lost = 0
    for _ in range(count):
        start_m = float(rng.uniform(1.2, FAR_M))
        renderer, pose, _, _ = _scene(rng, start_m, start_m + 0.05, spread_rad=0.2, clutter=False)
        pipeline, tracker, poses = DetectionPipeline(CONFIG), TargetTracker(CONFIG), PoseHistory()
        steps = int(min(start_m - NEAR_M, 1.5) / APPROACH_MPS * RATE_HZ)
        for step in range(steps):
            now_s = (step + 1) / RATE_HZ
            here = _ahead(pose, APPROACH_MPS * now_s)
            poses.add(Odometry(now_s, here, Twist2D(APPROACH_MPS, 0.0, 0.0)))
            boxes = tuple(b for b in detector.detect(renderer.draw(here, now_s, rng)) if b.score >= score)
            frame = pipeline.process(RawDetectionFrame(now_s, step, boxes), TargetSpec())
            track = tracker.update(now_s, poses, TargetSpec(), frame, None)
            if now_s < 2.0:
                continue
            if track is None:
                lost += 1
                continue
            true_m = math.hypot(here.x_m, here.y_m)
            errors.append(track.range_m / true_m - 1.0)
    return [
        Figure("rendered: range error p95, tracked", _p95(errors), high=0.02,
               note=f"{count} approaches, {len(errors)} ticks, median {_median(errors):+.4f}, {lost} without a track")
    ]  # fmt: skip


def judge_clipped(detector: Detector, count: int, score: float, rng: Rng) -> list[Figure]:
    """Nearer than 0.4 m. What the border cuts must be flagged, for its range is not to be believed."""
    cut = flagged = found = believed = whole = 0
    for index in range(count):
        renderer, pose, range_m, bearing_rad = _scene(rng, 0.18, 0.40, clutter=False)
        picture = renderer.draw(pose, 0.1 * index, rng)
        hit = next(iter(_objects(detector, picture, score)), None)
        truth = project_edges(range_m, bearing_rad)
        camera = CONFIG.camera
        is_cut = min(truth[:2]) < 0.0 or truth[3] > camera.height_px or truth[2] > camera.width_px
        found += hit is not None
        if hit is None:
            continue
        if is_cut:
            cut += 1
            flagged += hit.clipped
            believed += not hit.clipped and abs(hit.range_m / range_m - 1.0) > 0.10
        else:
            whole += 1
    return [
        Figure("clipped, 0.18-0.4 m: found", found / count, note=f"{cut} cut, {whole} whole"),
        Figure("clipped: cut boxes not flagged and > 10 % off", believed / max(cut, 1), high=0.0,
               note=f"{flagged} of {cut} flagged"),
    ]  # fmt: skip


def project_edges(range_m: float, bearing_rad: float) -> tuple[float, float, float, float]:
    """A pin's edges by the pinhole formula, its foot's and its belly's near sides taken into account."""
    camera = CONFIG.camera
    depth_m = (range_m - 0.017) * math.cos(bearing_rad)
    half_rad = math.asin(0.040 / range_m)
    return (
        0.5 * camera.width_px - camera.focal_px * math.tan(bearing_rad + half_rad),
        0.5 * camera.height_px - camera.focal_px * (0.28 - camera.z_m) / (range_m * math.cos(bearing_rad)),
        0.5 * camera.width_px - camera.focal_px * math.tan(bearing_rad - half_rad),
        0.5 * camera.height_px + camera.focal_px * camera.z_m / depth_m,
    )


def _scene(
    rng: Rng, low_m: float, high_m: float, spread_rad: float = BEARING_MAX_RAD, clutter: bool = True
) -> tuple[Renderer, Pose2D, float, float]:
    """An arena with its pin at the origin, and base_link's pose that sees it at a range and a bearing."""
    alone = Arena("pin", Bounds(-5, -5, 5, 5), Pose2D(-2, 0, 0), PlacedObject(PIN, 0.0, 0.0))
    arena = any_arena(rng) if clutter else alone
    range_m, bearing_rad = float(rng.uniform(low_m, high_m)), float(rng.uniform(-spread_rad, spread_rad))
    from_rad = float(rng.uniform(-math.pi, math.pi))
    yaw_rad = from_rad - bearing_rad
    camera = CONFIG.camera
    pose = Pose2D(
        -range_m * math.cos(from_rad) - camera.x_m * math.cos(yaw_rad),
        -range_m * math.sin(from_rad) - camera.x_m * math.sin(yaw_rad),
        yaw_rad,
    )
    return Renderer(arena, CONFIG, look=Look.of(int(rng.integers(0, 1_000_000)))), pose, range_m, bearing_rad


def _ahead(pose: Pose2D, way_m: float) -> Pose2D:
    return Pose2D(
        pose.x_m + way_m * math.cos(pose.yaw_rad), pose.y_m + way_m * math.sin(pose.yaw_rad), pose.yaw_rad
    )


def _objects(detector: Detector, picture: ImageBgr, score: float) -> list[Detection]:
    """Through the camera process's first two layers."""
    boxes = tuple(box for box in detector.detect(picture) if box.score >= score)
    config = CONFIG.override({"detector.score_min": score})
    return list(DetectionPipeline(config).process(RawDetectionFrame(0.0, 0, boxes), TargetSpec()).detections)


def _p95(errors: list[float]) -> float:
    return float(np.quantile(np.abs(errors), 0.95)) if errors else math.nan


def _median(errors: list[float]) -> float:
    return float(np.median(errors)) if errors else math.nan


def _save(path: Path, picture: ImageBgr, objects: list[Detection]) -> None:
    path.parent.mkdir(parents=True, exist_ok=True)
    drawn = picture.copy()
    for d in objects:
        corner = (int(d.u_px - 0.5 * d.width_px), int(d.v_px - 0.5 * d.height_px))
        other = (int(d.u_px + 0.5 * d.width_px), int(d.v_px + 0.5 * d.height_px))
        cv2.rectangle(drawn, corner, other, (0, 255, 255), 1)
        cv2.putText(drawn, f"{d.score:.2f}", corner, cv2.FONT_HERSHEY_PLAIN, 0.8, (0, 255, 255), 1)
    cv2.imwrite(str(path), drawn)
