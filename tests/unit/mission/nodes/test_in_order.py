"""Sequence, Fallback, their Async kinds, SequenceWithMemory. A row: the root, then what was done to the leaves."""

from __future__ import annotations

from tests.unit.mission.conftest import MakeTrace
from tests.unit.mission.scripted import spaced


def test_sequence_goes_on_with_the_running_child(trace: MakeTrace) -> None:
    expected = spaced(
        "R A>S B>R",
        "R B:R",
        "S B:S C>S",
        "R A>S B>R",
    )
    assert trace("<Sequence><A/><B/><C/></Sequence>", A="S", B="RRS", C="S").ticks(4) == expected


def test_sequence_begins_again_after_failure(trace: MakeTrace) -> None:
    expected = spaced(
        "R A>S B>R",
        "F B:F",
        "R A>S B>R",
    )
    assert trace("<Sequence><A/><B/><C/></Sequence>", A="S", B="RF", C="S").ticks(3) == expected


def test_a_halted_sequence_halts_only_the_running_child_and_begins_again(trace: MakeTrace) -> None:
    tree = trace("<Sequence><A/><B/><C/></Sequence>", A="S", B="R", C="S")
    assert tree.tick() == ["R", "A>S", "B>R"]
    assert tree.halt() == ["B!"]
    assert tree.tick() == ["R", "A>S", "B>R"]


def test_a_finished_sequence_is_not_halted(trace: MakeTrace) -> None:
    tree = trace("<Sequence><A/><B/></Sequence>", A="S", B="F")
    assert tree.tick() == ["F", "A>S", "B>F"]
    assert tree.halt() == []


def test_fallback_goes_on_with_the_running_child(trace: MakeTrace) -> None:
    expected = spaced(
        "R A>F B>R",
        "F B:F C>F",
        "R A>F B>R",
    )
    assert trace("<Fallback><A/><B/><C/></Fallback>", A="F", B="RF", C="F").ticks(3) == expected


def test_fallback_ends_with_the_first_success_and_begins_again(trace: MakeTrace) -> None:
    expected = spaced(
        "S A>F B>S",
        "S A>F B>S",
    )
    assert trace("<Fallback><A/><B/><C/></Fallback>", A="F", B="S", C="S").ticks(2) == expected


def test_sequence_with_memory_goes_on_with_the_child_that_failed(trace: MakeTrace) -> None:
    expected = spaced(
        "R A>R",
        "R A:S B>R",
        "F B:F",
        "R B>R",
        "S B:S C>S",
        "R A>R",
    )
    tree = trace("<SequenceWithMemory><A/><B/><C/></SequenceWithMemory>", A="RS", B="RFRS", C="S")
    assert tree.ticks(6) == expected


def test_sequence_with_memory_ends_its_tick_after_a_child_that_succeeds_at_once(trace: MakeTrace) -> None:
    expected = spaced(
        "R A>S",
        "R B>S",
        "S C>S",
    )
    assert (
        trace("<SequenceWithMemory><A/><B/><C/></SequenceWithMemory>", A="S", B="S", C="S").ticks(3)
        == expected
    )


def test_sequence_with_memory_keeps_its_place_when_it_is_halted(trace: MakeTrace) -> None:
    tree = trace("<SequenceWithMemory><A/><B/></SequenceWithMemory>", A="S", B="R")
    assert tree.ticks(2) == spaced("R A>S", "R B>R")
    assert tree.halt() == ["B!"]
    assert tree.tick() == ["R", "B>R"]


def test_skipped_children_are_passed_over_and_only_a_node_with_nothing_else_is_skipped(
    trace: MakeTrace,
) -> None:
    once = "<RunOnce><A/></RunOnce>"
    expected = spaced(
        "S A>S B>S",
        "S B>S",
    )
    assert trace(f"<Sequence>{once}<B/></Sequence>", A="S", B="S").ticks(2) == expected
    assert trace(f"<Sequence>{once}{once}</Sequence>", A="S").ticks(2) == spaced("S A>S A>S", "-")
    assert trace(f"<Fallback>{once}<B/></Fallback>", A="F", B="F").ticks(2) == spaced("F A>F B>F", "F B>F")


def test_an_async_sequence_can_be_halted_between_its_children(trace: MakeTrace) -> None:
    """A child that ran for longer has given that chance before."""
    tree = trace("<AsyncSequence><A/><B/><C/></AsyncSequence>", A="S", B="RS", C="S")
    assert tree.ticks(5) == spaced("R A>S", "R B>R", "S B:S C>S", "R A>S", "R B>R")


def test_an_async_fallback_can_be_halted_between_its_children(trace: MakeTrace) -> None:
    tree = trace("<AsyncFallback><A/><B/></AsyncFallback>", A="F", B="F")
    assert tree.ticks(3) == spaced("R A>F", "F B>F", "R A>F")
    assert tree.halt() == []
    assert tree.tick() == ["R", "A>F"]


def test_skipped_children_do_not_stop_an_async_sequence(trace: MakeTrace) -> None:
    tree = trace("<AsyncSequence><RunOnce><A/></RunOnce><B/><C/></AsyncSequence>", A="S", B="S", C="S")
    assert tree.ticks(5) == spaced("R A>S", "R B>S", "S C>S", "R B>S", "S C>S")
