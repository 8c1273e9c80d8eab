"""Logging of a process: one line an event on stderr, and warnings that do not flood it.

The supervisor sends a process's stderr to a file, so nothing here opens files. A line begins with the time of
day; the merged log is ordered by it.
"""

from __future__ import annotations

import logging
import sys
import time
from collections.abc import Callable

LINE_FORMAT = "%(asctime)s.%(msecs)03d %(levelname)-7s {process}: %(message)s"
TIME_FORMAT = "%H:%M:%S"


def configure_logging(process: str, level: int = logging.INFO) -> None:
    """Send the root logger to stderr in this project's form; called once, at the start of a process."""
    logging.basicConfig(
        level=level,
        stream=sys.stderr,
        format=LINE_FORMAT.format(process=process),
        datefmt=TIME_FORMAT,
        force=True,
    )


class CountedWarnings:
    """Warnings that may come with every message: each kind is counted always and logged once in `every_s`.

    A logged warning says how many of its kind were kept quiet since the last one.
    """

    def __init__(
        self,
        logger: logging.Logger,
        every_s: float = 5.0,
        clock: Callable[[], float] = time.monotonic,
    ) -> None:
        self._logger = logger
        self._every_s = every_s
        self._clock = clock
        self._logged_s: dict[str, float] = {}
        self._quiet: dict[str, int] = {}
        self.counts: dict[str, int] = {}

    def warn(self, kind: str, message: str) -> None:
        """Count one warning of `kind` (a fixed name), and log `message` if it is time to."""
        self.counts[kind] = self.counts.get(kind, 0) + 1
        now_s = self._clock()
        last_s = self._logged_s.get(kind)
        if last_s is not None and now_s - last_s < self._every_s:
            self._quiet[kind] = self._quiet.get(kind, 0) + 1
            return
        quiet = self._quiet.pop(kind, 0)
        self._logged_s[kind] = now_s
        self._logger.warning("%s%s", message, f" ({quiet} more like it before)" if quiet else "")
