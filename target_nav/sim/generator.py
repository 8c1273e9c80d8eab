"""Arenas by chance: a seed and a number give an arena of a kind and a level, always the same one.

Kinds and levels go round in turn, so that every campaign has as many of each. What cannot be solved by this robot's
own footprint (`sim.solvable`) is drawn again; nothing is made easier for the algorithms' sake. What the sensors get
wrong is drawn anew for each arena, within what was measured.
"""

from __future__ import annotations

import math
import re
from dataclasses import dataclass, replace

import numpy as np

from target_nav.config import Config
from target_nav.errors import ConfigError
from target_nav.sim.arena_checks import geometry_problems
from target_nav.sim.arena_types import ARRIVED, NOT_FOUND, Arena, Bounds
from target_nav.sim.draft import Draft
from target_nav.sim.generator_kinds import KINDS
from target_nav.state.types import Pose2D

LEVELS = (1, 2, 3, 4)
KIND_NAMES = tuple(KINDS)
TIME_LIMIT_S = 300.0
"""Longer than the reference mission's own limits (a turn, a spiral and the drive) come to."""

MAX_DRAWS = 500
_NAME = re.compile(r"^generated_(\d{1,18})_(\d{1,9})$")

ROOM_SIDE_M = {1: (3.5, 4.5), 2: (4.5, 5.5), 3: (5.0, 6.5), 4: (6.0, 8.0)}

# What is drawn for each arena, uniformly. Measured: docs/campaigns.md says where each is from.
BOX_JITTER = (0.02, 0.05)
MOUNT_ERROR_RAD = math.radians(0.8)
FOCAL_ERROR = 0.044
LIDAR_OFFSET_M = 0.005
FORWARD_SCALE_ERROR = 0.02


@dataclass(frozen=True)
class GeneratedName:
    """`generated_<seed>_<number>`: all that is needed to make the arena again."""

    seed: int
    number: int

    def __str__(self) -> str:
        return f"generated_{self.seed}_{self.number}"

    @classmethod
    def parse(cls, text: str) -> GeneratedName | None:
        match = _NAME.match(text)
        return cls(int(match[1]), int(match[2])) if match else None


def kind_and_level(number: int) -> tuple[str, int]:
    """Of the arena with that number: each kind once in twelve, each level once in forty-eight."""
    return KIND_NAMES[number % len(KINDS)], LEVELS[number // len(KINDS) % len(LEVELS)]


def generate_arena(name: GeneratedName, config: Config) -> Arena:
    """The arena of that seed and number: a function of these two, and of the body in `config`.

    Raises:
        ConfigError: no arena of that kind fits this body; it is too large for the rooms that are drawn.
    """
    rng = np.random.Generator(np.random.PCG64(np.random.SeedSequence([name.seed, name.number])))
    kind, level = kind_and_level(name.number)
    sensors = _draw_sensors(rng, config)
    for _ in range(MAX_DRAWS):
        arena = _draw(rng, name, kind, level, sensors)
        if arena is not None:
            return arena
    raise ConfigError(
        f"{name}: none of {MAX_DRAWS} drawn arenas of kind {kind!r}, level {level}, can be solved by a body of "
        f"{config.robot.front_m + config.robot.rear_m:g} by {2 * config.robot.half_width_m:g} m; the generator is "
        "for robots of up to about 0.4 m"
    )


def _draw(
    rng: np.random.Generator, name: GeneratedName, kind: str, level: int, config: Config
) -> Arena | None:
    """One attempt: None if it is not well-formed or cannot be solved."""
    half_x, half_y = (0.5 * _round(side) for side in rng.uniform(*ROOM_SIDE_M[level], 2))
    draft = Draft(rng, level, _round(half_x), _round(half_y))
    if not KINDS[kind](draft) or draft.robot is None:
        return None
    arena = Arena(
        name=str(name),
        bounds=Bounds(-draft.half_x_m, -draft.half_y_m, draft.half_x_m, draft.half_y_m),
        robot=Pose2D(*(_round(v) for v in (draft.robot.x_m, draft.robot.y_m, draft.robot.yaw_rad))),
        target=draft.target,
        obstacles=tuple(draft.obstacles),
        decoys=tuple(draft.decoys),
        config=config,
        time_limit_s=TIME_LIMIT_S,
        expect=ARRIVED if draft.target is not None else NOT_FOUND,
        kind=kind,
        level=level,
    )
    # scipy takes as long to import as a short run: only who generates arenas waits for it
    from target_nav.sim.solvable import Solver

    if any(geometry_problems(arena)) or not Solver(arena).is_solvable():
        return None
    return arena


def _draw_sensors(rng: np.random.Generator, config: Config) -> Config:
    """What is wrong with this robot's sensors today. What changes from reading to reading is the simulator's."""
    camera = replace(
        config.camera,
        box_jitter=_round(rng.uniform(*BOX_JITTER)),
        mount_error_rad=_round(MOUNT_ERROR_RAD),
        focal_error=_round(rng.uniform(-FOCAL_ERROR, FOCAL_ERROR)),
    )
    lidar = replace(config.lidar, range_offset_m=_round(rng.uniform(-LIDAR_OFFSET_M, LIDAR_OFFSET_M)))
    drive = replace(config.drive_sim, forward_scale_error=FORWARD_SCALE_ERROR)
    return replace(config, camera=camera, lidar=lidar, drive_sim=drive)


def _round(value: float) -> float:
    """To a tenth of a millimetre, so that a file says exactly what was drawn."""
    return round(float(value), 4)
