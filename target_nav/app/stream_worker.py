"""The thread in which watchers are served, so that none of them ever delays a tick."""

from __future__ import annotations

import logging
import threading
from typing import Protocol

from target_nav.app.logs import CountedWarnings

log = logging.getLogger(__name__)


class Closable(Protocol):
    def close(self) -> None: ...


class Stream(Protocol):
    """Something with work waiting. `flush` does all of it, in the worker's thread."""

    @property
    def topic(self) -> str: ...

    @property
    def publisher(self) -> Closable: ...

    def flush(self) -> None: ...


class StreamWorker:
    """Flushes streams in the order in which they were woken. One that is woken again before its turn has one turn."""

    def __init__(self) -> None:
        self._waiting: dict[str, Stream] = {}
        self._condition = threading.Condition()
        self._closed = False
        self._warnings = CountedWarnings(log)
        self._thread = threading.Thread(target=self._run, name="watchers", daemon=True)
        self._thread.start()

    def wake(self, stream: Stream) -> None:
        """Never blocks for longer than it takes to note a name."""
        with self._condition:
            self._waiting.setdefault(stream.topic, stream)
            self._condition.notify()

    def end(self, stream: Stream | None) -> bool:
        """Its work is given up and its publisher closed; False for None, a stream that was not there."""
        if stream is None:
            return False
        with self._condition:
            self._waiting.pop(stream.topic, None)
        stream.publisher.close()
        log.info("closed stream %s", stream.topic)
        return True

    def close(self, patience_s: float = 1.0) -> None:
        with self._condition:
            self._closed = True
            self._condition.notify()
        self._thread.join(patience_s)

    def _run(self) -> None:
        while True:
            with self._condition:
                while not self._waiting and not self._closed:
                    self._condition.wait()
                if self._closed:
                    return
                stream = self._waiting.pop(next(iter(self._waiting)))
            try:
                stream.flush()
            except Exception as error:
                # a watcher is not worth a mission
                self._warnings.warn(f"stream {stream.topic}", f"stream {stream.topic}: {error!r}")
