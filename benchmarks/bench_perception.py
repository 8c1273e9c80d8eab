"""How well and how fast the pin is found in rendered pictures: by range, over three backgrounds, and without a pin.

`python -m benchmarks.bench_perception` prints the table that docs/perception.md quotes. Times are CPU time of the
thread, so that what else runs on the machine counts little.
"""

from __future__ import annotations

import math
import time
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np
from rich.console import Console
from rich.table import Table

from target_nav.config import Config
from target_nav.detectors.pin_pixels import PinPixelDetector
from target_nav.detectors.pipeline import DetectionPipeline
from target_nav.sim.arena import Arena, Bounds, BoxObstacle, CircleObstacle, PlacedObject
from target_nav.sim.render import Renderer
from target_nav.state.types import Pose2D, RawDetection, RawDetectionFrame, TargetSpec
from target_nav.utils.distance import project

SEED = 20
RANGE_BINS_M = ((0.2, 0.32), (0.35, 0.6), (0.6, 1.0), (1.0, 2.0), (2.0, 3.0), (3.0, 3.5), (3.5, 4.0))
PICTURES_PER_BACKGROUND = 40
PICTURES_WITHOUT_PIN = 240
ROOMS_WITHOUT_PIN = 12
BEARING_LIMIT_RAD = 0.42
PIPELINE_FRAMES = 2000
PIPELINE_BOXES = 5

CONFIG = Config()
SPEC = TargetSpec()
PIN = PlacedObject("bowling_pin", 0.0, 0.0)
START = Pose2D(-2.0, 0.0, 0.0)
DECOYS = ("bottle", "can", "cup", "vase", "ball", "cone", "bin", "chair_leg")


@dataclass(frozen=True)
class Background:
    """A scene round a pin at the origin, to be looked at from directions within `spread_rad` of the x axis."""

    arena: Arena
    spread_rad: float


def backgrounds() -> tuple[Background, ...]:
    wide = Bounds(-6.0, -6.0, 6.0, 6.0)
    wall = Bounds(-6.0, -6.0, 0.08, 6.0)
    boxes = tuple(BoxObstacle(0.35, -0.9 + 0.45 * i, 0.3, 0.4, 0.1 * i) for i in range(5))
    beside = ((0.05, 0.35), (0.05, -0.35), (0.0, 0.6), (0.0, -0.75))
    decoys = tuple(
        PlacedObject(name, x, y) for name, (x, y) in zip(("bottle", "bottle", "can", "cone"), beside)
    )
    return (
        Background(Arena("open floor", wide, START, PIN), math.pi),
        Background(Arena("at a white wall", wall, START, PIN), 0.7),
        Background(Arena("boxes and decoys", wide, START, PIN, obstacles=boxes, decoys=decoys), 0.3),
    )


def run() -> dict[str, Any]:
    """Measure, print, and return the figures: one row per range bin, then what drawing and the pipeline cost."""
    rng = np.random.default_rng(SEED)
    detector = PinPixelDetector()
    scenes = [(background, Renderer(background.arena, CONFIG)) for background in backgrounds()]
    draw_s: list[float] = []
    rows = [_bin_row(low, high, scenes, detector, rng, draw_s) for low, high in RANGE_BINS_M]
    rows.append(_empty_row(detector, rng))
    figures = {
        "rows": rows,
        "draw_ms_p50": 1e3 * float(np.median(draw_s)),
        "draw_ms_p99": 1e3 * float(np.quantile(draw_s, 0.99)),
        "pipeline_us_p50": _pipeline_us(),
    }
    _print(figures)
    return figures


def _bin_row(
    low_m: float,
    high_m: float,
    scenes: list[tuple[Background, Renderer]],
    detector: PinPixelDetector,
    rng: np.random.Generator,
    draw_s: list[float],
) -> dict[str, Any]:
    found = more = pictures = clipped = 0
    height_errors: list[float] = []
    range_errors: list[float] = []
    bearing_errors: list[float] = []
    detect_s: list[float] = []
    for background, renderer in scenes:
        for _ in range(PICTURES_PER_BACKGROUND):
            range_m = float(rng.uniform(low_m, high_m))
            bearing_rad = float(rng.uniform(-BEARING_LIMIT_RAD, BEARING_LIMIT_RAD))
            pose = _pose(
                range_m, bearing_rad, float(rng.uniform(-background.spread_rad, background.spread_rad))
            )
            begin_s = time.thread_time()
            picture = renderer.draw(pose, 0.1 * pictures, rng)
            drawn_s = time.thread_time()
            boxes = detector.detect(picture)
            detect_s.append(time.thread_time() - drawn_s)
            draw_s.append(drawn_s - begin_s)
            pictures += 1
            # A pipeline of its own: the first two layers and the measurement of one picture.
            objects = DetectionPipeline(CONFIG).process(RawDetectionFrame(0.0, 0, boxes), SPEC).detections
            truth = project(CONFIG.camera, range_m, bearing_rad, SPEC.height_m, SPEC.width_m)
            assert truth is not None
            hits = [d for d in objects if abs(d.bearing_rad - bearing_rad) < math.radians(2.0)]
            more += len(objects) - len(hits)
            if not hits:
                continue
            found += 1
            bearing_errors.append(abs(hits[0].bearing_rad - bearing_rad))
            if hits[0].clipped:
                clipped += 1
                continue
            height_errors.append(hits[0].height_px / truth.height_px - 1.0)
            range_errors.append(hits[0].range_m / range_m - 1.0)
    return {
        "scene": f"{low_m:.2f} ... {high_m:.2f} m",
        "pictures": pictures,
        "found": found / pictures,
        "clipped": clipped / pictures,
        "false_boxes": more,
        "height_error_p50": _quantile(height_errors, 0.5),
        "height_error_p90": _quantile(height_errors, 0.9),
        "range_error_p50": _quantile(range_errors, 0.5),
        "range_error_p90": _quantile(range_errors, 0.9),
        "bearing_error_deg_p90": math.degrees(_quantile(bearing_errors, 0.9)),
        "detect_ms_p50": 1e3 * float(np.median(detect_s)),
        "detect_ms_p99": 1e3 * float(np.quantile(detect_s, 0.99)),
    }


