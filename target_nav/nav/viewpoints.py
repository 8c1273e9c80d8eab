"""Where to look from next: the place that shows most unseen floor for the way to it.

Next best view by lazy greedy choice: what a place would show only grows less while the search goes on, so what it was
worth when it was last asked bounds what it is worth now, and only the most promising few have to be asked again
(Minoux, "Accelerated greedy algorithms", 1978). A bounded number is asked a tick.
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
        self._unbound()
        self._costs_m: FloatArray | None = None

    @property
    def place_m(self) -> tuple[float, float]:
        """The chosen place."""
        assert self.chosen is not None, "nothing is chosen"
        return float(self._spots_m[self.chosen, 0]), float(self._spots_m[self.chosen, 1])

    @property
    def left(self) -> int:
        return int(len(self._done) - np.count_nonzero(self._done))

    def finish(self, *, given_up: bool = False) -> None:
        """The chosen place was looked round from, is not worth it any more, or cannot be reached (`given_up`)."""
        if self.chosen is not None:
            self._done[self.chosen] = True
            self._given_up[self.chosen] |= given_up
        self.chosen = None

    def choose(self, view: View) -> Verdict:
        """Compare some more; call it each tick until it is not ASKING."""
        if self._costs_m is None:
            self._start(view)
        assert self._costs_m is not None
        self._ticks += 1
        open_ = np.flatnonzero(self._candidates & ~self._done)
        value = self._bound_m2[open_] * self._per_s[open_]
        order = open_[np.argsort(-value, kind="stable")]
        ask = order[~self._asked[order]][:_ASKED_A_TICK]
        if len(ask):
            gain = self._coverage.unseen_by_ray_m2(self._spots_m[ask]).sum(axis=1)
            self._bound_m2[ask], self._asked[ask] = gain, True
            self._done[ask[gain < self._least_m2]] = True
        asked = open_[self._asked[open_] & ~self._done[open_]]
        others = open_[~self._asked[open_]]
        if len(others) and self._ticks < _MOST_TICKS:
            promise = float((self._bound_m2[others] * self._per_s[others]).max())
            if not len(asked) or float((self._bound_m2[asked] * self._per_s[asked]).max()) < promise:
                return Verdict.ASKING
        self._costs_m = None
        if not len(asked):
            return Verdict.NONE
        self.chosen = int(asked[int(np.argmax(self._bound_m2[asked] * self._per_s[asked]))])
        return Verdict.CHOSEN

    def _start(self, view: View) -> None:
        if self._coverage.sure_m != self._bound_for_m:
            self._unbound()
        self._costs_m = self._driver.costs_to(view, self._spots_m, self._limit_m)
        self._candidates = self._coverage.is_known_free(self._spots_m) & np.isfinite(self._costs_m)
        self._per_s: FloatArray = 1.0 / (self._costs_m / self._speed_mps + _STOP_S)
        self._asked: NDArray[np.bool_] = np.zeros(len(self._spots_m), dtype=np.bool_)
        self._ticks = 0

    def _unbound(self) -> None:
        """Nothing is known of what the places show but that it is no more than all round."""
        self._bound_for_m = self._coverage.sure_m
        self._bound_m2: FloatArray = np.full(len(self._spots_m), math.pi * self._bound_for_m**2)
