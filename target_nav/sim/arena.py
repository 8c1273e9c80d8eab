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
from target_nav.sim.generator import GeneratedName, generate_arena

__all__ = [
    "ARENA_FOLDER",
    "ARRIVED",
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
DEFAULT_CONFIG = Config()


def load_arena(path_or_name: str | Path, config: Config = DEFAULT_CONFIG) -> Arena:
    """The arena of a file, of a name from `list_arenas`, or `generated_<seed>_<number>`, which is made anew.

    A file's `profile` is applied to `config`.

    Raises:
        ConfigError: one line `file:line: error: what, value, limit, what to do` for each thing that is wrong.
    """
    generated = GeneratedName.parse(str(path_or_name))
    if generated is not None and not Path(path_or_name).exists():
        return generate_arena(generated, config)
    return read_arena(arena_path(path_or_name), config, known=tuple(list_arenas()))


def arena_path(path_or_name: str | Path) -> Path:
    """A bare name is an arena that comes with the package, unless there is a file of just that name."""
    path = Path(path_or_name)
    bundled = ARENA_FOLDER / f"{path_or_name}.yaml"
    is_name = path.name == str(path_or_name) and not path.is_file()
    return bundled if is_name and bundled.is_file() else path


def list_arenas() -> list[str]:
    """Names of the arenas that come with the package."""
    return sorted(path.stem for path in ARENA_FOLDER.glob("*.yaml"))
