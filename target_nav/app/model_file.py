"""The trained network's file: which one, where it is, and whether it is whole.

A file beside the model, `<model>.sha256` as `sha256sum` writes it, is held against the model before it is used: a
flipped bit in a weight leaves a network that runs and sees nothing.
"""

from __future__ import annotations

import hashlib
import sys
from pathlib import Path

from target_nav.config import Config
from target_nav.errors import ConfigError

ROOT = Path(__file__).resolve().parents[2]
"""The checkout; installed, the folder that holds `target_nav`."""

MODELS = {"cpu": Path("deploy/model/bowling_pin.onnx"), "drpai": Path("deploy/model/bowling_pin_drpai")}
"""By `detector.backend`: a file for OpenCV, a folder for the accelerator."""


def find_model(config: Config, backend: str = "", root: Path = ROOT) -> Path | None:
    """The network of `detector.model`, or the one that comes with the project, if it is there.

    `backend` when it is not that of the configuration: an accelerator's folder is nothing that OpenCV could read.
    """
    named, wanted = config.detector.model, backend or config.detector.backend
    if named and wanted == config.detector.backend:
        path = Path(named).expanduser()
        return path if path.exists() else None
    places = (root, Path(sys.prefix) / "share" / "target_nav")
    return next((place / MODELS[wanted] for place in places if (place / MODELS[wanted]).exists()), None)


def missing_model(config: Config) -> str:
    named = config.detector.model or str(MODELS[config.detector.backend])
    return f"the model {named} is not there (detector.model)"


def cpu_model(config: Config, root: Path = ROOT) -> Path:
    """The whole network for OpenCV's dnn.

    Raises:
        ConfigError: it is not there, or not what its check sum says.
    """
    model = find_model(config, "cpu", root)
    if model is None:
        raise ConfigError(missing_model(config))
    check_sum(model)
    return model


def check_sum(model: Path) -> None:
    """Raises ConfigError when the model has a check sum beside it that is not its own."""
    beside = model.with_name(model.name + ".sha256")
    if not (beside.is_file() and model.is_file()):
        return
    expected = beside.read_text(encoding="ascii", errors="replace").split()[:1]
    found = hashlib.sha256(model.read_bytes()).hexdigest()
    if expected != [found]:
        raise ConfigError(
            f"model {model} is corrupt: its SHA-256 is {found[:12]}..., {beside.name} says "
            f"{''.join(expected)[:12] or 'nothing'}...; fetch it again, or remove {beside.name} if it is your own"
        )
