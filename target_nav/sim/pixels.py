"""The camera of virtual time with real pictures: every frame is rendered and looked at by a real detector.

It takes `BoxCamera`'s place. What a frame shows is drawn when it is exposed, and its boxes come as late as theirs do.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from target_nav.config import CameraConfig
from target_nav.sim.arena_types import PlacedObject
from target_nav.sim.exposure import ExposedCamera
from target_nav.sim.history import PoseHistory
from target_nav.state.types import Pose2D, RawDetection

ImageBgr = NDArray[np.uint8]
Detect = Callable[[ImageBgr], tuple[RawDetection, ...]]


class Painter(Protocol):
    """What `render.Renderer` does, which only who wants pictures loads."""

    def draw(self, true_pose: Pose2D, stamp_s: float, rng: np.random.Generator) -> ImageBgr: ...

    def move_target(self, target: PlacedObject) -> None: ...


class PixelCamera(ExposedCamera):
    """Frames that are really drawn, and the boxes that are really found in them."""

    def __init__(
        self,
        config: CameraConfig,
        painter_for: Callable[[float], Painter],
        detect: Detect,
        rng: np.random.Generator,
        start_s: float,
    ) -> None:
        """`painter_for` gets the mount's error, rad, and gives what draws."""
        super().__init__(config, rng, start_s)
        self._painter = painter_for(self.mount_error_rad)
        self._detect = detect

    def move_target(self, target: PlacedObject) -> None:
        self._painter.move_target(target)

    def _boxes(self, stamp_s: float, history: PoseHistory) -> tuple[RawDetection, ...]:
        return self._detect(self._painter.draw(Pose2D(*history.at(stamp_s)), stamp_s, self._rng))
