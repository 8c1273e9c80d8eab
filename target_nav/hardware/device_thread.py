"""The thread that owns a device: reads it until it is lost, opens it again at growing intervals, until `close`."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable

from target_nav.errors import DeviceError

FIRST_RETRY_S = 0.1
LAST_RETRY_S = 2.0
JOIN_S = 2.0


class DeviceThread:
    """One reader thread.

    Args:
        name: of the thread.
        connect: opens the device; raises DeviceError when that cannot be done now.
        read: reads until the device is lost or `closing` is set, and says why it ended.
        drop: closes whatever is left of the device.
        on_connection: called from the thread with True when the device is back, with False when it was lost, and why.
    """

    def __init__(
        self,
        name: str,
        connect: Callable[[], None],
        read: Callable[[], str],
        drop: Callable[[], None],
        on_connection: Callable[[bool, str], None] | None = None,
        clock: Callable[[], float] = time.monotonic,
    ) -> None:
        self.closing = threading.Event()
        self._name = name
        self._connect, self._read, self._drop = connect, read, drop
        self._on_connection = on_connection or (lambda connected, reason: None)
        self._clock = clock
        self._thread: threading.Thread | None = None
        self._failure: Exception | None = None

    @property
    def running(self) -> bool:
        """Between `open` and `close`."""
        return self._thread is not None

    def open(self, wait_s: float = 0.0) -> None:
        """Open the device, waiting up to `wait_s` for it to appear, and start reading.

        Raises:
            DeviceError: of the last attempt.
        """
        deadline_s = self._clock() + wait_s
        while True:
            try:
                self._connect()
                break
            except DeviceError:
                if self._clock() >= deadline_s or self.closing.wait(FIRST_RETRY_S):
                    raise
        self._thread = threading.Thread(target=self._run, name=self._name, daemon=True)
        self._thread.start()

    def close(self) -> None:
        """End the thread and the device with it. May be called again."""
        if self._thread is None:
            return
        self.closing.set()
        self._thread.join(timeout=JOIN_S)
        self._thread = None

    def raise_failure(self) -> None:
        """Raise what ended the thread, if something did: an error in a handler is not swallowed."""
        if self._failure is not None:
            raise self._failure

    def _run(self) -> None:
        try:
            while not self.closing.is_set():
                reason = self._read()
                self._drop()
                if self.closing.is_set():
                    break
                self._on_connection(False, reason)
                self._reconnect()
        except Exception as error:
            self._failure = error
        finally:
            self._drop()

    def _reconnect(self) -> None:
        retry_s = FIRST_RETRY_S
        while not self.closing.wait(retry_s):
            try:
                self._connect()
            except DeviceError:
                retry_s = min(2.0 * retry_s, LAST_RETRY_S)
                continue
            self._on_connection(True, "")
            return
