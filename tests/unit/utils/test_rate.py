"""RateKeeper on a clock of its own: no drift, no bursts, honest numbers."""

from __future__ import annotations

import gc
import math
import os

import pytest
from hypothesis import given
from hypothesis import strategies as st

from target_nav.utils.rate import RateKeeper, request_soft_realtime


class FakeTime:
    """A clock that moves only while sleeping or working. Sleeping takes `oversleep_s` too long."""

    def __init__(self, now_s: float = 1000.0, oversleep_s: float = 0.0) -> None:
        self.now_s = now_s
        self.oversleep_s = oversleep_s
        self.slept_s: list[float] = []

    def clock(self) -> float:
        return self.now_s

    def sleep(self, seconds: float) -> None:
        self.slept_s.append(seconds)
        self.now_s += seconds + self.oversleep_s

    def work(self, seconds: float) -> None:
        self.now_s += seconds


def keeper(time: FakeTime, rate_hz: float = 20.0, window: int = 1200) -> RateKeeper:
    return RateKeeper(rate_hz, window=window, clock=time.clock, sleep=time.sleep)


def test_the_first_tick_does_not_wait() -> None:
    time = FakeTime()
    assert keeper(time).wait() == 1000.0
    assert time.slept_s == []


def test_ticks_come_a_period_apart_whatever_the_work_takes() -> None:
    time = FakeTime()
    rate = keeper(time)
    ticks = []
    for work_s in (0.001, 0.049, 0.02, 0.0, 0.03):
        ticks.append(rate.wait())
        time.work(work_s)
    assert ticks == pytest.approx([1000.0, 1000.05, 1000.1, 1000.15, 1000.2])


def test_lateness_does_not_add_up() -> None:
    time = FakeTime(oversleep_s=0.0007)
    rate = keeper(time)
    for _ in range(10_000):
        last_s = rate.wait()
    assert last_s == pytest.approx(1000.0 + 9_999 * 0.05 + 0.0007, abs=1e-6)
    assert rate.statistics().rate_hz == pytest.approx(20.0)


def test_a_missed_deadline_is_skipped_and_counted_not_made_up_for() -> None:
    time = FakeTime()
    rate = keeper(time)
    rate.wait()
    time.work(0.16)  # past the deadlines at 0.05, 0.10 and 0.15
    assert rate.wait() == pytest.approx(1000.2)
    assert rate.wait() == pytest.approx(1000.25)
    assert rate.overruns == 3
    assert rate.count == 3


def test_work_that_ends_on_the_deadline_is_in_time() -> None:
    time = FakeTime(now_s=0.0)
    rate = keeper(time, rate_hz=4.0)
    rate.wait()
    time.work(0.25)
    assert rate.wait() == 0.25
    assert rate.overruns == 0


def test_a_sleep_that_ends_early_is_continued() -> None:
    time = FakeTime()

    def doze(seconds: float) -> None:
        time.now_s += max(seconds / 2.0, 1e-4)

    rate = RateKeeper(20.0, clock=time.clock, sleep=doze)
    rate.wait()
    assert rate.wait() >= 1000.05


def test_statistics_tell_lateness_and_rate_of_the_window() -> None:
    time = FakeTime()
    rate = keeper(time, window=100)
    for tick in range(300):
        time.oversleep_s = 0.010 if tick % 50 == 0 else 0.001
        rate.wait()
    statistics = rate.statistics()
    assert statistics.lateness_p50_s == pytest.approx(0.001)
    assert statistics.lateness_p99_s == pytest.approx(0.010)
    assert statistics.lateness_max_s == pytest.approx(0.010)
    assert statistics.rate_hz == pytest.approx(20.0, rel=0.01)
    assert (statistics.overruns, statistics.count) == (0, 300)


def test_a_skipped_tick_lowers_the_rate_achieved() -> None:
    time = FakeTime()
    rate = keeper(time)
    for tick in range(101):
        rate.wait()
        if tick % 10 == 9:
            time.work(0.06)
    assert rate.statistics().rate_hz == pytest.approx(20.0 * 100 / 110, rel=1e-3)
    assert rate.overruns == 10


def test_there_are_no_statistics_before_the_second_tick() -> None:
    rate = keeper(FakeTime())
    assert rate.statistics().rate_hz == 0.0
    rate.wait()
    assert rate.statistics().rate_hz == 0.0
    assert rate.statistics().count == 1


@given(st.lists(st.floats(0.0, 0.4), max_size=60), st.floats(0.0, 0.01))
def test_ticks_never_come_early_nor_closer_than_the_grid(work_s: list[float], oversleep_s: float) -> None:
    time = FakeTime(now_s=0.0, oversleep_s=oversleep_s)
    rate = keeper(time, rate_hz=10.0)
    previous = -1
    for seconds in work_s:
        now_s = rate.wait()
        index = math.floor(now_s / 0.1 + 1e-9)
        assert index > previous
        assert now_s - index * 0.1 <= oversleep_s + 1e-9
        previous = index
        time.work(seconds)
    assert rate.count + rate.overruns == previous + 1


@pytest.mark.parametrize("rate_hz", [0.0, -1.0, math.nan, math.inf])
def test_a_rate_that_is_none_is_refused(rate_hz: float) -> None:
    with pytest.raises(ValueError, match="Hz"):
        RateKeeper(rate_hz)


def test_a_window_without_an_interval_is_refused() -> None:
    with pytest.raises(ValueError, match="window"):
        RateKeeper(20.0, window=1)


def test_freezing_keeps_objects_out_of_collections() -> None:
    try:
        (grant,) = request_soft_realtime()
        assert grant.granted
        assert gc.get_freeze_count() > 0
        assert str(grant).startswith("garbage collector frozen: granted")
    finally:
        gc.unfreeze()


@pytest.mark.linux
def test_what_is_refused_is_told_and_no_error() -> None:
    core = max(os.sched_getaffinity(0)) + 1000
    (grant,) = request_soft_realtime(freeze=False, core=core)
    assert not grant.granted
    assert str(grant) == f"core {core}: not granted (Invalid argument)"


@pytest.mark.linux
def test_a_core_is_taken() -> None:
    before = os.sched_getaffinity(0)
    try:
        (grant,) = request_soft_realtime(freeze=False, core=min(before))
        assert grant.granted
        assert os.sched_getaffinity(0) == {min(before)}
    finally:
        os.sched_setaffinity(0, before)


@pytest.mark.linux
def test_niceness_is_never_raised() -> None:
    nice = os.getpriority(os.PRIO_PROCESS, 0)
    (grant,) = request_soft_realtime(freeze=False, nice=nice + 5)
    assert grant.granted
    assert os.getpriority(os.PRIO_PROCESS, 0) == nice
