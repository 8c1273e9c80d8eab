"""What the supervisor has to know about one process."""

from __future__ import annotations

import math
from dataclasses import dataclass
from enum import Enum


class ReadyWhen(Enum):
    """When a process that was started counts as running."""

    REPORTED = "reported"
    """The process called `report_ready`."""
    STARTED = "started"
    """At once."""


@dataclass(frozen=True)
class RestartPolicy:
    """What happens when a process ends by itself. Exit code 2 (cannot be run) is never restarted.

    The n-th failure within `window_s` is answered after `first_delay_s * 2**(n - 1)`, at most `max_delay_s`;
    with `max_failures` of them the process is given up.
    """

    restart: bool = True
    after_success: bool = True
    """Also when it ended with exit code 0: a process that has no end of its own should not have ended."""
    first_delay_s: float = 0.25
    max_delay_s: float = 5.0
    max_failures: int = 5
    window_s: float = 30.0

    def delay_s(self, failures: int) -> float:
        """Back-off before the restart that follows so many failures in a row."""
        return min(self.first_delay_s * math.pow(2.0, max(failures - 1, 0)), self.max_delay_s)


NO_RESTART = RestartPolicy(restart=False)
"""For a process whose end means something: it is reported with its exit code."""


@dataclass(frozen=True)
class ProcessSpec:
    """One row of the process table.

    `core` None: not pinned. `nice` None: as the supervisor. `holds_next`: the processes after it in the table
    are not started before it is ready; otherwise they start beside it. When a `critical` process is given up
    or cannot be run, the whole stack is stopped; another one only stays away.
    """

    name: str
    argv: tuple[str, ...]
    core: int | None = None
    nice: int | None = None
    critical: bool = True
    ready: ReadyWhen = ReadyWhen.STARTED
    holds_next: bool = True
    ready_timeout_s: float = 30.0
    restart: RestartPolicy = RestartPolicy()
    stop_timeout_s: float = 3.0
    children: tuple[str, ...] = ()
    """Processes it starts itself and whose logs, beside its own, belong to the run's."""
