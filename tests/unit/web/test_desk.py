"""A far clock: messages are late by how much longer they took than the fastest."""

from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from target_nav.web.desk import FarClock


@given(
    st.floats(-1e6, 1e6),
    st.lists(st.floats(0.0, 1.0), min_size=1, max_size=50),
)
def test_lateness_is_the_delay_beyond_the_smallest_so_far(offset_s: float, delays_s: list[float]) -> None:
    clock = FarClock()
    for number, delay_s in enumerate(delays_s):
        sent_s = 0.05 * number
        late_s = clock.lateness_s(sent_s + delay_s, sent_s + offset_s)
        assert late_s == pytest.approx(delay_s - min(delays_s[: number + 1]), abs=1e-6)


def test_clocks_may_drift_apart() -> None:
    """A clock that loses 100 ppm is 0.36 s behind after an hour; that is not lateness."""
    clock = FarClock()
    for number in range(36000):
        here_s = 0.1 * number
        late_s = clock.lateness_s(here_s, here_s * (1 - 1e-4))
        assert late_s < 0.01
