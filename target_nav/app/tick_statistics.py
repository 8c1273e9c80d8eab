"""How long the last ticks took and how far they were apart, as py_trees_ros tells its watchers: over the last ten."""

from __future__ import annotations

import statistics
from collections import deque
from collections.abc import Sequence
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


@dataclass(frozen=True)
class TickSeries:
    """The last ticks' durations and intervals, as they were. Cheap to take; the statistics may be worked out later."""

    count: int
    stamp_s: float
    durations_s: tuple[float, ...]
    intervals_s: tuple[float, ...]

    def statistics(self) -> TickStatistics:
        if not self.count:
            return TickStatistics()
        return TickStatistics(self.count, self.stamp_s, *_three(self.durations_s), *_three(self.intervals_s))


class TickMeter:
    """`note` once a tick; `series` or `statistics` when somebody wants to know."""

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

    def series(self) -> TickSeries:
        return TickSeries(self._count, self._last_s, tuple(self._durations), tuple(self._intervals))

    def statistics(self) -> TickStatistics:
        return self.series().statistics()


def _three(series: Sequence[float]) -> tuple[float, float, float]:
    """Newest value, average, sample variance."""
    if not series:
        return 0.0, 0.0, 0.0
    variance = statistics.variance(series) if len(series) > 1 else 0.0
    return series[-1], statistics.fmean(series), variance
