"""The C++ detector, built where OpenCV's headers are: those take root, so without them the Python detector is used."""

from __future__ import annotations

import os
import subprocess
from pathlib import Path

from environment.steps import ROOT, SetupError, clean_environ

SCRIPT = ROOT / "drpai" / "build.sh"
PROGRAM = ROOT / "drpai" / "build" / "app_yolo_cam"
MISSING = 3


def provide(venv: Path) -> None:
    """Build it, or find that it is newer than its sources."""
    before = PROGRAM.stat().st_mtime if PROGRAM.exists() else None
    env = clean_environ()
    # CMake and ninja of the environment, where the system has none.
    env["PATH"] = f"{env.get('PATH', os.defpath)}{os.pathsep}{venv / 'bin'}"
    done = subprocess.run([SCRIPT], capture_output=True, text=True, env=env, check=False)
    if done.returncode == 0:
        if PROGRAM.stat().st_mtime != before:
            print("[setup] the C++ detector: built", flush=True)
    elif done.returncode == MISSING:
        print(
            f"[setup] the C++ detector: left out, the Python one is used: {done.stderr.strip()}", flush=True
        )
    else:
        raise SetupError(f"The C++ detector does not build.\n{(done.stdout + done.stderr)[-3000:]}")
