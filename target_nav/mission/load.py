"""From a file to a tree that can be ticked."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path

from py_trees.behaviour import Behaviour

from target_nav.errors import MissionError
from target_nav.mission.build import build
from target_nav.mission.check import analyse
from target_nav.mission.registry import NodeRegistry, default_registry


@dataclass(frozen=True)
class LoadedMission:
    """A mission ready to be ticked. `files` are all that it was read from, `path` first."""

    root: Behaviour
    path: Path
    main_tree: str
    files: tuple[Path, ...]


def load_mission(
    path: str | Path,
    registry: NodeRegistry | None = None,
    provided_keys: Iterable[str] = (),
    main_tree: str | None = None,
) -> LoadedMission:
    """Loads a mission file with what it includes.

    Args:
        path: the file
        registry: the words it may use; the built-ins and the leaves of `behaviours` when None
        provided_keys: blackboard entries (`/goal`) that something outside the mission writes, beside those of
            `target_nav.state.keys`
        main_tree: the tree to load, instead of the one that the file names

    Raises:
        MissionError: it has errors; one line for each. Nothing has been built then.
    """
    registry = registry if registry is not None else default_registry()
    analysis = analyse(Path(path), registry, provided_keys, main_tree)
    if analysis.errors:
        raise MissionError("\n".join(map(str, analysis.errors)))
    assert analysis.root is not None, "a mission without errors has a main tree"
    assert analysis.library.main_tree is not None
    return LoadedMission(
        root=build(analysis.root, registry.enums),
        path=analysis.library.files[0].path,
        main_tree=analysis.library.main_tree,
        files=tuple(file.path for file in analysis.library.files),
    )
