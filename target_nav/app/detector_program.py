"""Which program looks at the pictures: the C++ detector with its network, or the Python one that needs neither.

A file beside the model, `<model>.sha256` as `sha256sum` writes it, is held against the model before it is used: a
flipped bit in a weight leaves a network that runs and sees nothing.
"""

from __future__ import annotations

import hashlib
import os
import shutil
import sys
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from target_nav.config import Config
from target_nav.errors import ConfigError

ROOT = Path(__file__).resolve().parents[2]
"""The checkout; installed, the folder that holds `target_nav`."""

PROGRAM = "app_yolo_cam"
BUILD = Path("drpai/build") / PROGRAM
MODELS = {"cpu": Path("deploy/model/bowling_pin.onnx"), "drpai": Path("deploy/model/bowling_pin_drpai")}
MODEL_CLASS = "bowling_pin"


@dataclass(frozen=True)
class DetectorCommand:
    """`argv` to start; `description` for the log. `network` tells the C++ program from the Python one."""

    argv: tuple[str, ...]
    description: str
    network: bool


def detector_command(
    config: Config, source: str, options: Sequence[str], class_name: str = MODEL_CLASS, root: Path = ROOT
) -> DetectorCommand:
    """How to start a detector of `class_name` on `source` (sim, a camera, a video, a folder of images).

    The network finds `MODEL_CLASS` and nothing else; for any other target a mission names it is the Python detector,
    which chooses by the name. For the network's own class `detector.program` decides.
    `options` are those of a Python process: its configuration and prefix. `auto` falls back to the Python detector when
    the program is not built or its model is not there, and the description says so.

    Raises:
        ConfigError: `network` was asked for and cannot be had, or the model is not what its check sum says.
    """
    kind = config.detector.program
    if class_name != MODEL_CLASS:
        return _python(source, options, f"the Python detector, for {class_name}")
    if kind == "red_stripes":
        return _python(source, options, "the red-stripe detector (detector.program)")
    program, model = find_program(root), find_model(config, root)
    missing = _missing(config, program, model)
    if missing and kind == "network":
        raise ConfigError(f"detector.program is 'network', but {missing}")
    if program is None or model is None or missing:
        return _python(source, options, f"the red-stripe detector: {missing}")
    check_sum(model)
    return DetectorCommand(
        _network_argv(config, source, program, model), f"{program.name} with {model.name}", network=True
    )


def find_program(root: Path = ROOT) -> Path | None:
    """The C++ detector: built in this checkout, or installed on the PATH."""
    built = root / BUILD
    if os.access(built, os.X_OK):
        return built
    installed = shutil.which(PROGRAM)
    return Path(installed) if installed else None


def find_model(config: Config, root: Path = ROOT) -> Path | None:
    """The network of `detector.model`, or the one that comes with the project, if it is there."""
    named = config.detector.model
    path = Path(named).expanduser() if named else root / MODELS[config.detector.backend]
    return path if path.exists() else None


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


def _missing(config: Config, program: Path | None, model: Path | None) -> str:
    if program is None:
        return f"{PROGRAM} is not built: install OpenCV's headers (apt install libopencv-dev), then drpai/build.sh"
    if model is None:
        named = config.detector.model or str(MODELS[config.detector.backend])
        return f"the model {named} is not there (detector.model)"
    return ""


def _network_argv(config: Config, source: str, program: Path, model: Path) -> tuple[str, ...]:
    camera = config.camera
    return (
        str(program),
        "--prefix", config.ipc.prefix,
        "--source", source,
        "--model", str(model),
        "--backend", config.detector.backend,
        "--class", MODEL_CLASS,
        "--width", str(camera.width_px),
        "--height", str(camera.height_px),
        "--rate", f"{camera.rate_hz:g}",
        "--score", f"{config.detector.propose_score:g}",
    )  # fmt: skip


def _python(source: str, options: Sequence[str], description: str) -> DetectorCommand:
    argv = (sys.executable, "-m", "target_nav.app.detector_node", "--source", source, *options)
    return DetectorCommand(argv, description, network=False)
