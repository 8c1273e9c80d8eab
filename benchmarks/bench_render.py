"""What one rendered frame of 640x480 costs on one core, and what looking at it costs: `python -m benchmarks render`.

CPU time of the thread, so that what else runs on the machine counts little.
"""

from __future__ import annotations

import math
import time

import numpy as np

from benchmarks import OURS, Row
from target_nav.app.model_file import cpu_model
from target_nav.config import Config
from target_nav.detectors.onnx_detector import OnnxDetector
from target_nav.errors import DeviceError
from target_nav.sim.arena import load_arena
from target_nav.sim.render import Renderer
from target_nav.sim.render_look import Look
from target_nav.state.types import Pose2D

ARENAS = ("open_floor", "cluttered_room", "decoys", "three_pins")
FRAMES = 80
LIMIT_MS = 15.0


def run() -> list[Row]:
    """A few rows an arena: a frame, the slowest of a hundred, the network's look at it, setting the arena up."""
    try:
        detector: OnnxDetector | None = OnnxDetector(cpu_model(Config()))
    except DeviceError:
        detector = None
    return [row for name in ARENAS for row in _rows(name, detector)]


def _rows(name: str, detector: OnnxDetector | None) -> list[Row]:
    arena = load_arena(name)
    rng = np.random.default_rng(3)
    begin_s = time.thread_time()
    renderer = Renderer(arena, Config(), look=Look.of(3))
    setup_s = time.thread_time() - begin_s
    x0, y0, x1, y1 = arena.bounds
    draw_s, network_s = [], []
    for k in range(FRAMES):
        x, y = rng.uniform((x0 + 0.4, y0 + 0.4), (x1 - 0.4, y1 - 0.4))
        pose = Pose2D(float(x), float(y), float(rng.uniform(-math.pi, math.pi)))
        begin_s = time.thread_time()
        picture = renderer.draw(pose, 0.1 * k, rng)
        drawn_s = time.thread_time()
        draw_s.append(drawn_s - begin_s)
        if detector is not None:
            detector.detect(picture)
            network_s.append(time.thread_time() - drawn_s)
    rows = [
        Row(
            f"{name}: draw, median", OURS, 1e3 * float(np.median(draw_s)), "ms", note=f"limit {LIMIT_MS:g} ms"
        ),
        Row(f"{name}: draw, 99 %", OURS, 1e3 * float(np.quantile(draw_s, 0.99)), "ms"),
        Row(f"{name}: set up", OURS, 1e3 * setup_s, "ms", note="once an arena"),
    ]
    if network_s:
        rows.append(
            Row(
                f"{name}: network, median",
                OURS,
                1e3 * float(np.median(network_s)),
                "ms",
                note="letterbox to boxes",
            )
        )
    return rows


if __name__ == "__main__":
    from rich.console import Console

    from benchmarks.__main__ import table

    Console().print(table("render", run()))
