"""The browser console's costs: `target-nav web` beside a stand-in for the stack, with no viewer, three, and slow ones.

The stand-in writes what a stack writes, as often: pictures of 640x480 with the noise of a camera, boxes, a scan of 360
points, a tree of 40 rows. A viewer is a program that takes and acknowledges what a page would. The server is a process
of its own, and its figures are the kernel's. The peer is the same server with nobody looking.
"""

from __future__ import annotations

import json
import multiprocessing
import os
import re
import subprocess
import sys
import tempfile
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import closing, contextmanager
from pathlib import Path

import numpy as np

from benchmarks import OURS, Row
from target_nav.ipc import channels
from target_nav.state.snapshots import CameraFrame, LaserSnapshot, NavSnapshot, NodeStatus, TreeRow, TreeState
from target_nav.state.types import Detection, DetectionFrame, NavState, Pose2D, TargetSpec, Track, Twist2D

SECONDS = float(os.environ.get("TARGET_NAV_BENCH_SECONDS", "20"))
"""Of one measurement. For growth: 600."""
SETTLE_S = 4.0
TICK_S = 0.05
TOKEN = "benchmark-token"
_TICKS_PER_S = os.sysconf("SC_CLK_TCK")


def run() -> list[Row]:
    prefix = f"bench_web_{os.getpid()}"
    ticks: list[float] = []
    with _stack(prefix, ticks), _server(prefix) as (pid, port):
        time.sleep(SETTLE_S)
        alone = _measure(pid)
        quiet_late_s = _p99(ticks)
        with _viewers(port, 3):
            time.sleep(SETTLE_S)
            ticks.clear()
            three = _measure(pid)
        busy_late_s = _p99(ticks)
        with _viewers(port, 3, slow=True):
            time.sleep(SETTLE_S)
            slow = _measure(pid)
        took_ms = _stop_times_ms(port)
    return [
        Row(
            "core used, three viewers",
            OURS,
            three.core_percent,
            "%",
            "10 looks and 10 pictures a second each",
        ),
        Row("core used, three viewers", "nobody looking", alone.core_percent, "%"),
        Row("core used, three viewers", "three that take one message in 2 s", slow.core_percent, "%"),
        Row("memory, three viewers", OURS, three.memory_mb, "MB", "resident, with what is shared"),
        Row("memory, three viewers", "nobody looking", alone.memory_mb, "MB"),
        Row("memory, three viewers", "three that take one message in 2 s", slow.memory_mb, "MB"),
        Row(f"growth over {SECONDS:g} s, three viewers", OURS, three.growth_mb, "MB"),
        Row("lateness of the writer's 20 Hz, p99", OURS, 1e3 * busy_late_s, "ms", "three viewers"),
        Row("lateness of the writer's 20 Hz, p99", "nobody looking", 1e3 * quiet_late_s, "ms"),
        Row(
            "STOP to acknowledgement, worst of 20",
            OURS,
            took_ms,
            "ms",
            "reader polls at 20 Hz: 50 ms are its own",
        ),
    ]


class _Cost:
    def __init__(self, core_percent: float, memory_mb: float, growth_mb: float) -> None:
        self.core_percent, self.memory_mb, self.growth_mb = core_percent, memory_mb, growth_mb


def _measure(pid: int) -> _Cost:
    began_s, cpu_s, memory_mb = time.monotonic(), _cpu_s(pid), _memory_mb(pid)
    time.sleep(SECONDS)
    took_s = time.monotonic() - began_s
    now_mb = _memory_mb(pid)
    return _Cost(100.0 * (_cpu_s(pid) - cpu_s) / took_s, now_mb, now_mb - memory_mb)


def _cpu_s(pid: int) -> float:
    fields = Path(f"/proc/{pid}/stat").read_text().rsplit(")", 1)[1].split()
    return (int(fields[11]) + int(fields[12])) / _TICKS_PER_S


def _memory_mb(pid: int) -> float:
    found = re.search(r"VmRSS:\s+(\d+) kB", Path(f"/proc/{pid}/status").read_text())
    assert found is not None, "a live process has a size"
    return int(found[1]) / 1024.0


def _p99(late_s: list[float]) -> float:
    return float(np.percentile(late_s, 99)) if late_s else 0.0


# -- the stack ---------------------------------------------------------------------------------------------------------


@contextmanager
def _stack(prefix: str, late_s: list[float]) -> Iterator[None]:
    end = threading.Event()
    thread = threading.Thread(target=_write, args=(prefix, end, late_s))
    thread.start()
    try:
        yield
    finally:
        end.set()
        thread.join()
        channels.remove(prefix)


