"""What every process of the stack does the same way: one catch, exit codes, signals, and saying that it is
ready.

Exit codes are the supervisor's language: 0 ended as asked, 1 failed and may be started again, 2 cannot be run
as it was asked to (a wrong option, a port that is not there), so starting it again would change nothing.
"""

from __future__ import annotations

import logging
import os
import select
import signal
import threading
from collections.abc import Callable
from pathlib import Path
from types import FrameType, TracebackType
from typing import Any

from target_nav.app.logs import configure_logging
from target_nav.errors import TargetNavError

EXIT_OK = 0
EXIT_FAILED = 1
EXIT_CANNOT_RUN = 2

READY_FILE_VARIABLE = "TARGET_NAV_READY_FILE"
"""Where the supervisor waits for a process to say that it is ready; unset without a supervisor."""

log = logging.getLogger(__name__)


def run_process(name: str, body: Callable[[], int | None]) -> int:
    """Run a process's `body` with the only catch there is; the exit code for `sys.exit`.

    `body` makes the robot safe on its way out (`finally`); here an error only becomes a line in the log and a
    code.
    """
    configure_logging(name)
    try:
        return body() or EXIT_OK
    except TargetNavError as error:
        log.error("%s", error)
        return EXIT_CANNOT_RUN
    except KeyboardInterrupt:
        return EXIT_OK
    except Exception:
        log.exception("%s failed", name)
        return EXIT_FAILED


def report_ready() -> None:
    """Tell the supervisor, if there is one, that whoever depends on this process may be started."""
    path = os.environ.get(READY_FILE_VARIABLE)
    if path:
        Path(path).touch()


class StopSignal:
    """Turns SIGINT, SIGTERM and SIGHUP into something to wait on, for as long as the `with` block runs.

    A second signal while the first is still being obeyed ends the process at once, with the signal's own
    effect.
    """

    SIGNALS = (signal.SIGINT, signal.SIGTERM, signal.SIGHUP)

    def __init__(self) -> None:
        # A pipe, for a handler must not take the lock of an Event that the interrupted code may be holding.
        self._wake_read, self._wake_write = os.pipe2(os.O_NONBLOCK | os.O_CLOEXEC)
        self._requested = False
        self._previous: dict[signal.Signals, Any] = {}

    def __enter__(self) -> StopSignal:
        # Only the main thread may install handlers; a test that runs a node in a thread calls `request`
        # instead.
        if threading.current_thread() is threading.main_thread():
            for number in self.SIGNALS:
                self._previous[number] = signal.signal(number, self._handle)
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        for number, handler in self._previous.items():
            signal.signal(number, handler)
        self._previous.clear()
        os.close(self._wake_read)
        os.close(self._wake_write)

    def _handle(self, number: int, frame: FrameType | None) -> None:
        if self._requested:
            signal.signal(number, signal.SIG_DFL)
            os.kill(os.getpid(), number)
        self.request()

    def request(self) -> None:
        """Stop as if a signal had come."""
        if not self._requested:
            self._requested = True
            os.write(self._wake_write, b"s")

    @property
    def requested(self) -> bool:
        return self._requested

    def wait(self, timeout_s: float) -> bool:
        """Block for at most `timeout_s`; True as soon as the process shall stop."""
        if not self._requested:
            select.select([self._wake_read], [], [], timeout_s)
        return self._requested
