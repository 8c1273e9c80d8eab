"""How long the last ticks took and how far they were apart, as py_trees_ros tells its watchers: over the last ten."""

from __future__ import annotations

import statistics
from collections import deque
from dataclasses import dataclass

WINDOW = 10


@dataclass(frozen=True)
class TickStatistics:
    """Durations and intervals in seconds; averages and variances over the last `WINDOW` ticks."""

    count: int = 0
    stamp_s: float = 0.0
    duration_s: float = 0.0
    duration_average_s: float = 0.0
    duration_variance_s2: float = 0.0
    interval_s: float = 0.0
    interval_average_s: float = 0.0
    interval_variance_s2: float = 0.0


class TickMeter:
    """`note` once a tick; `statistics` when somebody wants to know."""

    def __init__(self) -> None:
        self._durations: deque[float] = deque(maxlen=WINDOW)
        self._intervals: deque[float] = deque(maxlen=WINDOW)
        self._count = 0
        self._last_s = 0.0

    def note(self, begin_s: float, end_s: float) -> None:
        if self._count:
            self._intervals.append(begin_s - self._last_s)
        self._durations.append(end_s - begin_s)
        self._last_s = begin_s
        self._count += 1

    def statistics(self) -> TickStatistics:
        if not self._count:
            return TickStatistics()
        return TickStatistics(self._count, self._last_s, *_three(self._durations), *_three(self._intervals))


def _three(series: deque[float]) -> tuple[float, float, float]:
    """Newest value, average, sample variance."""
    if not series:
        return 0.0, 0.0, 0.0
    variance = statistics.variance(series) if len(series) > 1 else 0.0
    return series[-1], statistics.fmean(series), variance
