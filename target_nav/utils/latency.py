"""How late something is, over a window: collected with every event, told now and then."""

from __future__ import annotations

import math
from dataclasses import dataclass


@dataclass(frozen=True)
class LatencySummary:
    """Median, 99th percentile and largest of `count` latencies, over `span_s` seconds."""

    count: int
    span_s: float
    p50_s: float
    p99_s: float
    max_s: float

    @property
    def rate_hz(self) -> float:
        return self.count / self.span_s if self.span_s > 0.0 else math.nan

    def __str__(self) -> str:
        if self.count == 0:
            return f"none in {self.span_s:.0f} s"
        return (
            f"{self.rate_hz:.1f} Hz, latency p50 {1e3 * self.p50_s:.1f} ms, p99 {1e3 * self.p99_s:.1f} ms, "
            f"max {1e3 * self.max_s:.1f} ms"
        )


class LatencyWindow:
    """`add` every latency, `take` a summary of each window of `window_s`; then a new window begins."""

    def __init__(self, window_s: float, start_s: float) -> None:
        self._window_s = window_s
        self._start_s = start_s
        self._latencies_s: list[float] = []

    def add(self, latency_s: float) -> None:
        self._latencies_s.append(latency_s)

    def take(self, now_s: float) -> LatencySummary | None:
        """None while the window is still open."""
        span_s = now_s - self._start_s
        if span_s < self._window_s:
            return None
        ordered = sorted(self._latencies_s)
        self._latencies_s = []
        self._start_s = now_s
        if not ordered:
            return LatencySummary(0, span_s, math.nan, math.nan, math.nan)
        return LatencySummary(
            len(ordered), span_s, _nearest_rank(ordered, 0.50), _nearest_rank(ordered, 0.99), ordered[-1]
        )


def _nearest_rank(ordered: list[float], fraction: float) -> float:
    return ordered[max(math.ceil(fraction * len(ordered)) - 1, 0)]
