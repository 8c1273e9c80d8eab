"""When the simulated camera exposes a frame and when its boxes arrive, whatever looks at the frame."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections import deque

import numpy as np

from target_nav.config import CameraConfig
from target_nav.sim.arena_types import PlacedObject
from target_nav.sim.history import PoseHistory
from target_nav.state.types import RawDetection, RawDetectionFrame

MAX_UNDER_WAY = 256
"""Frames that are in the detector or that nobody took: over 2 s at the highest rate."""

_SAME_TIME_S = 1e-9


class ExposedCamera(ABC):
    """`advance` exposes the frames that are due, `take` hands over those that are through the detector."""

    def __init__(self, config: CameraConfig, rng: np.random.Generator, start_s: float) -> None:
        self._config = config
        self._rng = rng
        self._first_s = start_s + float(rng.random()) / config.rate_hz
        self._frame_id = 0
        self.due_s = self._first_s
        self.mount_error_rad = float(rng.uniform(-1.0, 1.0)) * config.mount_error_rad
        """How far the camera really looks to the left of where it should: constant, unknown to the robot."""
        self._under_way: deque[RawDetectionFrame] = deque(maxlen=MAX_UNDER_WAY)

    @abstractmethod
    def move_target(self, target: PlacedObject) -> None:
        """The target, the first of the things, is there now."""

    @abstractmethod
    def _boxes(self, stamp_s: float, history: PoseHistory) -> tuple[RawDetection, ...]:
        """What is found in a frame of that time."""

    def advance(self, now_s: float, history: PoseHistory) -> None:
        while self.due_s <= now_s:
            boxes = self._boxes(self.due_s, history)
            self._under_way.append(RawDetectionFrame(self.due_s, self._frame_id, boxes))
            self._frame_id += 1
            self.due_s = self._first_s + self._frame_id / self._config.rate_hz

    def take(self, now_s: float) -> list[RawDetectionFrame]:
        """Frames that are delivered by now, oldest first."""
        ready: list[RawDetectionFrame] = []
        latency_s = self._config.latency_s
        while self._under_way and self._under_way[0].stamp_s + latency_s <= now_s + _SAME_TIME_S:
            ready.append(self._under_way.popleft())
        return ready
