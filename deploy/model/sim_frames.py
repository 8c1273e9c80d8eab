"""Pictures of random arenas by the simulator's own renderer, with their boxes."""

from __future__ import annotations

import math
from collections.abc import Callable
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
WHOLE_SHARE = 0.5
LOOK_SCALES = (1.0, 2.4)
"""Of the second look, in the network's pixels a pixel of the frame."""
OUTSIDE_BELOW = 0.05


@dataclass(frozen=True, eq=False)
class FrameBank:
    """Whole frames, boxes in their pixels; `odd`: what is no pin, (things, 2) pixels a frame."""

    frames: list[Scene]
    odd: list[np.ndarray]

    def draw(self, rng: Rng) -> Scene:
        """A frame as the first look sees it or a part of one as the second does, mirrored or not, mostly through
        another camera's eye."""
        index = int(rng.integers(len(self.frames)))
        frame = self.frames[index]
        scene = _whole(frame) if rng.random() < WHOLE_SHARE else _part(frame, self.odd[index], rng)
        image: ImageBgr = scene.image_bgr
        boxes, ignored = scene.boxes, scene.ignored
        if rng.random() < 0.5:
            image = np.ascontiguousarray(image[:, ::-1])
            boxes, ignored = _mirror(boxes), _mirror(ignored)
        if rng.random() < 0.5:
            image = degrade(image, rng)
        return Scene(image, boxes, ignored)


def _whole(frame: Scene) -> Scene:
    scale = WIDTH / frame.image_bgr.shape[1]
    return _cut(frame, 0.0, 0.0, scale)


def _part(frame: Scene, odd: np.ndarray, rng: Rng) -> Scene:
    """A part at `scale` times the frame's own pixels, mostly with a pin or a thing that is none in it."""
    scale = float(np.exp(rng.uniform(math.log(LOOK_SCALES[0]), math.log(LOOK_SCALES[1]))))
    rows, columns = frame.image_bgr.shape[:2]
    width, height = WIDTH / scale, HEIGHT / scale
    kind = rng.random()
    middle = rng.uniform(0, 1, 2) * (columns, rows)
    if len(frame.boxes) and kind < 0.65:
        box = frame.boxes[int(rng.integers(len(frame.boxes)))]
        middle = 0.5 * (box[:2] + box[2:]) + rng.uniform(-0.45, 0.45, 2) * (width, height)
    elif len(odd) and kind < 0.95:
        middle = odd[int(rng.integers(len(odd)))] + rng.uniform(-0.45, 0.45, 2) * (width, height)
    u = float(np.clip(middle[0] - 0.5 * width, 0.0, columns - width))
    v = float(np.clip(middle[1] - 0.5 * height, 0.0, rows - height))
    return _cut(frame, u, v, scale)


def _cut(frame: Scene, u: float, v: float, scale: float) -> Scene:
    """The WIDTH x HEIGHT picture whose corner is the frame's pixel (u, v), boxes judged by what of them lies in it."""
    u, v = round(u), round(v)
    width, height = round(WIDTH / scale), round(HEIGHT / scale)
    method = cv2.INTER_AREA if scale < 1.0 else cv2.INTER_LINEAR
    image = cv2.resize(frame.image_bgr[v : v + height, u : u + width], (WIDTH, HEIGHT), interpolation=method)
    stretch = np.array([WIDTH / width, HEIGHT / height] * 2)
    sorted_: tuple[list[np.ndarray], list[np.ndarray]] = ([], [])
    for known, given in ((True, frame.boxes), (False, frame.ignored)):
        for box in (given - (u, v, u, v)) * stretch:
            kept = np.clip(box, 0.0, (WIDTH, HEIGHT, WIDTH, HEIGHT))
            share = np.prod(kept[2:] - kept[:2]) / max(float(np.prod(box[2:] - box[:2])), 1e-6)
            if share < OUTSIDE_BELOW:
                continue
            good = known and share >= IN_PICTURE_MIN and box[3] - box[1] >= HEIGHT_MIN_PX
            sorted_[0 if good else 1].append(box)
    boxes, ignored = (np.array(some, np.float32).reshape(-1, 4) for some in sorted_)
    return Scene(np.asarray(image, np.uint8), boxes, ignored)


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


def _clear(place: Callable[[], tuple[float, float]], least_m: float) -> tuple[float, float]:
    while True:
        x, y = place()
        if math.hypot(x, y) > least_m:
            return x, y


def make_frames(rng: Rng, count: int) -> FrameBank:
    """`count` pictures of 640 x 480: several from each arena, of several cameras' heights and focal lengths."""
    scenes: list[Scene] = []
    odd: list[np.ndarray] = []
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
            near = rng.random() < 0.5
            range_m = float(
                np.exp(rng.uniform(math.log(0.2), math.log(4.5))) if near else rng.uniform(1.5, 4.8)
            )
            around, bearing = float(rng.uniform(-math.pi, math.pi)), float(rng.uniform(-0.6, 0.6))
            pose = Pose2D(range_m * math.cos(around), range_m * math.sin(around), around + math.pi - bearing)
            picture = renderer.draw(pose, float(rng.uniform(0, 10)), rng)
            boxes, ignored = _labels(renderer, pose)
            scenes.append(Scene(picture, boxes, ignored))
            odd.append(_odd_things(renderer, pose))
    return FrameBank(scenes[:count], odd[:count])


def _labels(renderer: Renderer, pose: Pose2D) -> tuple[np.ndarray, np.ndarray]:
    boxes, ignored = [], []
    for box in renderer.true_boxes(pose):
        if box.class_name != PIN:
            continue
        edges = (box.left_px, box.top_px, box.right_px, box.bottom_px)
        good = box.visible >= VISIBLE_MIN and box.in_picture >= IN_PICTURE_MIN
        (boxes if good else ignored).append(edges)
    return np.array(boxes, np.float32).reshape(-1, 4), np.array(ignored, np.float32).reshape(-1, 4)


def _odd_things(renderer: Renderer, pose: Pose2D) -> np.ndarray:
    return np.array(
        [(0.5 * (box.left_px + box.right_px), 0.5 * (box.top_px + box.bottom_px))
         for box in renderer.true_boxes(pose) if box.class_name != PIN and box.visible > 0.2], float
    ).reshape(-1, 2)  # fmt: skip
