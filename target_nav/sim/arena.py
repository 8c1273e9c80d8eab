"""Arenas by file or by name. The format is in `docs/simulator.md`; everything wrong with a file is told at once."""

from __future__ import annotations

from pathlib import Path

from target_nav.config import Config
from target_nav.sim.arena_file import read_arena
from target_nav.sim.arena_types import (
    ARRIVED,
    NOT_FOUND,
    Arena,
    Bounds,
    BoxObstacle,
    CircleObstacle,
    Goal,
    Obstacle,
    PlacedObject,
    WallObstacle,
)
from target_nav.sim.barn import BarnName, named_barn_arena
from target_nav.sim.generator import GeneratedName, generate_arena

__all__ = [
    "ARENA_FOLDER",
    "ARRIVED",
    "GROUPS",
    "NOT_FOUND",
    "Arena",
    "Bounds",
    "BoxObstacle",
    "CircleObstacle",
    "Goal",
    "Obstacle",
    "PlacedObject",
    "WallObstacle",
    "arena_path",
    "list_arenas",
    "load_arena",
]

ARENA_FOLDER = Path(__file__).with_name("arenas")
GROUPS = ("complaints", "goals", "tags")
"""Arenas that are known by name too: one for each complaint of users, those with a goal instead of a target, and those
with an AprilTag."""

DEFAULT_CONFIG = Config()


def load_arena(path_or_name: str | Path, config: Config = DEFAULT_CONFIG) -> Arena:
    """The arena of a file, or of a name from `list_arenas`. A file's `profile` is applied to `config`.

    `generated_<seed>_<number>` is made anew. `barn:<robot>:<index>:<folder>` is a world of the BARN set, with that
    robot's own configuration.

    Raises:
        ConfigError: one line `file:line: error: what, value, limit, what to do` for each thing that is wrong.
    """
    barn = BarnName.parse(str(path_or_name))
    if barn is not None:
        return named_barn_arena(barn)
    generated = GeneratedName.parse(str(path_or_name))
    if generated is not None and not Path(path_or_name).exists():
        return generate_arena(generated, config)
    return read_arena(arena_path(path_or_name), config, known=tuple(list_arenas()))


def arena_path(path_or_name: str | Path) -> Path:
    """A bare name is an arena that comes with the package, unless there is a file of just that name."""
    path = Path(path_or_name)
    if path.name != str(path_or_name) or path.is_file():
        return path
    places = (ARENA_FOLDER, *(ARENA_FOLDER / group for group in GROUPS))
    found = (folder / f"{path_or_name}.yaml" for folder in places)
    return next((file for file in found if file.is_file()), path)


def list_arenas(group: str = "") -> list[str]:
    """Names of the arenas that come with the package, each with a target or with nothing to be found.

    `group` is one of `GROUPS` for those instead.
    """
    return sorted(path.stem for path in (ARENA_FOLDER / group).glob("*.yaml"))
