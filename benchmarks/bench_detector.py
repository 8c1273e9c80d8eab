"""What the eyes cost: the detector program a picture, the camera process at ten pictures a second, a reader at thirty.

Real processes on rendered pictures. Figures of work are CPU time out of /proc, so that what else runs counts
little; figures of delay are wall time and count it in full. Without the program or its model the rows say so.
"""

from __future__ import annotations

import math
import os
import re
import signal
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import cv2
import numpy as np
from numpy.typing import NDArray

from benchmarks import OURS, Row
from target_nav.app.detector_program import find_program
from target_nav.app.model_file import find_model
from target_nav.config import Config
from target_nav.detectors.pin_pixels import PinPixelDetector
from target_nav.ipc import channels
from target_nav.sim.arena import Arena, Bounds, PlacedObject
from target_nav.sim.render import Renderer
from target_nav.state.snapshots import CameraFrame
from target_nav.state.types import DetectionFrame, Pose2D

PREFIX = f"benchdet{os.getpid()}"
CONFIG = Config()
PICTURES = 24
RATE_HZ = 10.0
SECONDS = 12.0
READER_HZ = 30.0
KILLS = 30
IMPORTANT = ("arrive", "undistort", "prepare", "infer", "decode", "look", "publish")
START_S = 60.0


def run() -> list[Row]:
    program, model = find_program(), find_model(CONFIG)
    pictures = _pictures()
    rows = [_reader(pictures)]
    if program is None or model is None:
        missing = "the program is not built" if program is None else "its model is not there"
        print(f"detector: {missing}; drpai/README.md")
        return rows
    try:
        return [*_program(program, model, pictures), *_chain(pictures), *rows]
    finally:
        channels.remove(PREFIX)


def _pictures() -> list[NDArray[np.uint8]]:
    """A pin on an open floor from half a metre to four."""
    rng = np.random.default_rng(7)
    arena = Arena("bench", Bounds(-5.0, -5.0, 5.0, 5.0), Pose2D(), PlacedObject("bowling_pin", 2.0, 0.0))
    renderer = Renderer(arena, CONFIG)
    return [
        renderer.draw(Pose2D(2.0 - float(r), 0.0, float(rng.uniform(-0.2, 0.2))), 0.1 * k, rng)
        for k, r in enumerate(np.linspace(0.6, 4.0, PICTURES))
    ]


@contextmanager
def _process(argv: list[str], log: Path) -> Iterator[subprocess.Popen[bytes]]:
    ready = log.with_suffix(".ready")
    with log.open("wb") as out:
        process = subprocess.Popen(
            argv, stderr=out, env={**os.environ, "OMP_NUM_THREADS": "1", "TARGET_NAV_READY_FILE": str(ready)}
        )
    try:
        end_s = time.monotonic() + START_S
        while not ready.exists():
            if process.poll() is not None or time.monotonic() > end_s:
                raise RuntimeError(log.read_text())
            time.sleep(0.02)
        yield process
    finally:
        process.terminate()
        process.wait()


