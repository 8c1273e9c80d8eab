"""ROS time and the monotonic clock: the one place where one becomes the other.

Everything inside the project is stamped with CLOCK_MONOTONIC; ROS messages carry wall time. Their difference
is measured once and only replaced when the wall clock was set (a board without a battery jumps by years when
it first finds a time server); slewing moves both clocks alike. All processes of one machine so agree on every
stamp.
"""

from __future__ import annotations

import time
from collections.abc import Callable
from typing import Protocol

STEP_LIMIT_NS = 20_000_000
"""A difference that moved by more than this was stepped; less is the scheduler between two readings."""

ATTEMPTS = 5


class StampLike(Protocol):
    """`builtin_interfaces/Time`, or anything with its two fields."""

    sec: int
    nanosec: int


class RosClock:
    """Maps stamps both ways. `steps` counts how often the wall clock was set since the start."""

    def __init__(
        self,
        monotonic_ns: Callable[[], int] = time.monotonic_ns,
        wall_ns: Callable[[], int] = time.time_ns,
        on_step: Callable[[float], None] | None = None,
    ) -> None:
        self._monotonic_ns = monotonic_ns
        self._wall_ns = wall_ns
        self._on_step = on_step or (lambda step_s: None)
        self._offset_ns = self._measure()
        self.steps = 0

    def now_s(self) -> float:
        """Monotonic time in seconds."""
        return self._monotonic_ns() * 1e-9

    def to_monotonic(self, stamp: StampLike) -> float:
        """The monotonic time of a ROS stamp, in seconds."""
        self._follow_steps()
        return (stamp.sec * 1_000_000_000 + stamp.nanosec - self._offset_ns) * 1e-9

    def to_wall_ns(self, stamp_s: float) -> int:
        """The wall time of a monotonic stamp, in nanoseconds since 1970; never before that."""
        self._follow_steps()
        return max(round(stamp_s * 1e9) + self._offset_ns, 0)

    def _follow_steps(self) -> None:
        measured_ns = self._measure()
        step_ns = measured_ns - self._offset_ns
        if abs(step_ns) > STEP_LIMIT_NS:
            self._offset_ns = measured_ns
            self.steps += 1
            self._on_step(step_ns * 1e-9)

    def _measure(self) -> int:
        """Wall minus monotonic time, of the attempt whose two monotonic readings lie closest together."""
        best_gap_ns, best_ns = None, 0
        for _ in range(ATTEMPTS):
            before_ns = self._monotonic_ns()
            wall_ns = self._wall_ns()
            gap_ns = self._monotonic_ns() - before_ns
            if best_gap_ns is None or gap_ns < best_gap_ns:
                best_gap_ns, best_ns = gap_ns, wall_ns - before_ns - gap_ns // 2
            if gap_ns < STEP_LIMIT_NS // 4:
                break
        return best_ns
