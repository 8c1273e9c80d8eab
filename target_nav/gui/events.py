"""What happened, a line each: changes between one look and the next, and what the operator did."""

from __future__ import annotations

import threading
import time
from collections import deque
from collections.abc import Callable
from dataclasses import dataclass

from target_nav.gui.view_status import StatusView

CAPACITY = 300
LOOKS_TO_BE_LOST = 15
"""Looks in a row, at 20 Hz, before a stale source is a line of the log; the screen greys it out at once."""

INFO, GOOD, WARN, BAD = "info", "good", "warn", "bad"


@dataclass(frozen=True)
class Event:
    """`number` counts from 1 and never repeats; `clock_text` is the time of day."""

    number: int
    clock_text: str
    level: str
    text: str


class EventLog:
    """Bounded: the oldest lines go. `clock_text` is for tests."""

    def __init__(self, clock_text: Callable[[], str] = lambda: time.strftime("%H:%M:%S")) -> None:
        self._events: deque[Event] = deque(maxlen=CAPACITY)
        self._clock_text = clock_text
        self._count = 0
        self._lock = threading.Lock()
        self._last: StatusView | None = None
        self._bad_looks: dict[str, int] = {}
        self._differ_looks = 0

    @property
    def events(self) -> tuple[Event, ...]:
        """Oldest first."""
        with self._lock:
            return tuple(self._events)

    def add(self, text: str, level: str = INFO) -> None:
        """From any thread."""
        with self._lock:
            self._count += 1
            self._events.append(Event(self._count, self._clock_text(), level, text))

    def see(self, now: StatusView) -> None:
        """Compare with the last look, and write down what has changed."""
        before, self._last = self._last, now
        if before is None:
            if now.fresh:
                self.add(f"nav process found: {now.headline}, mission {now.mission or '-'}")
            return
        self._see_links(before, now)
        if not now.fresh:
            return
        self._differ_looks = self._differ_looks + 1 if now.settings_differ else 0
        if self._differ_looks == LOOKS_TO_BE_LOST:
            self.add("the nav process uses other settings than this screen shows", WARN)
        if now.mission != before.mission and now.mission:
            self.add(f"mission {now.mission}")
        if now.requested != before.requested:
            self.add("mission requested" if now.requested else "stopped")
        if (now.state, now.manual) != (before.state, before.manual):
            self.add(f"{now.headline}" + (f": {now.reason}" if now.reason else ""))
        if now.paused != before.paused:
            self.add("paused" if now.paused else "goes on")
        if now.outcome and (now.outcome, now.outcome_reason) != (before.outcome, before.outcome_reason):
            self.add(f"{now.outcome}: {now.outcome_reason}", GOOD if now.outcome == "succeeded" else WARN)
        if now.notice and now.notice_count != before.notice_count:
            self.add(now.notice, WARN if "not while" in now.notice or "must" in now.notice else INFO)

    def _see_links(self, before: StatusView, now: StatusView) -> None:
        for link in now.links:
            fine = link.fresh or link.quiet
            if fine:
                if self._bad_looks.pop(link.name, 0) >= LOOKS_TO_BE_LOST:
                    self.add(f"{link.label} is there", GOOD)
                continue
            # a source that hiccups, or begins to talk when the robot begins to drive, is not lost
            looks = self._bad_looks[link.name] = self._bad_looks.get(link.name, 0) + 1
            if looks == LOOKS_TO_BE_LOST:
                self.add(f"{link.label} lost: {link.problem}", BAD)
        for name in now.dead:
            if name not in before.dead:
                self.add(f"process {name} is down", BAD)
        for name in before.dead:
            if name not in now.dead:
                self.add(f"process {name} is back", GOOD)