def _cpu_s(pid: int) -> float:
    text = Path(f"/proc/{pid}/stat").read_text()
    fields = text[text.rindex(")") + 2 :].split()
    return (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK")


def _program(program: Path, model: Path, pictures: list[NDArray[np.uint8]]) -> list[Row]:
    """A picture through the program, alone: CPU time of the process, and its own clock for the stages."""
    with (
        tempfile.TemporaryDirectory() as folder,
        channels.open_writer(channels.SIM_CAMERA, prefix=PREFIX) as camera,
    ):
        log = Path(folder) / "detector.log"
        argv = [str(program), "--prefix", PREFIX, "--model", str(model), "--report", str(SECONDS - 1.0)]
        with _process(argv, log) as process:
            _feed(camera, pictures, 2.0)
            before_s, count = _cpu_s(process.pid), 0
            count = _feed(camera, pictures, SECONDS)
            cpu_ms = 1e3 * (_cpu_s(process.pid) - before_s) / count
        text = log.read_text()
    rows = [
        Row(
            "a picture, work",
            OURS,
            cpu_ms,
            "ms",
            note="CPU time of app_yolo_cam, polling for pictures included",
        ),
        Row("a picture, work", "OpenCV 5 in Python", _python_ms(model, pictures), "ms", note="network alone"),
        Row("a picture, work", "red stripes in Python", _stripes_ms(pictures), "ms", note="no network"),
    ]
    for stage in IMPORTANT:
        found = re.findall(rf" {stage} ([\d.]+)/([\d.]+)/([\d.]+)", text)
        if found:
            p50, p99, _ = found[-1]
            rows.append(Row(f"stage {stage}", OURS, float(p50), "ms", note=f"wall, p50; p99 {p99}"))
    return rows


def _feed(camera: channels.Writer[CameraFrame], pictures: list[NDArray[np.uint8]], seconds: float) -> int:
    begin_s = time.monotonic()
    count = 0
    while (due_s := begin_s + count / RATE_HZ) < begin_s + seconds:
        time.sleep(max(due_s - time.monotonic(), 0.0))
        camera.write(CameraFrame(time.monotonic(), count, pictures[count % len(pictures)]))
        count += 1
    return count


def _python_ms(model: Path, pictures: list[NDArray[np.uint8]]) -> float:
    cv2.setNumThreads(1)
    net = cv2.dnn.readNetFromONNX(str(model))
    names = net.getUnconnectedOutLayersNames()
    times = []
    for image in pictures * 3:
        begin_s = time.thread_time()
        small = cv2.copyMakeBorder(
            cv2.resize(image, (320, 240)), 8, 8, 0, 0, cv2.BORDER_CONSTANT, value=(114,) * 3
        )
        net.setInput(cv2.dnn.blobFromImage(small, 1 / 255.0, swapRB=True))
        net.forward(names)
        times.append(time.thread_time() - begin_s)
    return 1e3 * float(np.median(times))


def _stripes_ms(pictures: list[NDArray[np.uint8]]) -> float:
    detector = PinPixelDetector()
    times = []
    for image in pictures:
        begin_s = time.thread_time()
        detector.detect(image)
        times.append(time.thread_time() - begin_s)
    return 1e3 * float(np.median(times))


def _chain(pictures: list[NDArray[np.uint8]]) -> list[Row]:
    """Camera process with the program behind it, ten pictures a second."""
    with (
        tempfile.TemporaryDirectory() as folder,
        channels.open_writer(channels.SIM_CAMERA, prefix=PREFIX) as camera,
    ):
        logs = Path(folder)
        argv = [
            *(sys.executable, "-m", "target_nav.app.camera_node", "--no-ros", "--prefix", PREFIX),
            *("--detector", "sim", "--logs", folder, "--set", "detector.program=cpp"),
        ]
        with (
            _process(argv, logs / "camera.log") as process,
            channels.open_reader(channels.DET, prefix=PREFIX) as det,
            channels.open_reader(channels.DETECTIONS, prefix=PREFIX) as raw,
        ):
            end_s = time.monotonic() + START_S
            while det.latest() is None and time.monotonic() < end_s:
                _feed(camera, pictures, 0.2)
            delays, behind, objects = [], [], 0
            raw_seen: dict[int, float] = {}
            before_s, begin_s, count = _cpu_s(process.pid), time.monotonic(), 0
            while (now_s := time.monotonic()) < begin_s + SECONDS:
                if now_s >= begin_s + count / RATE_HZ:
                    camera.write(CameraFrame(now_s, count, pictures[count % len(pictures)]))
                    count += 1
                boxes = raw.take_new()
                if boxes is not None:
                    raw_seen[boxes.frame_id] = time.monotonic()
                frame = det.take_new()
                if frame is not None:
                    seen_s = time.monotonic()
                    delays.append(seen_s - frame.stamp_s)
                    behind.append(seen_s - raw_seen.get(frame.frame_id, seen_s))
                    objects += len(frame.detections)
                time.sleep(0.0005)
            share = (_cpu_s(process.pid) - before_s) / (time.monotonic() - begin_s)
            gone_s, torn = _kills(camera, pictures, det)
        infer = re.findall(r" infer ([\d.]+)/", (logs / "detector.log").read_text())
    infer_ms = float(infer[-1]) if infer else 0.0
    delay_ms = [1e3 * float(np.quantile(delays, q)) for q in (0.5, 0.99)]
    return [
        Row(
            "camera process",
            OURS,
            100.0 * share,
            "%",
            note=f"of a core at {RATE_HZ:g} pictures/s, {objects} objects",
        ),
        Row("exposure to v2n_det", OURS, delay_ms[0], "ms", note=f"wall, p50; p99 {delay_ms[1]:.1f}"),
        Row(
            "the same without inference",
            OURS,
            delay_ms[0] - infer_ms,
            "ms",
            note=f"p50s; inference {infer_ms:.1f}",
        ),
        Row(
            "detector killed, back after",
            OURS,
            1e3 * float(np.median(gone_s)),
            "ms",
            note=f"wall, SIGKILL to the next objects, p50 of {KILLS}; max {1e3 * max(gone_s):.0f}",
        ),
        Row("torn pictures accepted", OURS, float(torn), "1", note=f"over {KILLS} kills"),
        Row(
            "boxes to objects",
            OURS,
            1e3 * float(np.median(behind)),
            "ms",
            note="wall, p50, to half a millisecond",
        ),
    ]


def _kills(
    camera: channels.Writer[CameraFrame],
    pictures: list[NDArray[np.uint8]],
    det: channels.Reader[DetectionFrame],
) -> tuple[list[float], int]:
    """SIGKILL at random moments: seconds until objects of a picture taken after it come, and torn pictures accepted."""
    rng = np.random.default_rng(9)
    shown = channels.open_reader(channels.CAMERA, prefix=PREFIX)
    gone_s, torn, count = [], 0, 100_000
    for _ in range(KILLS):
        end_s = time.monotonic() + float(rng.uniform(0.5, 1.5))
        killed_s = math.inf
        while True:
            now_s = time.monotonic()
            if killed_s == math.inf and now_s > end_s:
                (status,) = [s for s in channels.describe(PREFIX) if s.name == "detections"]
                os.kill(status.writer_pid, signal.SIGKILL)
                killed_s = time.monotonic()
            camera.write(CameraFrame(now_s, count, pictures[count % len(pictures)]))
            count += 1
            picture = shown.take_new()
            if picture is not None:
                torn += not np.array_equal(picture.image_bgr, pictures[picture.frame_id % len(pictures)])
            frame = det.take_new()
            if frame is not None and frame.stamp_s > killed_s:
                gone_s.append(time.monotonic() - killed_s)
                break
            time.sleep(0.01)
    shown.close()
    return gone_s, torn


def _reader(pictures: list[NDArray[np.uint8]]) -> Row:
    """A panel that shows every picture of thirty a second: CPU time of taking it out of shared memory."""
    buffer = np.empty((CONFIG.camera.height_px, CONFIG.camera.width_px, 3), np.uint8)
    used_s, taken = 0.0, 0
    writer = channels.open_writer(channels.CAMERA, prefix=PREFIX)
    reader = channels.open_reader(channels.CAMERA, prefix=PREFIX)
    with writer, reader:
        for count in range(int(READER_HZ * 5)):
            writer.write(CameraFrame(time.monotonic(), count, pictures[count % len(pictures)]))
            begin_s = time.thread_time()
            taken += reader.read_into(buffer) is not None
            # A panel asks more often than there is something new.
            reader.read_into(buffer)
            used_s += time.thread_time() - begin_s
            time.sleep(0.3 / READER_HZ)
    return Row(
        "reader of 30 pictures/s",
        OURS,
        100.0 * READER_HZ * used_s / taken,
        "%",
        note="of a core, two polls each",
    )
