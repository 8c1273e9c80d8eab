"""Process `gui`: the operator's GTK3 panel. No ROS; runs on the distribution's Python (`gui_launch`, `gui_boot`)."""

from __future__ import annotations

import argparse
import logging
import os
import sys
import time
from pathlib import Path

from target_nav.app.process import report_ready, run_process
from target_nav.app.settings import add_config_arguments, base_config_from, config_from, settings_file_from
from target_nav.errors import DeviceError

log = logging.getLogger(__name__)

PLACES_VARIABLE = "TARGET_NAV_PANEL_PLACES"
"""A file: on SIGUSR1 the panel writes there where each of its keys is on the screen. For tests."""


def main() -> None:
    parser = argparse.ArgumentParser(prog="gui", description="The operator's panel.")
    parser.add_argument(
        "--windowed", action="store_true", help="a window of 800x480 instead of the whole screen"
    )
    add_config_arguments(parser)
    arguments = parser.parse_args()
    sys.exit(run_process("gui", lambda: _run(arguments)))


def _run(arguments: argparse.Namespace) -> int:
    base, config = base_config_from(arguments), config_from(arguments)
    settings_file = settings_file_from(arguments)
    # GTK is slow to import: everything that can be wrong with the options has been told by now
    try:
        from target_nav.gui.panels.application import Application
        from target_nav.gui.settings import Settings
    except (ImportError, ValueError) as error:
        raise DeviceError(f"GTK 3 cannot be used: {error}; install what docs/panel.md names") from error
    from target_nav.gui.gtk import Gtk

    if not Gtk.init_check(None)[0]:
        shown = os.environ.get("DISPLAY") or os.environ.get("WAYLAND_DISPLAY") or "not set"
        raise DeviceError(f"there is no display (DISPLAY {shown}); start the panel in the screen's session")
    places = os.environ.get(PLACES_VARIABLE)
    settings = Settings(config, settings_file, base)
    application = Application(
        config.ipc.prefix, settings, not arguments.windowed, _first_frame, Path(places) if places else None
    )
    return application.run()


def _first_frame() -> None:
    log.info("first frame %.2f s after the process began", time.time() - _began_s())
    report_ready()


def _began_s() -> float:
    """When this process began, as wall time: from the kernel's tables, so that imports count."""
    ticks = int(Path("/proc/self/stat").read_text().rsplit(")", 1)[1].split()[19])
    uptime_s = float(Path("/proc/uptime").read_text().split()[0])
    return time.time() - uptime_s + ticks / os.sysconf("SC_CLK_TCK")
