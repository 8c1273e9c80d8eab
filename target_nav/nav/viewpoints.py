"""Where to look from next: the place that shows most unseen floor for the way to it.

Next best view by lazy greedy choice: what a place would show grows less while the search goes on, but for floor that
has come to be known since. What it showed when it was last asked, and that, bound what it shows now; only the most
promising few have to be asked again (Minoux, "Accelerated greedy algorithms", 1978). A bounded number is asked a tick.
"""

from __future__ import annotations

import math
from enum import Enum

import numpy as np
from numpy.typing import NDArray

from target_nav.nav.coverage import Coverage
from target_nav.nav.drive import Driver
from target_nav.nav.skill import View
from target_nav.state.types import FloatArray

_STOP_S = 4.0
"""What stopping at a place to look round costs, beside the way to it."""
_ASKED_A_TICK = 24
_NEWLY_KNOWN = 2.0
"""A place may show so much more than before, of the floor that has come to be known since, as it opens the view on."""
_ANYTHING_M2 = 1e6
_MOST_TICKS = 20
"""After so many the best that was asked is taken: 480 places."""


class Verdict(Enum):
    CHOSEN = "chosen"
    ASKING = "asking"
    """There are more to compare in the next tick."""
    NONE = "none"
    """No place that can be reached shows enough."""


class Viewpoints:
    def __init__(self, coverage: Coverage, driver: Driver, speed_mps: float, limit_m: float) -> None:
        """`limit_m` bounds the cost of a way."""
        self._coverage, self._driver = coverage, driver
        self._speed_mps, self._limit_m = speed_mps, limit_m
        self.begin(np.empty((0, 2)))

    def begin(self, spots_m: FloatArray) -> None:
        """The places there are, in odom, shape (K, 2)."""
        self._spots_m = spots_m
        self._given_up: NDArray[np.bool_] = np.zeros(len(spots_m), dtype=np.bool_)
        self.chosen: int | None = None
        self.look(0.0)

    def look(self, least_m2: float) -> None:
        """Ask them all anew; places that show less than `least_m2` do not count."""
        self._least_m2 = least_m2
        self._done = self._given_up.copy()
        self._shows_m2: FloatArray = np.full(len(self._spots_m), _ANYTHING_M2)
        self._known_m2: FloatArray = np.zeros(len(self._spots_m))
        self._costs_m: FloatArray | None = None
        self._has_waited = False

    @property
    def place_m(self) -> tuple[float, float]:
        """The chosen place."""
        assert self.chosen is not None, "nothing is chosen"
        return float(self._spots_m[self.chosen, 0]), float(self._spots_m[self.chosen, 1])

    @property
    def left(self) -> int:
        return int(len(self._done) - np.count_nonzero(self._done))

    def drop(self) -> None:
        """Choose again, for the robot is elsewhere by now."""
        self.chosen = self._costs_m = None

    def finish(self, *, given_up: bool = False) -> None:
        """The chosen place was looked round from, is not worth it any more, or cannot be reached (`given_up`)."""
        if self.chosen is not None:
            self._done[self.chosen] = True
            self._given_up[self.chosen] |= given_up
        self.chosen = None

    def choose(self, view: View) -> Verdict:
        """Compare some more; call it each tick until it is not ASKING.

        What a way to each place costs is worked out in a tick of its own, for that alone is as much as a plan.
        """
        if self._costs_m is None:
            waits = view.is_busy and not self._has_waited
            self._has_waited = waits
            if not waits:
                self._start(view)
            return Verdict.ASKING
        self._ticks += 1
        known_m2 = self._coverage.known_m2
        bound_m2 = np.minimum(self._shows_m2 + _NEWLY_KNOWN * (known_m2 - self._known_m2), self._all_round_m2)
        value = np.where(self._candidates, bound_m2 * self._per_s, 0.0)
        left = np.flatnonzero(self._candidates & ~self._asked & (bound_m2 >= self._least_m2))
        ask = left[np.argsort(-value[left], kind="stable")[:_ASKED_A_TICK]]
        if len(ask):
            self._shows_m2[ask] = self._coverage.unseen_by_ray_m2(self._spots_m[ask]).sum(axis=1)
            self._known_m2[ask], self._asked[ask] = known_m2, True
        worth = np.flatnonzero(self._asked & (self._shows_m2 >= self._least_m2))
        best = int(worth[np.argmax(self._shows_m2[worth] * self._per_s[worth])]) if len(worth) else None
        unasked = left[~self._asked[left]]
        promising = len(unasked) > 0 and (
            best is None or float(value[unasked].max()) > float(self._shows_m2[best] * self._per_s[best])
        )
        if promising and self._ticks < _MOST_TICKS:
            return Verdict.ASKING
        self._costs_m = None
        self.chosen = best
        return Verdict.NONE if best is None else Verdict.CHOSEN

    def _start(self, view: View) -> None:
        self._all_round_m2 = math.pi * self._coverage.sure_m**2
        self._costs_m = self._driver.costs_to(view, self._spots_m, self._limit_m)
        free = self._coverage.is_known_free(self._spots_m)
        self._candidates: NDArray[np.bool_] = free & np.isfinite(self._costs_m) & ~self._done
        way_m = np.minimum(self._costs_m, self._limit_m)
        self._per_s: FloatArray = 1.0 / (way_m / self._speed_mps + _STOP_S)
        self._asked: NDArray[np.bool_] = np.zeros(len(self._spots_m), dtype=np.bool_)
        self._ticks = 0
