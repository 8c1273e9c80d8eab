"""Which scenario files are meant: files themselves, folders of them, or missions with their scenarios beside them."""

from __future__ import annotations

import re
from collections.abc import Iterable
from importlib.resources import files
from pathlib import Path

from target_nav.errors import MissionError

FOLDER = "scenarios"
SUFFIXES = (".yaml", ".yml")

_MISSION = re.compile(rb"^mission *:", re.MULTILINE)
_SCENARIOS = re.compile(rb"^scenarios *:", re.MULTILINE)


def shipped() -> Path:
    """The folder of the scenarios that come along."""
    return Path(str(files("trees"))) / FOLDER


def is_scenario_file(path: Path) -> bool:
    """Whether a YAML file looks like scenarios: other projects have folders of that name too."""
    if path.suffix not in SUFFIXES:
        return False
    try:
        data = path.read_bytes()[:100_000]
    except OSError:
        return False
    return bool(_MISSION.search(data) and _SCENARIOS.search(data))


def find_scenario_files(given: Iterable[str | Path]) -> list[Path]:
    """Nothing given means those that come along. A mission's scenarios are all files in `scenarios/` beside it that
    name it.

    Raises:
        MissionError: something given is not there, or has no scenarios.
    """
    found: dict[Path, None] = {}
    for item in [Path(each) for each in given] or [shipped()]:
        if item.is_dir():
            here = sorted(path for path in item.rglob("*") if is_scenario_file(path))
        elif not item.is_file():
            raise MissionError(f"{item}: there is no such file or folder")
        elif item.suffix in SUFFIXES and not _is_mission_with_scenarios(item):
            # also one that does not look like scenarios: what is wrong with it is for the reader to say
            here = [item]
        else:
            here = _of_mission(item)
        if not here:
            raise MissionError(f"{item}: no scenarios for it; they are *.yaml files in a folder {FOLDER!r}")
        found.update(dict.fromkeys(here))
    return list(found)


def _is_mission_with_scenarios(path: Path) -> bool:
    return not is_scenario_file(path) and bool(_of_mission(path))


def _of_mission(mission: Path) -> list[Path]:
    folder = mission.parent / FOLDER
    if not folder.is_dir():
        return []
    candidates = sorted(path for path in folder.rglob("*") if is_scenario_file(path))
    return [path for path in candidates if _mission_of(path) == mission.resolve()]


def _mission_of(path: Path) -> Path | None:
    match = re.search(
        r"""^mission *: *["']?([^"'#\r\n]+)""", path.read_text(encoding="utf-8", errors="replace"), re.M
    )
    return (path.parent / match[1].strip()).resolve() if match else None
