"""The supervisor's table in shared memory, about once a second, so that a screen can name who is down."""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence

from target_nav.app.supervised import ProcessStatus
from target_nav.ipc import channels
from target_nav.state.snapshots import ProcessRow, ProcessTable

PERIOD_S = 1.0


class ProcessChannel:
    """Raises DeviceError on opening if another supervisor writes the channel."""

    def __init__(self, prefix: str, clock: Callable[[], float] = time.monotonic) -> None:
        self._writer = channels.open_writer(channels.PROCESSES, prefix=prefix)
        self._clock = clock
        self._next_s = 0.0
        self._last: tuple[ProcessRow, ...] = ()

    def tell(self, statuses: Sequence[ProcessStatus]) -> None:
        """Cheap to call often: writes when something changed, and once a second."""
        rows = tuple(ProcessRow(s.name, s.state.value, s.pid or 0, s.restarts) for s in statuses)
        now_s = self._clock()
        if rows == self._last and now_s < self._next_s:
            return
        self._last, self._next_s = rows, now_s + PERIOD_S
        self._writer.write(ProcessTable(now_s, rows))

    def close(self) -> None:
        self._writer.close()
