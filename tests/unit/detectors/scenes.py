"""Rendered pictures with what is to be found in them."""

from __future__ import annotations

import math
from functools import lru_cache

import numpy as np

from target_nav.config import Config
from target_nav.detectors.detector import ImageBgr
from target_nav.sim.arena import Arena, Bounds, BoxObstacle, CircleObstacle, PlacedObject
from target_nav.sim.render import Renderer
from target_nav.state.types import Pose2D
from target_nav.utils.distance import Box, clip_box, project

CONFIG = Config()
PIN = PlacedObject("bowling_pin", 0.0, 0.0)
FAR = Bounds(-6.0, -6.0, 6.0, 6.0)
NO_PIN = Bounds(-3.0, -3.0, 3.0, 3.0)
SPEC = PIN.shape

BACKGROUNDS: dict[str, Arena] = {
    "open floor": Arena("open", FAR, Pose2D(-2.0, 0.0, 0.0), PIN),
    "at a white wall": Arena("wall", Bounds(-6.0, -6.0, 0.08, 6.0), Pose2D(-2.0, 0.0, 0.0), PIN),
    "in front of boxes and beside bottles": Arena(
        "clutter",
        FAR,
        Pose2D(-2.0, 0.0, 0.0),
        PIN,
        obstacles=tuple(BoxObstacle(0.35, -0.9 + 0.45 * i, 0.3, 0.4, 0.1 * i) for i in range(5)),
        decoys=(
            PlacedObject("bottle", 0.05, 0.35),
            PlacedObject("bottle", 0.05, -0.35),
            PlacedObject("can", 0.0, 0.6),
            PlacedObject("cone", 0.0, -0.75),
        ),
    ),
}


@lru_cache(maxsize=8)
def renderer(background: str) -> Renderer:
    return Renderer(BACKGROUNDS[background], CONFIG)


def base_pose(range_m: float, bearing_rad: float, from_rad: float) -> Pose2D:
    """base_link's pose from which the camera sees the world's origin at that range and bearing."""
    x, y = -range_m * math.cos(from_rad), -range_m * math.sin(from_rad)
    yaw = from_rad - bearing_rad
    camera = CONFIG.camera
    return Pose2D(x - camera.x_m * math.cos(yaw), y - camera.x_m * math.sin(yaw), yaw)


def picture_of_pin(
    background: str, range_m: float, bearing_rad: float = 0.0, from_rad: float = 0.1
) -> ImageBgr:
    seed = int(range_m * 1000.0) + int(bearing_rad * 1000.0) + 1000
    pose = base_pose(range_m, bearing_rad, from_rad)
    return renderer(background).draw(pose, 0.1 * seed, np.random.default_rng(seed))


def true_box(range_m: float, bearing_rad: float) -> Box:
    """The visible part of the pin's box."""
    box = project(CONFIG.camera, range_m, bearing_rad, SPEC.height_m, 2.0 * SPEC.radius_m)
    visible = clip_box(CONFIG.camera, box) if box is not None else None
    assert visible is not None
    return visible


def room_without_pin(seed: int) -> Arena:
    """Boxes, cylinders and decoys of every class but the target's, anywhere."""
    rng = np.random.default_rng(seed)
    classes = ("bottle", "can", "cup", "vase", "ball", "cone", "bin", "chair_leg")

    def place() -> tuple[float, float]:
        x, y = rng.uniform(-2.6, 2.6, 2)
        return float(x), float(y)

    boxes = tuple(BoxObstacle(*place(), 0.4, 0.3, float(rng.uniform(0.0, 3.0))) for _ in range(6))
    circles = tuple(CircleObstacle(*place(), 0.15) for _ in range(5))
    decoys = tuple(PlacedObject(classes[i % len(classes)], *place()) for i in range(16))
    return Arena("no_pin", NO_PIN, Pose2D(), None, obstacles=boxes + circles, decoys=decoys)
