"""Timeout, Delay and Sleep on the mission's clock: ticks come with a time, and only ticks let time pass."""

from __future__ import annotations

import pytest
from py_trees.blackboard import Blackboard

from target_nav.errors import MissionError
from tests.unit.mission.conftest import MakeTrace
from tests.unit.mission.scripted import spaced


def test_timeout_halts_its_child_with_the_first_tick_that_is_late_enough(trace: MakeTrace) -> None:
    expected = spaced(
        "R A>R",
        "R A:R",
        "F A!",
        "R A>R",
    )
    tree = trace('<Timeout msec="1000"><A/></Timeout>', A="R")
    assert tree.ticks_at([5.0, 5.99, 6.0, 6.1]) == expected


def test_timeout_says_what_took_too_long(trace: MakeTrace) -> None:
    tree = trace('<Timeout msec="1500"><A name="looking"/></Timeout>', A="R")
    tree.ticks_at([0.0, 1.5])
    assert tree.root.feedback_message == "looking took longer than 1.5 s"


def test_timeout_does_not_come_before_a_result_in_time(trace: MakeTrace) -> None:
    assert trace('<Timeout msec="1000"><A/></Timeout>', A="RS").ticks_at([0.0, 0.9]) == spaced(
        "R A>R", "S A:S"
    )


def test_timeout_begins_anew_with_its_child(trace: MakeTrace) -> None:
    tree = trace('<Timeout msec="1000"><A/></Timeout>', A="RS")
    assert tree.ticks_at([0.0, 0.9, 1.5, 2.0]) == spaced("R A>R", "S A:S", "R A>R", "S A:S")


def test_timeout_that_was_halted_begins_anew(trace: MakeTrace) -> None:
    tree = trace('<Timeout msec="1000"><A/></Timeout>', A="R")
    tree.ticks_at([0.0, 0.9])
    assert tree.halt() == ["A!"]
    assert tree.ticks_at([1.5, 2.4, 2.5]) == spaced("R A>R", "R A:R", "F A!")


def test_timeout_of_zero_is_none(trace: MakeTrace) -> None:
    assert trace('<Timeout msec="0"><A/></Timeout>', A="R").ticks_at([0.0, 1e6]) == spaced("R A>R", "R A:R")


def test_twenty_ticks_of_a_twentieth_are_a_second(trace: MakeTrace) -> None:
    tree = trace('<Timeout msec="1000"><A/></Timeout>', A="R")
    now_s, times = 1234.5678, []
    for _ in range(21):
        times.append(now_s)
        now_s += 0.05
    rows = tree.ticks_at(times)
    assert [row[0] for row in rows] == ["R"] * 20 + ["F"]


def test_delay_waits_before_its_child(trace: MakeTrace) -> None:
    expected = spaced(
        "R",
        "R",
        "R A>R",
        "S A:S",
        "R",
    )
    tree = trace('<Delay delay_msec="500"><A/></Delay>', A="RS")
    assert tree.ticks_at([0.0, 0.4, 0.5, 0.6, 0.7]) == expected


def test_delay_that_was_halted_waits_again(trace: MakeTrace) -> None:
    tree = trace('<Delay delay_msec="500"><A/></Delay>', A="R")
    assert tree.ticks_at([0.0, 0.5]) == spaced("R", "R A>R")
    assert tree.halt() == ["A!"]
    assert tree.ticks_at([0.6, 1.0, 1.1]) == spaced("R", "R", "R A>R")


def test_sleep_waits_then_succeeds(trace: MakeTrace) -> None:
    expected = spaced("R", "R", "S A>S", "R")
    tree = trace('<Sequence><Sleep msec="500"/><A/></Sequence>', A="S")
    assert tree.ticks_at([0.0, 0.4, 0.5, 0.6]) == expected


def test_sleep_of_zero_succeeds_at_once(trace: MakeTrace) -> None:
    assert trace('<Sequence><Sleep msec="0"/><A/></Sequence>', A="S").tick(0.0) == ["S", "A>S"]


def test_a_halted_sleep_begins_anew(trace: MakeTrace) -> None:
    tree = trace('<Sequence><Sleep msec="500"/><A/></Sequence>', A="S")
    assert tree.tick(0.0) == ["R"]
    tree.halt()
    assert tree.ticks_at([0.4, 0.8, 0.9]) == spaced("R", "R", "S A>S")


def test_a_missing_clock_is_told(trace: MakeTrace) -> None:
    tree = trace('<Sleep msec="500"/>')
    Blackboard.unset("/clock/now_s")
    with pytest.raises(MissionError, match="Sleep: /clock/now_s is not on the blackboard"):
        tree.root.tick_once()
