"""How the panel's process is started from this project's environment: on which Python, with which command, or why not.

ros2 run target_nav gui [--windowed]
"""

from __future__ import annotations

import os
import subprocess
import sys
from collections.abc import Mapping, Sequence
from pathlib import Path

from target_nav.app import gui_boot

PYTHON_VARIABLE = "TARGET_NAV_GUI_PYTHON"
PYTHON = "/usr/bin/python3"
PACKAGES = (
    "python3-gi", "python3-gi-cairo", "gir1.2-gtk-3.0", "python3-numpy", "python3-yaml", "fonts-dejavu-core",
    "adwaita-icon-theme",
)  # fmt: skip
"""Of Debian and Ubuntu; scripts/setup.sh installs them."""

DROPPED = ("LD_LIBRARY_PATH", "_ROS_WHEELS_BOOTSTRAP_COMPLETE")
"""Variables that the ROS wheels set (docs/environment.md)."""

_PROBE = (
    "import gi; gi.require_version('Gtk', '3.0'); gi.require_foreign('cairo'); import numpy, yaml; "
    "from gi.repository import Gtk"
)


def python_of(environment: Mapping[str, str] | None = None) -> str:
    """The Python that has GTK."""
    return (os.environ if environment is None else environment).get(PYTHON_VARIABLE) or PYTHON


def command(*options: str) -> tuple[str, ...]:
    """Without what the environment's own start-up leaves behind for its children: libraries of another Python."""
    dropped = (part for name in DROPPED for part in ("-u", name))
    return ("/usr/bin/env", *dropped, python_of(), "-I", gui_boot.__file__, *options)


def missing_packages() -> str:
    """What the panel's Python lacks, in words with what to do; empty when it has everything."""
    python = python_of()
    if not os.access(python, os.X_OK):
        return f"{python} is not there; {PYTHON_VARIABLE} may name another Python with GTK 3"
    clean = {name: value for name, value in os.environ.items() if name not in DROPPED}
    probe = subprocess.run(
        [python, "-I", "-c", _PROBE], env=clean, capture_output=True, text=True, check=False
    )
    if probe.returncode == 0:
        return ""
    why = (probe.stderr.strip().splitlines() or ["?"])[-1]
    return f"{python} has no GTK 3 for the panel ({why}): sudo apt install {' '.join(PACKAGES)}"


def problem(environment: Mapping[str, str] | None = None) -> str:
    """Why there can be no panel here, empty when there can."""
    environment = os.environ if environment is None else environment
    if not (environment.get("DISPLAY") or environment.get("WAYLAND_DISPLAY")):
        return (
            "no panel: there is no display (DISPLAY is not set); `target-nav say go`, `say stop` and `target-nav web` "
            "do its work"
        )
    lacks = missing_packages()
    return f"no panel: {lacks}" if lacks else ""


def main(arguments: Sequence[str] | None = None) -> None:
    """Becomes the panel's process."""
    options = list(sys.argv[1:] if arguments is None else arguments)
    lacks = missing_packages()
    if lacks:
        print(lacks, file=sys.stderr)
        sys.exit(2)
    full = command(*without_ros(options))
    sys.stdout.flush()
    os.execv(full[0], full)


def without_ros(options: Sequence[str]) -> list[str]:
    """The options without `--ros-args ... [--]`, which `ros2 run` and launch add."""
    own: list[str] = []
    for_ros = False
    for option in options:
        if option == "--ros-args":
            for_ros = True
        elif for_ros and option == "--":
            for_ros = False
        elif not for_ros:
            own.append(option)
    return own


def options_of(prefix: str, config: Path | None, settings: Path | None) -> tuple[str, ...]:
    given = (("--prefix", prefix), ("--config", config), ("--settings", settings))
    return tuple(part for name, value in given if value is not None for part in (name, str(value)))
