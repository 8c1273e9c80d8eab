"""The camera of virtual time with real pictures: every frame is rendered and looked at by a real detector.

It takes `BoxCamera`'s place. What a frame shows is drawn when it is exposed, and its boxes come as late as theirs do.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from target_nav.config import CameraConfig
from target_nav.sim.boxes import MAX_UNDER_WAY
from target_nav.sim.history import PoseHistory
from target_nav.state.types import Pose2D, RawDetection, RawDetectionFrame

ImageBgr = NDArray[np.uint8]
Detect = Callable[[ImageBgr], tuple[RawDetection, ...]]
Draw = Callable[[Pose2D, float, np.random.Generator], ImageBgr]


class PixelCamera:
    """`advance` exposes the frames that are due, `take` hands over those that are through the detector."""

    def __init__(
        self,
        config: CameraConfig,
        draw_with: Callable[[float], Draw],
        detect: Detect,
        rng: np.random.Generator,
        start_s: float,
    ) -> None:
        """`draw_with` gets the mount's error, rad, and gives what draws."""
        self._config = config
        self._rng = rng
        self._first_s = start_s + float(rng.random()) / config.rate_hz
        self._frame_id = 0
        self.due_s = self._first_s
        self.mount_error_rad = float(rng.uniform(-1.0, 1.0)) * config.mount_error_rad
        """How far the camera really looks to the left of where it should: constant, unknown to the robot."""
        self._draw = draw_with(self.mount_error_rad)
        self._detect = detect
        self._under_way: deque[RawDetectionFrame] = deque(maxlen=MAX_UNDER_WAY)

    def advance(self, now_s: float, history: PoseHistory) -> None:
        while self.due_s <= now_s:
            picture = self._draw(Pose2D(*history.at(self.due_s)), self.due_s, self._rng)
            self._under_way.append(RawDetectionFrame(self.due_s, self._frame_id, self._detect(picture)))
            self._frame_id += 1
            self.due_s = self._first_s + self._frame_id / self._config.rate_hz

    def take(self, now_s: float) -> list[RawDetectionFrame]:
        """Frames that are delivered by now, oldest first."""
        ready: list[RawDetectionFrame] = []
        while self._under_way and self._under_way[0].stamp_s + self._config.latency_s <= now_s + 1e-9:
            ready.append(self._under_way.popleft())
        return ready
