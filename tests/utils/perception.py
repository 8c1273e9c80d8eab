"""Perception between two ends that a test holds: it writes the camera's pictures and reads the objects."""

from __future__ import annotations

import subprocess
import time
import uuid
from collections.abc import Callable
from pathlib import Path
from typing import ClassVar

import numpy as np

from target_nav.ipc import channels
from target_nav.state.snapshots import CameraFrame
from target_nav.state.types import DetectionFrame

FRAME_PERIOD_S = 0.05


class PerceptionRig:
    """The test is the simulator (writes sim_camera) and the nav process (reads det)."""

    UNTIL_LIMIT_S: ClassVar[float]
    """How long `until` waits if it is not told."""

    def __init__(self, folder: Path, image: np.ndarray) -> None:
        self.prefix = f"t{uuid.uuid4().hex[:10]}"
        self.folder = folder
        self.image = image
        self.sent: set[float] = set()
        self.running: list[subprocess.Popen[str]] = []
        self.sim_camera = channels.open_writer(channels.SIM_CAMERA, prefix=self.prefix)
        self.det = channels.open_reader(channels.DET, prefix=self.prefix)

    def send(self) -> None:
        stamp_s = time.monotonic()
        self.sent.add(stamp_s)
        self.sim_camera.write(CameraFrame(stamp_s, len(self.sent), self.image))
        time.sleep(FRAME_PERIOD_S)

    def until(self, wanted: Callable[[DetectionFrame], bool], limit_s: float | None = None) -> DetectionFrame:
        """Send pictures until a frame on `det` is as wanted."""
        limit_s = self.UNTIL_LIMIT_S if limit_s is None else limit_s
        deadline_s = time.monotonic() + limit_s
        newest = None
        while time.monotonic() < deadline_s:
            self.send()
            frame = self.det.take_new()
            newest = frame or newest
            if frame is not None and wanted(frame):
                return frame
        raise AssertionError(f"not within {limit_s} s; the newest is {newest}; {self.log()}")

    def log(self) -> str:
        return ""

    def close(self) -> None:
        for process in self.running:
            process.kill()
            process.communicate()
        self.sim_camera.close()
        self.det.close()
        for file in Path("/dev/shm").glob(f"{self.prefix}_*"):
            file.unlink()


def has_object(frame: DetectionFrame) -> bool:
    return any(detection.confirmed for detection in frame.detections)
