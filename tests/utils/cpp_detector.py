"""The C++ detector for tests: the program, its tests' helpers, and the kilobyte of a network they run it with."""

from __future__ import annotations

import shutil
import subprocess
from functools import lru_cache
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
DRPAI = ROOT / "drpai"
RED_SQUARE = DRPAI / "tests" / "data" / "red_square.onnx"
MISSING = 3
"""What drpai/build.sh exits with where OpenCV's headers, CMake or a compiler are not."""


@lru_cache(maxsize=1)
def _build() -> tuple[int, str]:
    done = subprocess.run([DRPAI / "build.sh"], capture_output=True, text=True, check=False)
    return done.returncode, done.stdout + done.stderr


def program() -> Path:
    """`app_yolo_cam`, built if need be. Skips the test where it cannot be built; fails it where it does not compile."""
    code, text = _build()
    if code == MISSING:
        pytest.skip(f"the C++ detector cannot be built here: {text.strip()}")
    assert code == 0, text
    return DRPAI / "build" / "app_yolo_cam"


@lru_cache(maxsize=1)
def _stress() -> tuple[int, str]:
    out = DRPAI / "build" / "channel_stress"
    flags = subprocess.run(
        ["pkg-config", "--cflags", "opencv4"], capture_output=True, text=True, check=False
    ).stdout.split()
    sources = [
        "tests/channel_stress.cpp",
        *(f"src/ipc/{n}.cpp" for n in ("channel_writer", "mapped_channel", "slots")),
    ]
    command = [
        "c++",
        "-std=c++17",
        "-O2",
        "-Isrc",
        "-Igenerated",
        *flags,
        *sources,
        "-lopencv_core",
        "-o",
        str(out),
    ]
    done = subprocess.run(command, cwd=DRPAI, capture_output=True, text=True, check=False)
    return done.returncode, done.stderr


def channel_stress() -> Path:
    """The program that writes a channel flat out (drpai/tests/channel_stress.cpp)."""
    program()
    if shutil.which("pkg-config") is None:
        pytest.skip("pkg-config is not installed")
    code, text = _stress()
    assert code == 0, text
    return DRPAI / "build" / "channel_stress"
