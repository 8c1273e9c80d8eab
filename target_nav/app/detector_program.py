"""Which program looks at the pictures: the C++ detector, which has the network only, or the Python one with all."""

from __future__ import annotations

import os
import shutil
import sys
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from target_nav.app.model_file import ROOT, check_sum, find_model, missing_model
from target_nav.config import Config
from target_nav.errors import ConfigError

PROGRAM = "app_yolo_cam"
BUILD = Path("drpai/build") / PROGRAM
MODEL_CLASS = "bowling_pin"


@dataclass(frozen=True)
class DetectorCommand:
    """`argv` to start; `description` for the log. `cpp` tells the C++ program from the Python one."""

    argv: tuple[str, ...]
    description: str
    cpp: bool


def detector_command(
    config: Config, source: str, options: Sequence[str], class_name: str = MODEL_CLASS, root: Path = ROOT
) -> DetectorCommand:
    """How to start a detector of `class_name` on `source` (sim, a camera, a video, a folder of images).

    The C++ program has the network, which finds `MODEL_CLASS` and nothing else; any other target that a mission names
    is for the Python program, which chooses by the name. For the network's own class `detector.program` decides.
    `options` are those of a Python process: its configuration and prefix. `auto` falls back to the Python program when
    the other is not built or its model is not there, and the description says so.

    Raises:
        ConfigError: `cpp` was asked for and cannot be had, or the model is not what its check sum says.
    """
    kind = config.detector.program
    if class_name != MODEL_CLASS:
        return _python(source, options, f"the Python detector, for {class_name}")
    if kind == "python":
        return _python(source, options, "the Python detector (detector.program)")
    program, model = find_program(root), find_model(config, root=root)
    missing = _missing(config, program, model)
    if missing and kind == "cpp":
        raise ConfigError(f"detector.program is 'cpp', but {missing}")
    if program is None or model is None or missing:
        return _python(source, options, f"the Python detector: {missing}")
    check_sum(model)
    return DetectorCommand(
        _network_argv(config, source, program, model), f"{program.name} with {model.name}", cpp=True
    )


def find_program(root: Path = ROOT) -> Path | None:
    """The C++ detector: built in this checkout, or installed on the PATH."""
    built = root / BUILD
    if os.access(built, os.X_OK):
        return built
    installed = shutil.which(PROGRAM)
    return Path(installed) if installed else None


def _missing(config: Config, program: Path | None, model: Path | None) -> str:
    if program is None:
        return f"{PROGRAM} is not built: install OpenCV's headers (apt install libopencv-dev), then drpai/build.sh"
    if model is None:
        return missing_model(config)
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
    return DetectorCommand(argv, description, cpp=False)
