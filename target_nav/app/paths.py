"""Where the project's data files are, in a checkout and when installed."""

from __future__ import annotations

from importlib.resources import files
from pathlib import Path

REFERENCE_MISSION = "bowling_pin"


def mission_path(name_or_path: str) -> Path:
    """A mission file by path, or by name out of `trees/`. Whether it exists is the loader's question."""
    path = Path(name_or_path)
    if path.suffix or path.exists():
        return path
    return Path(str(files("trees"))) / f"{name_or_path}.xml"
