"""Where the project's data files are, in a checkout and when installed."""

from __future__ import annotations

import sys
from importlib.resources import files
from pathlib import Path

from target_nav.errors import DeviceError

REFERENCE_MISSION = "bowling_pin"
SUFFIXES = (".xml", ".yaml", ".yml")
MODEL_FILE = "bowling_pin.onnx"


def mission_path(name_or_path: str) -> Path:
    """A mission file by path, or by name out of `trees/` (XML before YAML). That it exists, the loader checks."""
    path = Path(name_or_path)
    if path.suffix or path.exists():
        return path
    folder = Path(str(files("trees")))
    named = [folder / f"{name_or_path}{suffix}" for suffix in SUFFIXES]
    return next((each for each in named if each.is_file()), named[0])


def model_path() -> Path:
    """The pin model: in the checkout, or where setup.py's data files go.

    Raises:
        DeviceError: it is in neither.
    """
    places = (
        Path(__file__).resolve().parents[2] / "deploy" / "model" / MODEL_FILE,
        Path(sys.prefix) / "share" / "target_nav" / "deploy" / "model" / MODEL_FILE,
    )
    for place in places:
        if place.is_file():
            return place
    raise DeviceError(
        f"no {MODEL_FILE} in {' or '.join(str(p.parent) for p in places)}; is the checkout whole?"
    )
