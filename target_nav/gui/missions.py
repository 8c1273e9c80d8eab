"""The missions and targets an operator can choose from: the files of a folder, and the targets that they name."""

from __future__ import annotations

import contextlib
from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path
from xml.etree import ElementTree

import target_nav
from target_nav.state.types import TargetSpec


@dataclass(frozen=True)
class MissionChoice:
    """`name` for people, `path` for the LOAD command, and the first comment of the file as help."""

    name: str
    path: str


def mission_folder() -> Path:
    """`trees/` beside the package, in a checkout and when installed."""
    return Path(target_nav.__file__).resolve().parent.parent / "trees"


def missions(folder: Path | None = None) -> tuple[MissionChoice, ...]:
    """Mission files of a folder, by name; nothing where there is no such folder."""
    folder = folder or mission_folder()
    if not folder.is_dir():
        return ()
    files = sorted((*folder.glob("*.xml"), *folder.glob("*.yaml")))
    return tuple(MissionChoice(file.stem, str(file)) for file in files)


def targets(choices: Iterable[MissionChoice]) -> tuple[TargetSpec, ...]:
    """Every target that some mission names with fixed values, each once. A file that is no XML names none."""
    found: dict[TargetSpec, None] = {}
    for choice in choices:
        with contextlib.suppress(ElementTree.ParseError, OSError):
            for element in ElementTree.parse(choice.path).iter():
                if element.tag == "SetTarget" or element.get("ID") == "SetTarget":
                    with contextlib.suppress(KeyError, ValueError):
                        at = element.attrib
                        sizes_m = (at["height_m"], at["width_m"], at.get("lidar_width_m", "0"))
                        spec = TargetSpec(at["class"], *map(float, sizes_m))
                        if "{" not in spec.class_name:
                            found[spec] = None
    return tuple(found)
