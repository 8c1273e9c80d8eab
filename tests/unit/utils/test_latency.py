from __future__ import annotations

import math

from hypothesis import given
from hypothesis import strategies as st

from target_nav.utils.latency import LatencyWindow


def test_a_window_is_told_once_and_then_begins_anew() -> None:
    window = LatencyWindow(10.0, start_s=100.0)
    for k in range(100):
        window.add(0.001 * (k + 1))
    assert window.take(109.9) is None
    summary = window.take(110.0)
    assert summary is not None
    assert (summary.count, summary.rate_hz) == (100, 10.0)
    assert (summary.p50_s, summary.p99_s, summary.max_s) == (0.050, 0.099, 0.100)
    assert window.take(119.0) is None
    empty = window.take(120.0)
    assert empty is not None
    assert empty.count == 0
    assert math.isnan(empty.p50_s)
    assert str(empty) == "none in 10 s"


@given(st.lists(st.floats(0.0, 10.0), min_size=1))
def test_quantiles_are_ordered_and_observed(latencies_s: list[float]) -> None:
    window = LatencyWindow(1.0, start_s=0.0)
    for latency_s in latencies_s:
        window.add(latency_s)
    summary = window.take(1.0)
    assert summary is not None
    assert summary.p50_s <= summary.p99_s <= summary.max_s == max(latencies_s)
    assert {summary.p50_s, summary.p99_s} <= set(latencies_s)
