"""A screen without a screen: Xvfb with a window manager, and a hand that presses keys and the mouse through xdotool."""

from __future__ import annotations

import contextlib
import json
import os
import shutil
import signal
import subprocess
import time
from collections.abc import Iterator
from pathlib import Path

import pytest

from target_nav.app import gui_launch
from tests.utils.processes import wait_until

WIDTH, HEIGHT = 800, 480
TOOLS = ("Xvfb", "openbox", "xdotool", "xprop")
ARTEFACTS = Path(__file__).resolve().parents[2] / "runs" / "panel"
"""Screenshots of the run stay here."""

_SHOOT = """
import sys, gi
gi.require_version("Gdk", "3.0")
from gi.repository import Gdk
root = Gdk.get_default_root_window()
Gdk.pixbuf_get_from_window(root, 0, 0, root.get_width(), root.get_height()).savev(sys.argv[1], "png", [], [])
"""


def require_screen() -> None:
    """Skips where the panel or a screen for it cannot be had."""
    absent = [tool for tool in TOOLS if shutil.which(tool) is None]
    if absent:
        pytest.skip(f"{', '.join(absent)} not installed: scripts/install-panel.sh --test")
    lacks = gui_launch.missing_packages()
    if lacks:
        pytest.skip(f"{lacks} (scripts/install-panel.sh --test)")


class Screen:
    """One X display with openbox. `environment` is for processes that shall appear on it."""

    def __init__(self, folder: Path) -> None:
        read, write = os.pipe()
        log = (folder / "xvfb.log").open("wb")
        self._server = subprocess.Popen(
            ["Xvfb", "-displayfd", str(write), "-screen", "0", f"{WIDTH}x{HEIGHT}x24", "-nolisten", "tcp"],
            pass_fds=(write,),
            stdout=log,
            stderr=log,
        )
        os.close(write)
        with os.fdopen(read) as told:
            number = told.readline().strip()
        assert number, (folder / "xvfb.log").read_text(encoding="utf-8", errors="replace")
        self.display = f":{number}"
        self.environment = {**os.environ, "DISPLAY": self.display, "NO_AT_BRIDGE": "1"}
        self._log = log
        self._manager = self._manage()
        wait_until(self._managed, "a window manager on the screen")

    def close(self) -> None:
        for process in (self._manager, self._server):
            process.terminate()
            process.wait(10.0)
        self._log.close()

    def xdotool(self, *words: str) -> str:
        done = subprocess.run(
            ["xdotool", *words],
            env=self.environment,
            capture_output=True,
            text=True,
            check=True,
            timeout=20.0,
        )
        return done.stdout.strip()

    def key(self, name: str) -> None:
        self.xdotool("key", name)

    @contextlib.contextmanager
    def held_key(self, name: str) -> Iterator[None]:
        self.xdotool("keydown", name)
        try:
            yield
        finally:
            self.xdotool("keyup", name)

    @contextlib.contextmanager
    def held_mouse(self, x: int, y: int) -> Iterator[None]:
        self.xdotool("mousemove", str(x), str(y), "mousedown", "1")
        try:
            yield
        finally:
            self.xdotool("mouseup", "1")

    def click(self, x: int, y: int) -> None:
        self.xdotool("mousemove", str(x), str(y), "click", "1")

    def shoot(self, name: str) -> Path:
        """A picture of the whole screen, kept as an artefact of the run."""
        ARTEFACTS.mkdir(parents=True, exist_ok=True)
        path = ARTEFACTS / f"{name}.png"
        subprocess.run(
            [gui_launch.python_of(), "-I", "-c", _SHOOT, str(path)],
            env=self.environment,
            check=True,
            timeout=30.0,
        )
        return path

    def _manage(self) -> subprocess.Popen[bytes]:
        return subprocess.Popen(["openbox"], env=self.environment, stdout=self._log, stderr=self._log)

    def _managed(self) -> bool:
        if self._manager.poll() is not None:
            # on a busy machine the screen may not answer at once, and openbox does not wait
            time.sleep(0.2)
            self._manager = self._manage()
        told = subprocess.run(
            ["xprop", "-root", "_NET_SUPPORTING_WM_CHECK"], env=self.environment, capture_output=True, text=True,
            check=False,
        )  # fmt: skip
        return "window id" in told.stdout


class PanelHand:
    """Presses what the panel shows, by its label. The panel tells where it is."""

    def __init__(self, screen: Screen, places: Path) -> None:
        self.screen, self._places = screen, places
        self.pid = 0

    def boxes(self) -> dict[str, tuple[int, int, int, int]]:
        """Label to x, y, width and height of everything that can be pressed now, what is scrolled away included."""
        self._places.unlink(missing_ok=True)
        os.kill(self.pid, signal.SIGUSR1)
        wait_until(self._places.exists, "the panel tells where its keys are")
        places = json.loads(self._places.read_text(encoding="utf-8"))
        return {words: (box[0], box[1], box[2], box[3]) for words, box in places.items()}

    def place(self, label: str) -> tuple[int, int]:
        """The middle of a key or field."""
        boxes = self.boxes()
        assert label in boxes, f"no key {label!r} on the screen; there are {sorted(boxes)}"
        x, y, width, height = found = boxes[label]
        cut_off = min(x, y) < 0 or x + width > WIDTH or y + height > HEIGHT
        assert not cut_off, f"{label} at {found} is cut off"
        return x + width // 2, y + height // 2

    def reveal(self, label: str, page_from_px: int = 80, page_to_px: int = 424) -> None:
        """Turn the mouse's wheel over a list until a key of it is seen whole."""
        for _ in range(40):
            x, y, width, height = self.boxes()[label]
            if y >= page_from_px and y + height <= page_to_px:
                return
            button = "5" if y > page_from_px else "4"
            middle = (page_from_px + page_to_px) // 2
            self.screen.xdotool("mousemove", str(x + width // 2), str(middle), "click", button)
            time.sleep(0.05)
        raise AssertionError(f"{label} cannot be scrolled into sight")

    def press(self, label: str) -> None:
        self.screen.click(*self.place(label))
        time.sleep(0.15)

    def page(self, number: int) -> None:
        self.screen.key(f"alt+{number}")
        time.sleep(0.3)
