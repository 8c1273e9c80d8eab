"""ROS stamps and the monotonic clock: inverse to each other, faithful through a stepped wall clock."""

from __future__ import annotations

from dataclasses import dataclass

import pytest
from hypothesis import given
from hypothesis import strategies as st

from target_nav.app.ros_clock import RosClock


@dataclass
class Stamp:
    sec: int
    nanosec: int


class Clocks:
    """A machine's two clocks. Reading the monotonic one takes `reading_ns`."""

    def __init__(self) -> None:
        self.mono = 5_000_000_000
        self.wall = 1_700_000_000_000_000_000
        self.reading_ns = 100
        self.steps: list[float] = []

    def monotonic_ns(self) -> int:
        self.go(self.reading_ns)
        return self.mono

    def wall_ns(self) -> int:
        return self.wall

    def go(self, ns: int) -> None:
        self.mono += ns
        self.wall += ns

    def ros_clock(self) -> RosClock:
        return RosClock(self.monotonic_ns, self.wall_ns, self.steps.append)

    def stamp(self) -> Stamp:
        return Stamp(*divmod(self.wall, 1_000_000_000))


def test_a_stamp_taken_now_is_now() -> None:
    clocks = Clocks()
    clock = clocks.ros_clock()
    assert clock.to_monotonic(clocks.stamp()) == pytest.approx(clock.now_s(), abs=1e-5)


@given(st.floats(0.0, 1e6))
def test_there_and_back_is_the_same(stamp_s: float) -> None:
    clock = Clocks().ros_clock()
    wall_ns = clock.to_wall_ns(stamp_s)
    assert clock.to_monotonic(Stamp(*divmod(wall_ns, 1_000_000_000))) == pytest.approx(stamp_s, abs=1e-6)


def test_a_wall_clock_that_was_set_is_followed() -> None:
    clocks = Clocks()
    clock = clocks.ros_clock()
    clocks.go(1_000_000_000)
    clocks.wall += 3600 * 1_000_000_000
    assert clock.to_monotonic(clocks.stamp()) == pytest.approx(clock.now_s(), abs=1e-5)
    assert clock.steps == 1
    assert clocks.steps == [pytest.approx(3600.0, abs=1e-3)]


def test_slewing_and_the_scheduler_are_no_step() -> None:
    clocks = Clocks()
    clock = clocks.ros_clock()
    for _ in range(100):
        clocks.go(1_000_000_000)
        clocks.wall += 50_000
        clock.to_monotonic(clocks.stamp())
    assert clock.steps == 0


def test_a_reading_that_was_interrupted_is_not_believed() -> None:
    clocks = Clocks()
    clock = clocks.ros_clock()
    readings = iter([0, 200_000_000, 100, 100])

    def interrupted() -> int:
        clocks.go(next(readings, 100))
        return clocks.mono

    clock._monotonic_ns = interrupted
    stamp = clocks.stamp()
    clock.to_monotonic(stamp)
    assert clock.steps == 0


def test_a_stamp_before_1970_becomes_zero() -> None:
    assert Clocks().ros_clock().to_wall_ns(-1e12) == 0