def _write(prefix: str, end: threading.Event, late_s: list[float]) -> None:
    noise = np.random.default_rng(1)
    pictures = [_picture(noise) for _ in range(4)]
    angles = np.linspace(0.0, 2.0 * np.pi, 360, endpoint=False)
    directions = np.column_stack((np.cos(angles), np.sin(angles)))
    with (
        closing(channels.open_writer(channels.NAV, prefix)) as nav,
        closing(channels.open_writer(channels.LASER, prefix)) as laser,
        closing(channels.open_writer(channels.TREE, prefix)) as tree,
        closing(channels.open_writer(channels.DET, prefix)) as det,
        closing(channels.open_writer(channels.CAMERA, prefix)) as camera,
        closing(channels.open_command_reader(prefix)) as commands,
    ):
        next_s, tick = time.monotonic(), 0
        while not end.is_set():
            now_s = time.monotonic()
            late_s.append(max(0.0, now_s - next_s))
            pose = Pose2D(0.007 * (tick % 600), 0.3 * np.sin(0.01 * tick), 0.0)
            commands.pop_all()
            nav.write(_nav(now_s, tick, pose))
            if tick % 4 == 0:
                ranges = 3.0 + noise.normal(0.0, 0.01, 360)
                laser.write(LaserSnapshot(now_s, pose, ranges[:, None] * directions))
            if tick % 2 == 0:
                tree.write(_tree(now_s, tick))
                det.write(DetectionFrame(now_s, tick, (_detection(tick),)))
                camera.write(CameraFrame(now_s, tick, pictures[tick // 2 % len(pictures)]))
            tick += 1
            next_s = max(next_s + TICK_S, now_s)
            time.sleep(max(0.0, next_s - time.monotonic()))


def _picture(noise: np.random.Generator) -> np.ndarray:
    v, u = np.mgrid[0:480, 0:640]
    plain = 90.0 + 40.0 * np.sin(u / 60.0) + 30.0 * (v > 240)
    grainy = plain[:, :, None] + noise.normal(0.0, 3.0, (480, 640, 3))
    return np.clip(grainy, 0, 255).astype(np.uint8)


def _nav(now_s: float, tick: int, pose: Pose2D) -> NavSnapshot:
    track = Track(now_s, 3.0, 0.5, (0.01, 0.0, 0.0, 0.02), True, 9, now_s, now_s, 3.0, 0.2)
    return NavSnapshot(
        now_s, tick, NavState.NAVIGATING, None, "NavigateToTarget", f"target {3 - 0.001 * (tick % 900):.2f} m off",
        True, pose, Twist2D(0.15), "", track, TargetSpec(), 0.1, 0.05, 0.1, 20.0, 0.001, 0, "bowling_pin",
    )  # fmt: skip


def _tree(now_s: float, tick: int) -> TreeState:
    says = f"says {tick % 50} m"
    rows = tuple(
        TreeRow(
            f"Behaviour {n}", "Sequence", n % 9, NodeStatus(n % 4), n % 3 == 0, says if n % 5 == 0 else ""
        )
        for n in range(40)
    )
    return TreeState(now_s, tick, len(rows), rows)


def _detection(tick: int) -> Detection:
    return Detection(
        "bowling_pin", 0.9, 1, 320.0 + tick % 7, 240.0, 22.0, 70.0, 2.2, 0.08, 0.01, 0.01, False, True
    )


# -- the server and who looks ------------------------------------------------------------------------------------------


@contextmanager
def _server(prefix: str) -> Iterator[tuple[int, int]]:
    with tempfile.TemporaryDirectory() as folder:
        process = subprocess.Popen(
            [
                *(sys.executable, "-m", "target_nav.app.cli", "web", "--prefix", prefix, "--port", "0"),
                *("--token", TOKEN, "--runs", folder),
            ],
            stdout=subprocess.PIPE,
            text=True,
        )
        try:
            assert process.stdout is not None
            address = process.stdout.readline()
            found = re.search(r":(\d+)/", address)
            assert found is not None, f"no address in {address!r}"
            time.sleep(1.0)
            yield process.pid, int(found[1])
        finally:
            process.terminate()
            process.wait(10.0)


@contextmanager
def _viewers(port: int, count: int, slow: bool = False) -> Iterator[None]:
    """Processes of their own: in threads they would take turns with the stand-in."""
    context = multiprocessing.get_context("spawn")
    viewers = [
        context.Process(target=_look, args=(port, 2.0 if slow else 0.0), daemon=True) for _ in range(count)
    ]
    for viewer in viewers:
        viewer.start()
    try:
        yield
        assert all(viewer.is_alive() for viewer in viewers), "a viewer was thrown out"
    finally:
        for viewer in viewers:
            viewer.terminate()
            viewer.join()


def _look(port: int, pause_s: float) -> None:
    from websockets.sync.client import connect

    with connect(f"ws://127.0.0.1:{port}/ws", compression=None) as socket:
        socket.send(json.dumps({"t": "hello", "token": None}))
        socket.send(json.dumps({"t": "want", "pictures": True, "views": True}))
        views = pictures = 0
        while True:
            data = socket.recv()
            if isinstance(data, bytes):
                pictures = int.from_bytes(data[:4], "little")
            else:
                views = json.loads(data).get("n", views)
            time.sleep(pause_s)
            socket.send(json.dumps({"t": "seen", "views": views, "pictures": pictures}))


def _stop_times_ms(port: int) -> float:
    from websockets.sync.client import connect

    worst_s = 0.0
    with connect(f"ws://127.0.0.1:{port}/ws", compression=None) as socket:
        socket.send(json.dumps({"t": "hello", "token": TOKEN}))
        socket.send(json.dumps({"t": "want", "pictures": False, "views": False}))
        for number in range(20):
            began_s = time.monotonic()
            socket.send(json.dumps({"t": "ask", "id": number, "what": "stop", "args": {}}))
            _until(lambda: json.loads(socket.recv()).get("id") == number)  # noqa: B023
            worst_s = max(worst_s, time.monotonic() - began_s)
            time.sleep(0.037)
    return 1e3 * worst_s


def _until(condition: Callable[[], bool]) -> None:
    while not condition():
        pass
