"""Parallel and ParallelAll."""

from __future__ import annotations

from pathlib import Path

import pytest
from py_trees.blackboard import Blackboard

from target_nav.errors import MissionError
from target_nav.mission import NodeRegistry, load_mission
from tests.unit.mission.conftest import MakeTrace
from tests.unit.mission.scripted import Trace, document, scripted_leaves, spaced


def test_by_default_all_must_succeed_and_finished_children_are_not_ticked_again(trace: MakeTrace) -> None:
    expected = spaced(
        "R A>S B>R C>R",
        "R B:S C:R",
        "S C:S",
        "R A>S B>R C>R",
    )
    assert trace("<Parallel><A/><B/><C/></Parallel>", A="S", B="RS", C="RRS").ticks(4) == expected


def test_by_default_one_failure_ends_it_and_halts_the_others(trace: MakeTrace) -> None:
    expected = spaced(
        "R A>R B>R",
        "F A:R B:F A!",
    )
    assert trace("<Parallel><A/><B/></Parallel>", A="R", B="RF").ticks(2) == expected


def test_it_ends_as_soon_as_enough_succeed_even_before_the_last_children_are_ticked(trace: MakeTrace) -> None:
    expected = spaced(
        "R A>R B>R C>R",
        "S A:R B:S A! C!",
    )
    tree = trace('<Parallel success_count="1"><A/><B/><C/></Parallel>', A="R", B="RS", C="R")
    assert tree.ticks(2) == expected


def test_it_fails_when_too_few_are_left_to_succeed(trace: MakeTrace) -> None:
    tree = trace('<Parallel success_count="2" failure_count="3"><A/><B/><C/></Parallel>', A="F", B="F", C="R")
    assert tree.tick() == ["F", "A>F", "B>F"]


def test_negative_counts_are_from_the_end(trace: MakeTrace) -> None:
    # -2 of three children: two of them
    tree = trace(
        '<Parallel success_count="-2" failure_count="-1"><A/><B/><C/></Parallel>', A="F", B="S", C="S"
    )
    assert tree.tick() == ["S", "A>F", "B>S", "C>S"]


def test_halting_halts_the_running_children_in_order_and_forgets_the_finished_ones(trace: MakeTrace) -> None:
    tree = trace("<Parallel><A/><B/><C/></Parallel>", A="R", B="S", C="R")
    assert tree.tick() == ["R", "A>R", "B>S", "C>R"]
    assert tree.halt() == ["A!", "C!"]
    assert tree.tick() == ["R", "A>R", "B>S", "C>R"]


def test_counts_from_the_blackboard_are_checked_when_they_are_read(tmp_path: Path) -> None:
    path = tmp_path / "mission.xml"
    path.write_text(document('<Parallel success_count="{enough}"><A/><A/></Parallel>'), encoding="utf-8")
    root = load_mission(path, NodeRegistry(scripted_leaves({"A": "R"}, [])), provided_keys=["/enough"]).root

    Blackboard.set("/enough", 3)
    with pytest.raises(MissionError, match="success_count is 3, but it has 2 children"):
        root.tick_once()


def test_parallel_all_ticks_all_until_all_have_ended(trace: MakeTrace) -> None:
    expected = spaced(
        "R A>F B>R C>S",
        "R B:R",
        "F B:S",
        "R A>F B>R C>S",
    )
    assert trace("<ParallelAll><A/><B/><C/></ParallelAll>", A="F", B="RRS", C="S").ticks(4) == expected


@pytest.mark.parametrize(("most", "letter"), [(0, "F"), (1, "F"), (2, "F"), (3, "S"), (-1, "S"), (-2, "F")])
def test_how_many_failures_make_parallel_all_fail(most: int, letter: str, trace: MakeTrace) -> None:
    tree = trace(f'<ParallelAll max_failures="{most}"><A/><B/><C/></ParallelAll>', A="F", B="S", C="F")
    assert tree.tick() == [letter, "A>F", "B>S", "C>F"]


def test_parallel_all_with_skipped_children(trace: MakeTrace) -> None:
    tree = trace("<ParallelAll><RunOnce><A/></RunOnce><RunOnce><B/></RunOnce></ParallelAll>", A="S", B="RS")
    assert tree.ticks(3) == spaced("R A>S B>R", "S B:S", "-")


def test_parallel_all_that_is_halted_begins_anew(trace: MakeTrace) -> None:
    tree = trace("<ParallelAll><A/><B/></ParallelAll>", A="F", B="R")
    tree.tick()
    assert tree.halt() == ["B!"]
    assert tree.tick() == ["R", "A>F", "B>R"]


def test_a_count_from_the_blackboard_that_is_too_high(tmp_path: Path) -> None:
    tree = Trace(tmp_path, {"A": "S"}, '<ParallelAll max_failures="{n}"><A/></ParallelAll>', provided=["/n"])
    Blackboard.set("/n", 2)
    with pytest.raises(MissionError, match="max_failures is 2, but it has 1 children"):
        tree.tick()
