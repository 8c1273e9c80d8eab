"""What happened, a line each: changes between one look and the next, and what the operator did."""

from __future__ import annotations

import time
from collections import deque
from collections.abc import Callable
from dataclasses import dataclass

from target_nav.gui.view_status import StatusView

CAPACITY = 300

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
        self._last: StatusView | None = None

    @property
    def events(self) -> tuple[Event, ...]:
        """Oldest first."""
        return tuple(self._events)

    def add(self, text: str, level: str = INFO) -> None:
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
        was_fresh = {link.name: link.fresh for link in before.links}
        for link in now.links:
            if link.fresh and not was_fresh.get(link.name, False):
                self.add(f"{link.label} is there", GOOD)
            elif not link.fresh and was_fresh.get(link.name, True):
                self.add(f"{link.label} lost: {link.problem}", BAD)
        for name in now.dead:
            if name not in before.dead:
                self.add(f"process {name} is down", BAD)
        for name in before.dead:
            if name not in now.dead:
                self.add(f"process {name} is back", GOOD)
