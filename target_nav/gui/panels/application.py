"""Runs the panel: a thread that reads shared memory at 20 Hz, ten frames a second, and a beat of 20 ms for the hands.

The thread hands over frozen views; GTK is touched by the main thread only. If the thread ends, which it should not, so
does the process, and the supervisor starts it again: the robot does not notice either.
"""

from __future__ import annotations

import logging
import signal
import threading
import time
from collections.abc import Callable
from pathlib import Path

from target_nav.gui.commands import CommandPort
from target_nav.gui.gtk import GLib, Gtk
from target_nav.gui.model import Model, Views
from target_nav.gui.operator import Operator
from target_nav.gui.panels.places import write_places
from target_nav.gui.panels.window import PanelWindow
from target_nav.gui.settings import Settings
from target_nav.utils.rate import RateKeeper

log = logging.getLogger(__name__)

POLL_HZ = 20.0
FRAME_S = 0.1
BEAT_MS = 20
OLD_S = 1.0


class Poller(threading.Thread):
    """Reads shared memory; `latest` is its newest look."""

    def __init__(self, model: Model) -> None:
        super().__init__(name="shared memory", daemon=True)
        self.latest: Views | None = None
        self.failure: BaseException | None = None
        self._model = model
        self._stop_asked = threading.Event()

    def run(self) -> None:
        rate = RateKeeper(POLL_HZ)
        try:
            while not self._stop_asked.is_set():
                self.latest = self._model.look(rate.wait())
        except Exception as error:
            self.failure = error
            log.exception("reading shared memory failed")

    def stop(self) -> None:
        self._stop_asked.set()
        self.join(1.0)


class Application:
    """One window. `run` returns 0 when it was asked to end, 1 when it cannot go on."""

    def __init__(
        self,
        prefix: str,
        settings: Settings,
        full_screen: bool,
        on_first_frame: Callable[[], None],
        places: Path | None = None,
    ) -> None:
        self._model = Model(prefix, settings.config)
        self._operator = Operator(CommandPort(prefix), self._model.log, settings)
        self._poller = Poller(self._model)
        self._places = places
        self._full_screen, self._on_first_frame = full_screen, on_first_frame
        self._drawn: Views | None = None
        self._frames = 0

    def run(self) -> int:
        # the first look comes before the window, so that its first frame shows something
        self._poller.latest = self._model.look(time.monotonic())
        window = self._window = PanelWindow(self._operator, self._full_screen)
        window.connect("draw", self._count_frame)
        for number in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP):
            GLib.unix_signal_add(GLib.PRIORITY_HIGH, number, Gtk.main_quit)
        if self._places is not None:
            GLib.unix_signal_add(GLib.PRIORITY_HIGH, signal.SIGUSR1, self._tell_places, self._places)
        self._frame()
        window.show()
        begin_s = time.monotonic()
        self._poller.start()
        self._due_s = time.monotonic()
        self._schedule()
        GLib.timeout_add(BEAT_MS, window.beat, priority=GLib.PRIORITY_HIGH)
        try:
            Gtk.main()
        finally:
            self._operator.close()
            self._poller.stop()
            self._model.close()
            took_s = max(time.monotonic() - begin_s, 1e-3)
            log.info("%d frames in %.0f s, %.1f frames a second", self._frames, took_s, self._frames / took_s)
        return 1 if self._poller.failure is not None else 0

    def _schedule(self) -> bool:
        """Draw, and again at the next tenth of a second: by deadlines, so that a busy machine draws as often."""
        self._frame()
        now_s = time.monotonic()
        self._due_s = max(self._due_s + FRAME_S, now_s + 0.2 * FRAME_S)
        GLib.timeout_add(int(1e3 * (self._due_s - now_s)), self._schedule)
        return False

    def _frame(self) -> None:
        views = self._poller.latest
        if self._poller.failure is not None:
            Gtk.main_quit()
            return
        if views is None:
            return
        late = time.monotonic() - views.now_s > OLD_S
        if views is not self._drawn or late:
            self._drawn = views
            self._model.config = self._operator.settings.config
            problem = "the panel itself is too slow: what you see is old" if late else ""
            self._window.show_views(views, self._model.world, problem)

    def _count_frame(self, *_: object) -> bool:
        self._frames += 1
        if self._frames == 1:
            GLib.idle_add(self._first_frame)
        return False

    def _tell_places(self, path: Path) -> bool:
        write_places(self._window, path)
        return True

    def _first_frame(self) -> bool:
        self._on_first_frame()
        return False