def _empty_row(detector: PinPixelDetector, rng: np.random.Generator) -> dict[str, Any]:
    false_boxes = 0
    detect_s: list[float] = []
    for picture in _pictures_without_pin(rng):
        begin_s = time.thread_time()
        boxes = detector.detect(picture)
        detect_s.append(time.thread_time() - begin_s)
        false_boxes += len(
            DetectionPipeline(CONFIG).process(RawDetectionFrame(0.0, 0, boxes), SPEC).detections
        )
    return {
        "scene": "no pin, many decoys",
        "pictures": PICTURES_WITHOUT_PIN,
        "false_boxes": false_boxes,
        "detect_ms_p50": 1e3 * float(np.median(detect_s)),
        "detect_ms_p99": 1e3 * float(np.quantile(detect_s, 0.99)),
    }


def _pictures_without_pin(rng: np.random.Generator) -> Iterator[np.ndarray]:
    def place() -> tuple[float, float]:
        x, y = rng.uniform(-2.6, 2.6, 2)
        return float(x), float(y)

    for _ in range(ROOMS_WITHOUT_PIN):
        boxes = tuple(BoxObstacle(*place(), 0.4, 0.3, float(rng.uniform(0.0, 3.0))) for _ in range(6))
        circles = tuple(CircleObstacle(*place(), 0.15) for _ in range(5))
        decoys = tuple(PlacedObject(DECOYS[i % len(DECOYS)], *place()) for i in range(16))
        room = Arena("no pin", Bounds(-3.0, -3.0, 3.0, 3.0), Pose2D(), None, None, boxes + circles, decoys)
        renderer = Renderer(room, CONFIG)
        for _ in range(PICTURES_WITHOUT_PIN // ROOMS_WITHOUT_PIN):
            pose = Pose2D(*place(), float(rng.uniform(-math.pi, math.pi)))
            yield renderer.draw(pose, 0.0, rng)


def _pipeline_us() -> float:
    """Median microseconds of one frame with `PIPELINE_BOXES` pins in it."""
    boxes = []
    for i in range(PIPELINE_BOXES):
        box = project(CONFIG.camera, 1.0 + 0.4 * i, -0.4 + 0.2 * i, SPEC.height_m, SPEC.width_m)
        assert box is not None
        boxes.append(RawDetection(SPEC.class_name, 0.9, box.u_px, box.v_px, box.width_px, box.height_px))
    pipeline = DetectionPipeline(CONFIG)
    times_s = []
    for k in range(PIPELINE_FRAMES):
        frame = RawDetectionFrame(0.1 * k, k, tuple(boxes))
        begin_s = time.thread_time()
        pipeline.process(frame, SPEC)
        times_s.append(time.thread_time() - begin_s)
    return 1e6 * float(np.median(times_s))


def _pose(range_m: float, bearing_rad: float, from_rad: float) -> Pose2D:
    """base_link's pose from which the camera sees the origin at that range and bearing."""
    yaw_rad = from_rad - bearing_rad
    camera = CONFIG.camera
    return Pose2D(
        -range_m * math.cos(from_rad) - camera.x_m * math.cos(yaw_rad),
        -range_m * math.sin(from_rad) - camera.x_m * math.sin(yaw_rad),
        yaw_rad,
    )


def _quantile(errors: list[float], fraction: float) -> float:
    """Of the absolute errors; NaN of none."""
    return float(np.quantile(np.abs(errors), fraction)) if errors else math.nan


def _print(figures: dict[str, Any]) -> None:
    table = Table(title="pin in rendered pictures, 640x480")
    for title in ("range", "pictures", "found", "clipped", "false", "height p50/p90", "range p50/p90"):
        table.add_column(title, justify="right")
    table.add_column("bearing p90", justify="right")
    table.add_column("CPU ms p50/p99", justify="right")
    for row in figures["rows"]:
        table.add_row(
            row["scene"],
            str(row["pictures"]),
            _percent(row.get("found")),
            _percent(row.get("clipped")),
            str(row["false_boxes"]),
            f"{_percent(row.get('height_error_p50'), 1)} / {_percent(row.get('height_error_p90'), 1)}",
            f"{_percent(row.get('range_error_p50'), 1)} / {_percent(row.get('range_error_p90'), 1)}",
            f"{row['bearing_error_deg_p90']:.2f} deg" if "bearing_error_deg_p90" in row else "-",
            f"{row['detect_ms_p50']:.1f} / {row['detect_ms_p99']:.1f}",
        )
    console = Console()
    console.print(table)
    console.print(
        f"drawing a picture takes {figures['draw_ms_p50']:.1f} ms of CPU (p99 {figures['draw_ms_p99']:.1f}); "
        f"the pipeline {figures['pipeline_us_p50']:.0f} us a frame of {PIPELINE_BOXES} boxes"
    )


def _percent(share: float | None, digits: int = 0) -> str:
    return "-" if share is None or math.isnan(share) else f"{100.0 * share:.{digits}f} %"


if __name__ == "__main__":
    run()
