"""The BARN set's worlds as a campaign, judged as the set does: reached within 100 s, not collided, how fast."""

from __future__ import annotations

import math
import time
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from rich.table import Table

from target_nav.app.virtual import RunResult, run_virtual
from target_nav.sim.arena import load_arena
from target_nav.sim.arena_types import Goal
from target_nav.sim.barn import BarnName, barn_score, optimal_time_s

STARTED_M = 0.1
"""The set's clock starts when the robot has moved so far."""
PARTS = 4
"""The index rises with difficulty: the table has so many parts of the set."""


@dataclass(frozen=True)
class BarnRun:
    """`reached_s` is the time from the first movement to the goal's radius, by the truth; None: never."""

    name: BarnName
    result: RunResult
    reached_s: float | None
    best_s: float
    busy_s: float

    @property
    def succeeded(self) -> bool:
        return self.reached_s is not None and not self.result.collided

    @property
    def score(self) -> float:
        return barn_score(self.reached_s, self.best_s) if self.succeeded else 0.0

    def as_json(self) -> dict[str, Any]:
        """A campaign's line, by the set's own rules where they differ, and the set's figures."""
        line = self.result.as_json()
        line["success"] = line["as_expected"] = self.succeeded
        line["timeout"] = self.reached_s is None and not self.result.collided
        return line | {
            "world": self.name.index,
            "reached_s": self.reached_s,
            "best_s": self.best_s,
            "score": self.score,
        }


@dataclass(frozen=True)
class BarnOrder:
    name: BarnName
    seed: int
    mission: str


def execute(order: BarnOrder) -> BarnRun:
    arena = load_arena(str(order.name))
    assert arena.goal is not None
    begin_s = time.process_time()
    result = run_virtual(arena, Path(order.mission), order.seed)
    busy_s = time.process_time() - begin_s
    best_s = optimal_time_s(order.name)
    return BarnRun(order.name, result, reached_after_s(result.trace, arena.goal), best_s, busy_s)


def reached_after_s(trace: Sequence[Sequence[float]], goal: Goal) -> float | None:
    """From the first movement to the goal's radius; the moment it is crossed is interpolated. None: it never was."""
    path = np.asarray(trace, dtype=np.float64).reshape(-1, 4)
    if not len(path):
        return None
    moved = np.hypot(path[:, 1] - path[0, 1], path[:, 2] - path[0, 2]) >= STARTED_M
    away = np.hypot(path[:, 1] - goal.x_m, path[:, 2] - goal.y_m)
    there = np.flatnonzero(away <= goal.radius_m)
    if not len(there):
        return None
    at = int(there[0])
    start_s = float(path[max(int(moved.argmax()) - 1, 0), 0]) if moved.any() else float(path[0, 0])
    if at == 0:
        return 0.0
    share = (away[at - 1] - goal.radius_m) / max(away[at - 1] - away[at], 1e-9)
    return float(path[at - 1, 0] + share * (path[at, 0] - path[at - 1, 0])) - start_s


def barn_table(runs: Sequence[BarnRun], title: str) -> Table:
    """A row for each part of the set, easiest first, and one for all of it."""
    table = Table(
        title=title, caption="score: success * OT / clip(AT, 2 OT, 8 OT); 0.5 at most. A 2D simulation."
    )
    headings = (
        "worlds",
        "runs",
        "reached",
        "collided",
        "time-outs",
        "score",
        "time p50 / p95 [s]",
        "clearance p5 [mm]",
    )
    for heading in headings:
        table.add_column(heading, justify="right")
    worlds = sorted({run.name.index for run in runs})
    size = math.ceil(len(worlds) / PARTS)
    for begin in range(0, len(worlds), size):
        part = worlds[begin : begin + size]
        some = [run for run in runs if run.name.index in part]
        table.add_row(f"{part[0]} - {part[-1]}", *_cells(some))
    table.add_section()
    table.add_row("all", *_cells(runs), style="bold")
    return table


def _cells(runs: Sequence[BarnRun]) -> list[str]:
    good = [run.reached_s for run in runs if run.succeeded and run.reached_s is not None]
    times = f"{np.median(good):.1f} / {np.percentile(good, 95):.1f}" if good else "- / -"
    return [
        str(len(runs)),
        f"{len(good)} ({100.0 * len(good) / len(runs):.1f} %)",
        str(sum(run.result.collided for run in runs)),
        str(sum(run.reached_s is None and not run.result.collided for run in runs)),
        f"{np.mean([run.score for run in runs]):.4f}",
        times,
        f"{1e3 * np.percentile([run.result.min_clearance_m for run in runs], 5):.0f}",
    ]
