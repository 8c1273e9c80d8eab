"""How long ticks take and how regularly they come, as watchers show it: over the last ten ticks."""

from __future__ import annotations

import statistics
from collections import deque
from dataclasses import dataclass

WINDOW = 10


@dataclass(frozen=True)
class TickStatistics:
    """Fields of py_trees_ros_interfaces/Statistics; times in seconds, variances in s^2."""

    count: int = 0
    stamp_s: float = 0.0
    tick_duration: float = 0.0
    tick_duration_average: float = 0.0
    tick_duration_variance: float = 0.0
    tick_interval: float = 0.0
    tick_interval_average: float = 0.0
    tick_interval_variance: float = 0.0


class TickStatisticsWindow:
    """Fed once a tick."""

    def __init__(self) -> None:
        self._count = 0
        self._last_stamp_s: float | None = None
        self._durations_s: deque[float] = deque(maxlen=WINDOW)
        self._intervals_s: deque[float] = deque(maxlen=WINDOW)

    def add(self, stamp_s: float, duration_s: float) -> TickStatistics:
        """`stamp_s` is when the tick began. The first tick has no interval before it and counts with 0."""
        self._count += 1
        self._intervals_s.append(0.0 if self._last_stamp_s is None else stamp_s - self._last_stamp_s)
        self._durations_s.append(duration_s)
        self._last_stamp_s = stamp_s
        return TickStatistics(
            count=self._count,
            stamp_s=stamp_s,
            tick_duration=duration_s,
            tick_duration_average=statistics.fmean(self._durations_s),
            tick_duration_variance=_variance(self._durations_s),
            tick_interval=self._intervals_s[-1],
            tick_interval_average=statistics.fmean(self._intervals_s),
            tick_interval_variance=_variance(self._intervals_s),
        )


def _variance(values: deque[float]) -> float:
    return statistics.variance(values) if len(values) > 1 else 0.0
