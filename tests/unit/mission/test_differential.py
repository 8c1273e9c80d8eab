"""The same trees in BehaviorTree.CPP itself and here: results, order of calls and halts, tick by tick.

Needs `behaviortreepy` (BehaviorTree.CPP 4 with Python leaves, on PyPI) and is skipped without it. In its environment,
`TARGET_NAV_DIFFERENTIAL_TREES=10000` compares more trees.
"""

from __future__ import annotations

import os
import time
from collections.abc import Callable
from itertools import groupby
from pathlib import Path
from typing import Any

import pytest
from py_trees.blackboard import Blackboard

from target_nav.mission.nodes import halt
from tests.unit.mission.conftest import MakeTrace
from tests.unit.mission.oracle import Trial, first_difference, make_trial, run_here, run_there
from tests.unit.mission.scripted import document, set_clock

bt: Any = pytest.importorskip("behaviortreepy")

TREES = int(os.environ.get("TARGET_NAV_DIFFERENTIAL_TREES", "600"))
CHUNKS = 10


@pytest.mark.parametrize("chunk", range(CHUNKS))
def test_random_trees_do_the_same(chunk: int, tmp_path: Path) -> None:
    for seed in range(chunk * TREES // CHUNKS, (chunk + 1) * TREES // CHUNKS):
        Blackboard.clear()
        set_clock(0.0)
        trial = make_trial(seed)
        difference = first_difference(run_here(trial, tmp_path), run_there(trial, bt))
        assert not difference, f"seed {seed}: {difference}\n{trial.xml}\n{trial.scripts}"


def without_repetition(rows: list[str]) -> list[str]:
    """How often a waiting node was ticked depends on the machine."""
    return [row for row, _ in groupby(rows)]


def there_in_real_time(tree: str, scripts: dict[str, str], until: Callable[[list[str]], bool]) -> list[str]:
    status = {"S": bt.NodeStatus.SUCCESS, "F": bt.NodeStatus.FAILURE, "R": bt.NodeStatus.RUNNING}
    letter = {value: key for key, value in status.items()}
    log: list[str] = []
    factory = bt.BehaviorTreeFactory()
    for name, result in scripts.items():

        def call(node: Any, name: str = name, result: str = result) -> Any:
            log.append(f"{name}{result}")
            return status[result]

        factory.register_simple_stateful_action(
            name, call, call, lambda node, name=name: log.append(f"{name}!")
        )
    factory.register_behavior_tree_from_text(document(tree))
    root, rows, deadline_s = factory.create_tree("Main"), [], time.monotonic() + 20.0
    while not until(rows) and time.monotonic() < deadline_s:
        log.clear()
        time.sleep(0.005)
        rows.append(letter[root.tick_exactly_once()])
        rows[-1] = " ".join([rows[-1], *log])
    return without_repetition(rows)


@pytest.mark.parametrize(
    ("tree", "scripts"),
    [
        ('<Sequence><Sleep msec="40"/><A/></Sequence>', {"A": "S"}),
        ('<Delay delay_msec="40"><A/></Delay>', {"A": "F"}),
        ('<Sequence><Timeout msec="100000"><A/></Timeout><B/></Sequence>', {"A": "S", "B": "F"}),
    ],
)
def test_time_passes_alike(tree: str, scripts: dict[str, str], trace: MakeTrace) -> None:
    ours = trace(tree, **scripts)
    rows = []
    for tick in range(9):
        letter, *calls = ours.tick(0.005 * tick)
        rows.append(" ".join([letter, *(call.replace(">", "").replace(":", "") for call in calls)]))
        if letter != "R":
            break
    there = there_in_real_time(tree, scripts, lambda rows: bool(rows) and not rows[-1].startswith("R"))
    assert without_repetition(rows) == there


def test_timeout_fails_with_the_tick_after_its_child_was_halted(trace: MakeTrace) -> None:
    """There the timer halts the child between two ticks, here the tick does; both return FAILURE with that tick."""
    tree = '<Timeout msec="40"><A/></Timeout>'
    there = there_in_real_time(tree, {"A": "R"}, lambda rows: bool(rows) and rows[-1].startswith("F"))
    assert there in (["R AR", "F"], ["R AR", "F A!"])
    assert trace(tree, A="R").ticks_at([0.0, 0.04]) == [["R", "A>R"], ["F", "A!"]]


def test_the_one_difference_a_stateful_condition_is_asked_again_here(trace: MakeTrace) -> None:
    """There a stateful leaf that has ended keeps its result in WhileDoElse until the node ends."""
    trial = Trial(document("<WhileDoElse><A0/><A1/></WhileDoElse>"), {"A0": "SSF", "A1": "R"}, frozenset())
    assert run_there(trial, bt)[:3] == [["R", "A0>S", "A1>R"], ["R", "A1:R"], ["R", "A1:R"]]
    here = trace("<WhileDoElse><A0/><A1/></WhileDoElse>", A0="SSF", A1="R")
    assert here.ticks(3) == [["R", "A0>S", "A1>R"], ["R", "A0>S", "A1:R"], ["F", "A0>F", "A1!"]]
    halt(here.root)
