"""Many runs in virtual time, spread over processes, told as JSON lines. Figures and tables: `campaign_table`."""

from __future__ import annotations

import json
import time
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TextIO

from target_nav.app.virtual import RunResult, run_virtual
from target_nav.sim.arena import load_arena
from target_nav.sim.generator import GeneratedName


@dataclass(frozen=True)
class RunOrder:
    """One run to be made. `arena` is a name or a path; `mission` a path."""

    arena: str
    seed: int
    mission: str
    with_trace: bool = False
    """Keep the true poses of a run that went well too; those of a failed one are kept for its picture."""
    pixels: bool = False
    """Look at rendered pictures instead of projected boxes."""


@dataclass(frozen=True)
class TimedResult:
    """`order` is what was asked for; `busy_s` the processor time it took, which is no part of the result."""

    order: RunOrder
    result: RunResult
    busy_s: float


def orders(
    arenas: Sequence[str],
    seeds: int,
    first_seed: int,
    mission: Path,
    with_trace: bool = False,
    pixels: bool = False,
) -> list[RunOrder]:
    """Each arena with each of `seeds` seeds."""
    return [
        RunOrder(arena, first_seed + k, str(mission), with_trace, pixels)
        for arena in arenas
        for k in range(seeds)
    ]


def generated_orders(
    count: int, seed: int, seeds: int, mission: Path, with_trace: bool = False, pixels: bool = False
) -> list[RunOrder]:
    """The first `count` arenas of a generator's seed. Each run has a seed, and so a noise, of its own."""
    return [
        RunOrder(
            str(GeneratedName(seed, number)), seed + number * seeds + k, str(mission), with_trace, pixels
        )
        for number in range(count)
        for k in range(seeds)
    ]


def execute(order: RunOrder) -> TimedResult:
    arena = load_arena(order.arena)
    begin_s = time.process_time()
    result = run_virtual(arena, Path(order.mission), order.seed, pixels=order.pixels)
    busy_s = time.process_time() - begin_s
    if result.as_expected and not order.with_trace:
        # a thousand traces are half a gigabyte
        result = replace(result, trace=())
    return TimedResult(order, result, busy_s)


def in_order(results: Iterable[TimedResult], todo: Sequence[RunOrder]) -> list[TimedResult]:
    """As they were ordered, whatever order they came in."""
    place = {order: index for index, order in enumerate(todo)}
    return sorted(results, key=lambda timed: place[timed.order])


class LinesInOrder:
    """One JSON line a run, in the order they were asked for, as soon as it is their turn.

    A campaign of an hour that is broken off leaves what it had.
    """

    def __init__(self, todo: Sequence[RunOrder], out: TextIO, traces: bool) -> None:
        self._todo, self._out, self._traces = list(todo), out, traces
        self._waiting: dict[RunOrder, RunResult] = {}
        self._next = 0

    def add(self, timed: TimedResult) -> None:
        self._waiting[timed.order] = timed.result
        while self._next < len(self._todo) and self._todo[self._next] in self._waiting:
            result = self._waiting.pop(self._todo[self._next])
            self._out.write(json.dumps(result.as_json(with_trace=self._traces), sort_keys=False) + "\n")
            self._next += 1
        self._out.flush()


def replay_command(order: RunOrder) -> str:
    """What makes the same run again, to be looked at."""
    mission = Path(order.mission)
    name = mission.stem if mission.parent.name == "trees" else order.mission
    flag = " --pixels" if order.pixels else ""
    return f"target-nav run --sim {order.arena} --virtual{flag} --seed {order.seed} --mission {name}"
