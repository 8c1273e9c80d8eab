"""IfThenElse and WhileDoElse."""

from __future__ import annotations

from pathlib import Path

import pytest
from py_trees.common import Status

from target_nav.errors import MissionError
from target_nav.mission.nodes import AlwaysSuccess, RunOnce, WhileDoElse
from tests.unit.mission.conftest import MakeTrace
from tests.unit.mission.scripted import spaced


def test_if_asks_once_and_stays_with_its_branch(trace: MakeTrace) -> None:
    expected = spaced(
        "R A>S B>R",
        "R B:R",
        "S B:S",
        "F A>F C>F",
    )
    assert trace("<IfThenElse><A/><B/><C/></IfThenElse>", A="SF", B="RRS", C="F").ticks(4) == expected


def test_if_without_else_fails_with_its_condition(trace: MakeTrace) -> None:
    assert trace("<IfThenElse><A/><B/></IfThenElse>", A="F", B="S").ticks(2) == spaced("F A>F", "F A>F")


def test_if_waits_for_a_running_condition(trace: MakeTrace) -> None:
    assert trace("<IfThenElse><A/><B/></IfThenElse>", A="RS", B="S").ticks(2) == spaced("R A>R", "S A:S B>S")


def test_a_halted_if_asks_again(trace: MakeTrace) -> None:
    tree = trace("<IfThenElse><A/><B/><C/></IfThenElse>", A="SF", B="R", C="R")
    assert tree.tick() == ["R", "A>S", "B>R"]
    assert tree.halt() == ["B!"]
    assert tree.tick() == ["R", "A>F", "C>R"]


def test_while_asks_in_every_tick_and_halts_the_other_branch_first(trace: MakeTrace) -> None:
    expected = spaced(
        "R A>S B>R",
        "R A>S B:R",
        "R A>F B! C>R",
        "R A>S C! B>R",
    )
    assert trace("<WhileDoElse><A/><B/><C/></WhileDoElse>", A="SSFS", B="R", C="R").ticks(4) == expected


def test_while_without_else_halts_its_branch_and_fails(trace: MakeTrace) -> None:
    assert trace("<WhileDoElse><A/><B/></WhileDoElse>", A="SF", B="R").ticks(2) == spaced(
        "R A>S B>R", "F A>F B!"
    )


def test_while_ends_with_its_branch(trace: MakeTrace) -> None:
    assert trace("<WhileDoElse><A/><B/></WhileDoElse>", A="S", B="RS").ticks(2) == spaced(
        "R A>S B>R", "S A>S B:S"
    )


def test_a_branch_is_left_running_while_the_condition_itself_runs(trace: MakeTrace) -> None:
    expected = spaced(
        "R A>S B>R",
        "R A>R",
        "R A:S B:R",
    )
    assert trace("<WhileDoElse><A/><B/></WhileDoElse>", A="SRS", B="R").ticks(3) == expected


def test_a_condition_that_is_skipped_decides_nothing(tmp_path: Path) -> None:
    # the check of a mission finds this before the first tick; see broken/condition_can_be_skipped.xml
    tree = WhileDoElse("while", [RunOnce("once", AlwaysSuccess("yes")), AlwaysSuccess("do")])
    tree.tick_once()
    assert tree.status is Status.SUCCESS
    with pytest.raises(MissionError, match="its condition 'once' was skipped"):
        tree.tick_once()
