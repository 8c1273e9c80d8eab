"""Pictures of random arenas by the simulator's own renderer, with their boxes."""

from __future__ import annotations

import math
from dataclasses import dataclass

import cv2
import numpy as np

from deploy.model.degrade import degrade
from deploy.model.scenes import (
    HEIGHT,
    HEIGHT_MIN_PX,
    IN_PICTURE_MIN,
    VISIBLE_MIN,
    WIDTH,
    ImageBgr,
    Rng,
    Scene,
)
from target_nav.config import Config
from target_nav.sim.arena import Arena, Bounds, BoxObstacle, CircleObstacle, PlacedObject, WallObstacle
from target_nav.sim.render import Renderer
from target_nav.sim.render_look import Look
from target_nav.state.types import Pose2D

PIN = "bowling_pin"
DECOYS = ("bottle", "bottle", "can", "cup", "vase", "ball", "cone", "cone", "bin", "chair_leg")
PICTURES_PER_ARENA = 6


@dataclass(frozen=True, eq=False)
class FrameBank:
    scenes: list[Scene]

    def draw(self, rng: Rng) -> Scene:
        """One of the pictures, mirrored or not, mostly through another camera's eye."""
        scene = self.scenes[int(rng.integers(len(self.scenes)))]
        image: ImageBgr = scene.image_bgr
        boxes, ignored = scene.boxes, scene.ignored
        if rng.random() < 0.5:
            image = np.ascontiguousarray(image[:, ::-1])
            boxes, ignored = _mirror(boxes), _mirror(ignored)
        if rng.random() < 0.7:
            image = degrade(image, rng)
        return Scene(image, boxes, ignored)


def _mirror(boxes: np.ndarray) -> np.ndarray:
    return np.stack([WIDTH - boxes[:, 2], boxes[:, 1], WIDTH - boxes[:, 0], boxes[:, 3]], 1)


def any_arena(rng: Rng, clutter: bool = True, pins: int = 1) -> Arena:
    """A room with a pin at its origin, obstacles and things that are no pins round it, none nearer than 0.3 m."""

    def place(reach_m: float = 3.2) -> tuple[float, float]:
        while True:
            x, y = (float(value) for value in rng.uniform(-reach_m, reach_m, 2))
            if math.hypot(x, y) > 0.4:
                return x, y

    bounds = Bounds(*(-rng.uniform(2.0, 6.0, 2)).tolist(), *rng.uniform(2.0, 6.0, 2).tolist())
    obstacles: list[BoxObstacle | CircleObstacle | WallObstacle] = []
    decoys: list[PlacedObject] = []
    if clutter:
        for _ in range(int(rng.integers(0, 6))):
            size = rng.uniform(0.15, 0.5, 2)
            obstacles.append(
                BoxObstacle(*_clear(place, 0.7), float(size[0]), float(size[1]), float(rng.uniform(0, 3)))
            )
        for _ in range(int(rng.integers(0, 4))):
            obstacles.append(CircleObstacle(*_clear(place, 0.6), float(rng.uniform(0.06, 0.25))))
        for _ in range(int(rng.integers(1, 10))):
            decoys.append(PlacedObject(DECOYS[int(rng.integers(len(DECOYS)))], *place()))
    decoys += [PlacedObject(PIN, *place()) for _ in range(pins - 1)]
    target = PlacedObject(PIN, 0.0, 0.0) if pins else None
    return Arena("drawn", bounds, Pose2D(-1.8, 0.0, 0.0), target, None, tuple(obstacles), tuple(decoys))


def _clear(place, least_m: float) -> tuple[float, float]:  # type: ignore[no-untyped-def]
    while True:
        x, y = place()
        if math.hypot(x, y) > least_m:
            return x, y


def make_frames(rng: Rng, count: int) -> FrameBank:
    """`count` pictures at WIDTH x HEIGHT: several from each arena, of several cameras' heights and focal lengths."""
    scenes: list[Scene] = []
    while len(scenes) < count:
        arena = any_arena(
            rng, clutter=rng.random() < 0.9, pins=int(rng.choice([0, 1, 2, 4], p=[0.15, 0.35, 0.3, 0.2]))
        )
        config = Config().override(
            {"camera.z_m": float(rng.uniform(0.08, 0.35)), "camera.focal_px": float(rng.uniform(420, 720)),
             "camera.noise_scale": float(rng.uniform(0.0, 2.0))}
        )  # fmt: skip
        renderer = Renderer(arena, config, look=Look.of(int(rng.integers(0, 1_000_000))))
        for _ in range(PICTURES_PER_ARENA):
            range_m = float(np.exp(rng.uniform(math.log(0.2), math.log(4.5))))
            around, bearing = float(rng.uniform(-math.pi, math.pi)), float(rng.uniform(-0.6, 0.6))
            pose = Pose2D(range_m * math.cos(around), range_m * math.sin(around), around + math.pi - bearing)
            picture = renderer.draw(pose, float(rng.uniform(0, 10)), rng)
            boxes, ignored = _labels(renderer, pose)
            small = np.asarray(cv2.resize(picture, (WIDTH, HEIGHT), interpolation=cv2.INTER_AREA), np.uint8)
            scenes.append(Scene(small, boxes, ignored))
    return FrameBank(scenes[:count])


def _labels(renderer: Renderer, pose: Pose2D) -> tuple[np.ndarray, np.ndarray]:
    boxes, ignored = [], []
    for box in renderer.true_boxes(pose):
        if box.class_name != PIN:
            continue
        edges = (0.5 * box.left_px, 0.5 * box.top_px, 0.5 * box.right_px, 0.5 * box.bottom_px)
        good = (
            box.visible >= VISIBLE_MIN
            and box.in_picture >= IN_PICTURE_MIN
            and edges[3] - edges[1] >= HEIGHT_MIN_PX
        )
        (boxes if good else ignored).append(edges)
    return np.array(boxes, np.float32).reshape(-1, 4), np.array(ignored, np.float32).reshape(-1, 4)
