"""The camera and its detector for virtual time: boxes in pixels, with what a real detector gets wrong.

A thing is an upright cylinder seen by a level pinhole camera; what hides it narrows its box or takes it away. Boxes
jitter, are missed, are invented, are cut off at the picture's border, and come late. Figures: `docs/simulator.md`.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from target_nav.config import CameraConfig
from target_nav.sim.arena_types import PlacedObject
from target_nav.sim.exposure import ExposedCamera
from target_nav.sim.history import PoseHistory
from target_nav.sim.objects import is_tag, shape_of
from target_nav.sim.tags import TagReader
from target_nav.sim.world import RayCaster
from target_nav.state.types import Pose2D, RawDetection

SHAKE_RAD = math.radians(0.4)
"""Sigma of a frame's direction, the same for all boxes in it: with the edges' jitter the measured 0.4-0.7 degrees."""

MIN_VISIBLE = 0.35
"""Of a thing's width and of its height: less than this is not recognised. An assumption."""

MIN_BOX_PX = 4.0

MISLABEL_PROBABILITY = 0.05
"""A decoy's box carries the target's class: an assumption, of the size of a small detector's confusion between upright
bottles and pins. Such a box is up to `MISLABEL_STRETCH` times too wide, for it takes in some of what is beside it."""
MISLABEL_STRETCH = 2.0

SCORE_NEAR = 0.90
SCORE_LOSS_PER_M = 0.07
SCORE_SIGMA = 0.05
"""Scores fall with range to about 0.66 at 4 m, where pins are hardly found any more."""
SCORE_DOUBTFUL = (0.30, 0.70)
"""Mislabelled and invented boxes."""

FALSE_HEIGHT_PX = (20.0, 160.0)
FALSE_ASPECT_SIGMA = 0.6
"""Of ln(width:height) of an invented box, round the target's own shape."""

RAYS = 9
"""Across a thing, to see how much of it is hidden."""

_MAX_ANGLE_RAD = math.radians(85.0)
_HIT_TOLERANCE_M = 0.01


@dataclass(frozen=True)
class _Sight:
    """A thing in the picture, before the detector's errors: edges in pixels, visible share, range from the camera."""

    left: float
    top: float
    right: float
    bottom: float
    visible: float
    range_m: float


