"""How sure a difference between two campaigns is: intervals for rates and for medians.

Rates: Wilson's score interval, and Newcombe's hybrid of two of them for a difference (Statistics in Medicine 17, 1998,
p. 857, methods 3 and 10; p. 873 for the unpaired). For runs that were made in pairs (the same arena, the same seed)
also the exact test of McNemar over the runs that went differently. Medians: percentile bootstrap; pairs are drawn
together.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from math import comb

import numpy as np

from target_nav.state.types import FloatArray

Z95 = 1.959964
DRAWS = 4000
SEED = 20240607
"""Of the bootstrap, so that the same campaigns compare the same."""


@dataclass(frozen=True)
class Interval:
    """`value` with its 95 % interval."""

    value: float
    low: float
    high: float

    @property
    def excludes_zero(self) -> bool:
        return self.low > 0.0 or self.high < 0.0


def wilson(good: int, runs: int) -> Interval:
    """The rate of `good` in `runs`; (nan, 0, 1) without runs."""
    if runs == 0:
        return Interval(math.nan, 0.0, 1.0)
    p, z2 = good / runs, Z95 * Z95
    middle = (p + z2 / (2 * runs)) / (1 + z2 / runs)
    half = Z95 / (1 + z2 / runs) * math.sqrt(p * (1 - p) / runs + z2 / (4 * runs * runs))
    return Interval(p, max(middle - half, 0.0), min(middle + half, 1.0))


def rate_difference(good_a: int, runs_a: int, good_b: int, runs_b: int) -> Interval:
    """Rate of B less rate of A, of runs that have nothing to do with each other."""
    a, b = wilson(good_a, runs_a), wilson(good_b, runs_b)
    change = b.value - a.value
    low = change - math.hypot(b.value - b.low, a.high - a.value)
    high = change + math.hypot(b.high - b.value, a.value - a.low)
    return Interval(change, low, high)


def paired_rate_difference(both: int, only_a: int, only_b: int, neither: int) -> Interval:
    """Rate of B less rate of A, of runs made in pairs: counts of pairs by which of the two went well."""
    runs = both + only_a + only_b + neither
    a, b = wilson(both + only_a, runs), wilson(both + only_b, runs)
    change = b.value - a.value
    # the correlation of the two, with Newcombe's correction for continuity
    margins = (both + only_a) * (only_b + neither) * (both + only_b) * (only_a + neither)
    surplus = float(both * neither - only_a * only_b)
    if surplus > 0.0:
        surplus = max(surplus - 0.5 * runs, 0.0)
    phi = surplus / math.sqrt(margins) if margins else 0.0

    def reach(one: float, other: float) -> float:
        return math.sqrt(max(one * one - 2 * phi * one * other + other * other, 0.0))

    low = change - reach(b.value - b.low, a.high - a.value)
    high = change + reach(b.high - b.value, a.value - a.low)
    return Interval(change, low, high)


def mcnemar_p(only_a: int, only_b: int) -> float:
    """How likely it is that runs which went differently are split at least so unevenly by chance (exact, two-sided)."""
    runs = only_a + only_b
    if runs == 0:
        return 1.0
    tail = sum(comb(runs, k) for k in range(min(only_a, only_b) + 1)) / 2**runs
    return min(2.0 * tail, 1.0)


def median_difference(a: FloatArray, b: FloatArray, paired: bool) -> Interval:
    """Median of B less median of A. `paired`: a[i] and b[i] belong together. Empty: nan."""
    if not len(a) or not len(b):
        return Interval(math.nan, math.nan, math.nan)
    rng = np.random.default_rng(SEED)
    draw: Callable[[], tuple[FloatArray, FloatArray]]
    if paired:

        def draw() -> tuple[FloatArray, FloatArray]:
            index = rng.integers(0, len(a), len(a))
            return a[index], b[index]
    else:

        def draw() -> tuple[FloatArray, FloatArray]:
            return a[rng.integers(0, len(a), len(a))], b[rng.integers(0, len(b), len(b))]

    changes = [float(np.median(y) - np.median(x)) for x, y in (draw() for _ in range(DRAWS))]
    low, high = np.percentile(changes, [2.5, 97.5])
    return Interval(float(np.median(b) - np.median(a)), float(low), float(high))
