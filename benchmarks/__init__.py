"""Measured costs of this project's parts beside named peers, in one run on one machine: `python -m benchmarks`.

A module `bench_<name>.py` in this package has `run() -> list[Row]`. Rows of one task belong together: the row called
`OURS` is the project's, every other one a peer, and the table gives each peer's ratio to it.
"""

from __future__ import annotations

import gc
import time
from collections.abc import Callable
from dataclasses import dataclass

OURS = "target_nav"


@dataclass(frozen=True)
class Row:
    """One measured number. `name` is `OURS` or the peer's; `note` says what the number does not."""

    task: str
    name: str
    value: float
    unit: str
    note: str = ""
    lower_is_better: bool = True


def time_call(function: Callable[[], object], budget_s: float = 0.4, batches: int = 15) -> float:
    """Time of one call in seconds: the best of some batches, so that other work on the machine counts least."""
    function()
    start_s = time.perf_counter()
    function()
    once_s = max(time.perf_counter() - start_s, 1e-7)
    calls = max(1, int(budget_s / batches / once_s))
    means = []
    collecting = gc.isenabled()
    gc.disable()
    try:
        for _ in range(batches):
            start_s = time.perf_counter()
            for _ in range(calls):
                function()
            means.append((time.perf_counter() - start_s) / calls)
    finally:
        if collecting:
            gc.enable()
    return min(means)