class BoxCamera(ExposedCamera):
    """Boxes without a picture: what a detector would say."""

    def __init__(
        self,
        config: CameraConfig,
        things: tuple[PlacedObject, ...],
        target_class: str,
        caster: RayCaster,
        rng: np.random.Generator,
        start_s: float,
    ) -> None:
        super().__init__(config, rng, start_s)
        self._focal_px = config.focal_px * (1.0 + config.focal_error)
        self._half_fov_rad = math.atan2(0.5 * config.width_px, self._focal_px)
        self._things = things
        self._target_class = target_class
        shape = shape_of(target_class)
        self._target_aspect = shape.radius_m * 2.0 / shape.height_m
        self._is_mistakable = not is_tag(target_class)
        """Nothing looks like a tag: eleven bits of its code check the others."""
        self._tags = TagReader(config, self._focal_px, caster, rng)
        self._caster = caster
        self._spread = (np.arange(RAYS) + 0.5) / RAYS

    def move_target(self, target: PlacedObject) -> None:
        self._things = (target, *self._things[1:])

    def _boxes(self, stamp_s: float, history: PoseHistory) -> tuple[RawDetection, ...]:
        config = self._config
        x, y, yaw = history.at(stamp_s)
        c, s = math.cos(yaw), math.sin(yaw)
        x, y = x + c * config.x_m - s * config.y_m, y + s * config.x_m + c * config.y_m
        yaw += config.yaw_rad + self.mount_error_rad
        yaw += float(self._rng.standard_normal()) * SHAKE_RAD * config.noise_scale
        boxes: list[RawDetection] = []
        for thing in self._things:
            if thing.is_tag:
                tag = self._tags.read(thing, Pose2D(x, y, yaw))
                boxes += [tag] if tag is not None else []
                continue
            sight = self._look(thing, x, y, yaw)
            if sight is not None:
                box = self._detect(thing, sight)
                if box is not None:
                    boxes.append(box)
        if self._rng.random() < config.false_rate and self._is_mistakable:
            boxes.append(self._invent())
        return tuple(boxes)

    def _look(self, thing: PlacedObject, x: float, y: float, yaw: float) -> _Sight | None:
        """Where a thing is in the picture, unless it is outside, too far off or hidden."""
        config, shape = self._config, thing.shape
        dx, dy = thing.x_m - x, thing.y_m - y
        range_m = math.hypot(dx, dy)
        if range_m > config.max_range_m or range_m <= shape.radius_m:
            return None
        bearing = math.remainder(math.atan2(dy, dx) - yaw, 2.0 * math.pi)
        half = math.asin(shape.radius_m / range_m)
        limit = self._half_fov_rad
        left, right = min(bearing + half, limit), max(bearing - half, -limit)
        depth_m = range_m * math.cos(bearing)
        if left <= right or depth_m <= shape.radius_m:
            return None
        angles = bearing - half + 2.0 * half * self._spread
        directions = angles + yaw
        # The nearest point of a cylinder along each ray is no nearer than this.
        front_m = range_m - shape.radius_m - _HIT_TOLERANCE_M
        origin_x, origin_y = np.full(RAYS, x), np.full(RAYS, y)
        free = self._caster.cast(origin_x, origin_y, np.cos(directions), np.sin(directions)) >= front_m
        seen = angles[free & (angles <= limit) & (angles >= -limit)]
        if len(seen) == 0:
            return None
        # A hidden edge is where the last free ray's cell ends; a free one is the thing's own.
        cell = half / RAYS
        left = min(left, float(seen[-1]) + cell)
        right = max(right, float(seen[0]) - cell)
        scale = self._focal_px / depth_m
        top = 0.5 * config.height_px - scale * (shape.height_m - config.z_m)
        bottom = 0.5 * config.height_px + scale * config.z_m
        share = (min(bottom, config.height_px) - max(top, 0.0)) / (bottom - top)
        visible = len(seen) / RAYS
        if min(visible, share) < MIN_VISIBLE:
            return None
        return _Sight(
            left=self._column(left), top=top, right=self._column(right), bottom=bottom,
            visible=visible * share, range_m=range_m,
        )  # fmt: skip

    def _column(self, angle_rad: float) -> float:
        angle_rad = max(-_MAX_ANGLE_RAD, min(_MAX_ANGLE_RAD, angle_rad))
        return 0.5 * self._config.width_px - self._focal_px * math.tan(angle_rad)

    def _detect(self, thing: PlacedObject, sight: _Sight) -> RawDetection | None:
        """What the detector makes of a thing it could find. Of a cut-off one it makes less often something."""
        config, rng = self._config, self._rng
        found, label, stretch, doubt = (float(v) for v in rng.random(4))
        *edge_noise, score_noise = (float(v) for v in rng.standard_normal(5))
        if found >= (1.0 - config.miss_probability) * sight.visible:
            return None
        sigma_px = config.box_jitter * config.noise_scale * (sight.bottom - sight.top)
        left, right = sight.left + sigma_px * edge_noise[0], sight.right + sigma_px * edge_noise[1]
        top, bottom = sight.top + sigma_px * edge_noise[2], sight.bottom + sigma_px * edge_noise[3]
        name = thing.class_name
        score = SCORE_NEAR - SCORE_LOSS_PER_M * max(sight.range_m - 0.5, 0.0) + SCORE_SIGMA * score_noise
        score *= math.sqrt(sight.visible)
        if name != self._target_class and label < MISLABEL_PROBABILITY and self._is_mistakable:
            name = self._target_class
            grow = 0.5 * (MISLABEL_STRETCH - 1.0) * stretch * (right - left)
            left, right = left - grow, right + grow
            score = SCORE_DOUBTFUL[0] + (SCORE_DOUBTFUL[1] - SCORE_DOUBTFUL[0]) * doubt
        return self._box(name, score, left, top, right, bottom)

    def _invent(self) -> RawDetection:
        """A box with nothing behind it, wholly in the picture."""
        config, rng = self._config, self._rng
        height = min(float(rng.uniform(*FALSE_HEIGHT_PX)), float(config.height_px))
        aspect = self._target_aspect * math.exp(FALSE_ASPECT_SIGMA * float(rng.standard_normal()))
        width = min(height * aspect, float(config.width_px))
        u = float(rng.uniform(0.5 * width, config.width_px - 0.5 * width))
        v = float(rng.uniform(0.5 * height, config.height_px - 0.5 * height))
        return RawDetection(self._target_class, float(rng.uniform(*SCORE_DOUBTFUL)), u, v, width, height)

    def _box(
        self, name: str, score: float, left: float, top: float, right: float, bottom: float
    ) -> RawDetection | None:
        """Cut off at the picture's borders; None if next to nothing is left."""
        left, right = max(left, 0.0), min(right, float(self._config.width_px))
        top, bottom = max(top, 0.0), min(bottom, float(self._config.height_px))
        if right - left < MIN_BOX_PX or bottom - top < MIN_BOX_PX:
            return None
        return RawDetection(
            class_name=name,
            score=max(0.05, min(0.99, score)),
            u_px=0.5 * (left + right),
            v_px=0.5 * (top + bottom),
            width_px=right - left,
            height_px=bottom - top,
        )
