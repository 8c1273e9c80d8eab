"""Where the project's data files are, in a checkout and when installed."""

from __future__ import annotations

from importlib.resources import files
from pathlib import Path

REFERENCE_MISSION = "bowling_pin"
SUFFIXES = (".xml", ".yaml", ".yml")


def mission_path(name_or_path: str) -> Path:
    """A mission file by path, or by name out of `trees/` (XML before YAML). That it exists, the loader checks."""
    path = Path(name_or_path)
    if path.suffix or path.exists():
        return path
    folder = Path(str(files("trees")))
    named = [folder / f"{name_or_path}{suffix}" for suffix in SUFFIXES]
    return next((each for each in named if each.is_file()), named[0])
