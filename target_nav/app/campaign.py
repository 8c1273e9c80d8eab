"""Many runs in virtual time, spread over processes, told as a table and as JSON lines."""

from __future__ import annotations

import json
import multiprocessing
from collections.abc import Iterable, Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor, as_completed
from dataclasses import dataclass
from pathlib import Path
from typing import TextIO

import numpy as np
from rich.table import Table

from target_nav.app.virtual import RunResult, run_virtual
from target_nav.sim.arena import load_arena


@dataclass(frozen=True)
class RunOrder:
    """One run to be made. `arena` is a name or a path; `mission` a path."""

    arena: str
    seed: int
    mission: str
    pixels: bool = False


def orders(
    arenas: Sequence[str], seeds: int, first_seed: int, mission: Path, pixels: bool = False
) -> list[RunOrder]:
    return [RunOrder(arena, first_seed + k, str(mission), pixels) for arena in arenas for k in range(seeds)]


def execute(order: RunOrder) -> RunResult:
    return run_virtual(load_arena(order.arena), Path(order.mission), order.seed, pixels=order.pixels)


def run_all(todo: Sequence[RunOrder], jobs: int) -> Iterator[RunResult]:
    """Results as they come, in no order. One process a job: py_trees keeps one blackboard a process."""
    if jobs <= 1:
        yield from map(execute, todo)
        return
    # spawned, not forked: a worker must not inherit threads or an open ROS context
    with ProcessPoolExecutor(jobs, mp_context=multiprocessing.get_context("spawn")) as pool:
        for done in as_completed([pool.submit(execute, order) for order in todo]):
            yield done.result()


def write_json_lines(results: Iterable[RunResult], out: TextIO, traces: bool) -> None:
    for result in sorted(results, key=lambda r: (r.arena, r.seed)):
        out.write(json.dumps(result.as_json(with_trace=traces), sort_keys=False) + "\n")


def table_of(results: Sequence[RunResult]) -> Table:
    """One row an arena and one for all of it."""
    table = Table(title="campaign", caption="stop error and bearing error of runs that arrived")
    for column in ("arena", "runs", "as expected", "collided", "time-outs"):
        table.add_column(column, justify="left" if column == "arena" else "right")
    for column in ("stop error p50 / p95", "bearing p95", "time p50", "least clearance"):
        table.add_column(column, justify="right")
    groups: dict[str, list[RunResult]] = {}
    for result in results:
        groups.setdefault(result.arena, []).append(result)
    for name in sorted(groups):
        table.add_row(name, *_figures(groups[name]))
    table.add_section()
    table.add_row("all", *_figures(list(results)), style="bold")
    return table


def _figures(runs: list[RunResult]) -> list[str]:
    stops = np.abs([r.stop_error_m for r in runs if r.success and r.stop_error_m is not None])
    bearings = np.abs([r.bearing_error_rad for r in runs if r.success and r.bearing_error_rad is not None])
    good = sum(r.as_expected for r in runs)
    return [
        str(len(runs)),
        f"{good} ({100.0 * good / len(runs):.1f} %)",
        str(sum(r.collided for r in runs)),
        str(sum(r.timeout for r in runs)),
        f"{1e3 * np.median(stops):.0f} / {1e3 * np.percentile(stops, 95):.0f} mm" if stops.size else "-",
        f"{np.degrees(np.percentile(bearings, 95)):.1f} deg" if bearings.size else "-",
        f"{np.median([r.time_s for r in runs]):.1f} s",
        f"{1e3 * min(r.min_clearance_m for r in runs):.0f} mm",
    ]
