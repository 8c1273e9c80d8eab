"""Pictures of random arenas by the simulator's own renderer, with their boxes."""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np

from deploy.model.degrade import degrade
from deploy.model.scenes import HEIGHT, HEIGHT_MIN_PX, VISIBLE_MIN, WIDTH, ImageBgr, Rng, Scene

PIN = "bowling_pin"


@dataclass(frozen=True, eq=False)
class FrameBank:
    scenes: list[Scene]

    def draw(self, rng: Rng) -> Scene:
        """One of the pictures, mirrored or not, through another camera's eye."""
        scene = self.scenes[int(rng.integers(len(self.scenes)))]
        image: ImageBgr = scene.image_bgr
        boxes, ignored = scene.boxes, scene.ignored
        if rng.random() < 0.5:
            image = np.ascontiguousarray(image[:, ::-1])
            boxes, ignored = _mirror(boxes), _mirror(ignored)
        if rng.random() < 0.8:
            image = degrade(image, rng)
        return Scene(image, boxes, ignored)


def _mirror(boxes: np.ndarray) -> np.ndarray:
    return np.stack([WIDTH - boxes[:, 2], boxes[:, 1], WIDTH - boxes[:, 0], boxes[:, 3]], 1)


def make_frames(rng: Rng, count: int) -> FrameBank:
    raise NotImplementedError
