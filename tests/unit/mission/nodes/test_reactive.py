"""ReactiveSequence and ReactiveFallback."""

from __future__ import annotations

from tests.unit.mission.conftest import MakeTrace
from tests.unit.mission.scripted import spaced


def test_reactive_sequence_asks_the_first_children_again_and_halts_when_one_fails(trace: MakeTrace) -> None:
    expected = spaced(
        "R A>S B>R",
        "R A>S B:R",
        "F A>F B!",
        "R A>S B>R",
    )
    assert trace("<ReactiveSequence><A/><B/></ReactiveSequence>", A="SSFS", B="R").ticks(4) == expected


def test_a_running_child_halts_the_one_that_ran_after_it(trace: MakeTrace) -> None:
    expected = spaced(
        "R A>S B>S C>R",
        "R A>S B>R C!",
        "R A>S B:S C>R",
    )
    assert (
        trace("<ReactiveSequence><A/><B/><C/></ReactiveSequence>", A="S", B="SRS", C="R").ticks(3) == expected
    )


def test_the_new_child_begins_before_the_old_one_is_halted(trace: MakeTrace) -> None:
    expected = spaced(
        "R A>F B>R",
        "R A>R B!",
    )
    assert trace("<ReactiveFallback><A/><B/></ReactiveFallback>", A="FR", B="R").ticks(2) == expected


def test_reactive_fallback_halts_when_a_child_before_succeeds(trace: MakeTrace) -> None:
    expected = spaced(
        "R A>F B>R",
        "S A>S B!",
        "R A>F B>R",
        "F A>F B:F",
    )
    assert trace("<ReactiveFallback><A/><B/></ReactiveFallback>", A="FSFF", B="RRF").ticks(4) == expected


def test_halting_reaches_the_running_leaf_of_a_nested_node(trace: MakeTrace) -> None:
    tree = trace(
        "<ReactiveSequence><A/><Sequence><B/><C/></Sequence></ReactiveSequence>", A="SF", B="S", C="R"
    )
    assert tree.ticks(2) == spaced("R A>S B>S C>R", "F A>F C!")
