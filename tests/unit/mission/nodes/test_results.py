"""Inverter, ForceSuccess, ForceFailure, RunOnce, AlwaysSuccess, AlwaysFailure."""

from __future__ import annotations

import pytest

from target_nav.mission.nodes.ticking import SKIPPED_MESSAGE
from tests.unit.mission.conftest import MakeTrace
from tests.unit.mission.scripted import spaced


@pytest.mark.parametrize(
    ("decorator", "expected"),
    [
        ("Inverter", ["R A>R", "F A:S", "S A>F"]),
        ("ForceSuccess", ["R A>R", "S A:S", "S A>F"]),
        ("ForceFailure", ["R A>R", "F A:S", "F A>F"]),
    ],
)
def test_results_are_changed_but_not_running(trace: MakeTrace, decorator: str, expected: list[str]) -> None:
    assert trace(f"<{decorator}><A/></{decorator}>", A="RSF").ticks(3) == spaced(*expected)


@pytest.mark.parametrize("decorator", ["Inverter", "ForceSuccess", "ForceFailure"])
def test_a_skipped_child_skips_them(trace: MakeTrace, decorator: str) -> None:
    tree = trace(f"<{decorator}><RunOnce><A/></RunOnce></{decorator}>", A="S")
    tree.tick()
    assert tree.tick() == ["-"]


def test_halting_a_decorator_halts_its_running_child(trace: MakeTrace) -> None:
    tree = trace("<Inverter><A/></Inverter>", A="R")
    tree.tick()
    assert tree.halt() == ["A!"]


def test_run_once_is_skipped_after_its_first_result(trace: MakeTrace) -> None:
    tree = trace("<RunOnce><A/></RunOnce>", A="RF")
    assert tree.ticks(3) == spaced("R A>R", "F A:F", "-")
    assert tree.root.feedback_message == SKIPPED_MESSAGE


def test_run_once_can_repeat_its_first_result(trace: MakeTrace) -> None:
    assert trace('<RunOnce then_skip="false"><A/></RunOnce>', A="RF").ticks(3) == spaced(
        "R A>R", "F A:F", "F"
    )


def test_run_once_that_was_halted_before_its_result_runs_again(trace: MakeTrace) -> None:
    tree = trace("<RunOnce><A/></RunOnce>", A="RS")
    tree.tick()
    assert tree.halt() == ["A!"]
    assert tree.ticks(2) == spaced("S A>S", "-")


def test_always(trace: MakeTrace) -> None:
    tree = trace("<Sequence><AlwaysSuccess/><A/><AlwaysFailure/></Sequence>", A="S")
    assert tree.ticks(2) == spaced("F A>S", "F A>S")
