"""Repeat, RetryUntilSuccessful, KeepRunningUntilFailure."""

from __future__ import annotations

from pathlib import Path

import pytest
from py_trees.blackboard import Blackboard

from target_nav.errors import MissionError
from target_nav.mission import NodeRegistry, load_mission
from tests.unit.mission.conftest import MakeTrace
from tests.unit.mission.scripted import document, scripted_leaves, spaced


def test_repeat_begins_a_child_that_ends_at_once_only_once_a_tick(trace: MakeTrace) -> None:
    assert trace('<Repeat num_cycles="3"><A/></Repeat>', A="S").ticks(4) == spaced(
        "R A>S", "R A>S", "S A>S", "R A>S"
    )


def test_repeat_goes_on_in_the_same_tick_after_a_child_that_took_longer(trace: MakeTrace) -> None:
    expected = spaced(
        "R A>R",
        "R A:S A>R",
        "S A:S",
    )
    assert trace('<Repeat num_cycles="2"><A/></Repeat>', A="RS").ticks(3) == expected


def test_repeat_fails_at_the_first_failure_and_counts_anew(trace: MakeTrace) -> None:
    expected = spaced("R A>S", "F A>F", "R A>S", "S A>S")
    assert trace('<Repeat num_cycles="2"><A/></Repeat>', A="SFSS").ticks(4) == expected


def test_a_halt_makes_repeat_count_anew(trace: MakeTrace) -> None:
    tree = trace('<Repeat num_cycles="2"><A/></Repeat>', A="S")
    assert tree.tick() == ["R", "A>S"]
    assert tree.halt() == []
    assert tree.ticks(2) == spaced("R A>S", "S A>S")


@pytest.mark.parametrize(("cycles", "expected"), [("0", "S"), ("-1", "R A>S")])
def test_repeat_never_and_for_ever(trace: MakeTrace, cycles: str, expected: str) -> None:
    tree = trace(f'<Repeat num_cycles="{cycles}"><A/></Repeat>', A="S")
    assert tree.ticks(20) == spaced(*[expected] * 20)


def test_retry_until_the_first_success(trace: MakeTrace) -> None:
    expected = spaced("R A>F", "S A>S", "R A>F")
    tree = trace('<RetryUntilSuccessful num_attempts="3"><A/></RetryUntilSuccessful>', A="FS")
    assert tree.ticks(3) == expected


def test_retry_gives_up_after_its_attempts(trace: MakeTrace) -> None:
    expected = spaced(
        "R A>R",
        "R A:F A>R",
        "F A:F",
        "R A>R",
    )
    tree = trace('<RetryUntilSuccessful num_attempts="2"><A/></RetryUntilSuccessful>', A="RF")
    assert tree.ticks(4) == expected


def test_retry_without_attempts_fails_without_a_try(trace: MakeTrace) -> None:
    assert trace('<RetryUntilSuccessful num_attempts="0"><A/></RetryUntilSuccessful>', A="S").tick() == ["F"]


def test_keep_running_until_failure(trace: MakeTrace) -> None:
    expected = spaced("R A>S", "R A>R", "R A:S", "F A>F", "R A>S")
    assert trace("<KeepRunningUntilFailure><A/></KeepRunningUntilFailure>", A="SRSF").ticks(5) == expected


def test_the_count_is_read_from_the_blackboard_in_every_tick(tmp_path: Path) -> None:
    path = tmp_path / "mission.xml"
    path.write_text(document('<Repeat num_cycles="{laps}"><A/></Repeat>'), encoding="utf-8")
    root = load_mission(path, NodeRegistry(scripted_leaves({"A": "S"}, [])), provided_keys=["/laps"]).root

    def tick_with(laps: object) -> str:
        Blackboard.set("/laps", laps)
        root.tick_once()
        return root.status.name

    assert [tick_with(3), tick_with(2), tick_with("2"), tick_with("2")] == [
        "RUNNING",
        "SUCCESS",
        "RUNNING",
        "SUCCESS",
    ]
    with pytest.raises(
        MissionError, match=r"mission.xml:1:\d+: error: Repeat: num_cycles read 'many' from /laps"
    ):
        tick_with("many")
    with pytest.raises(
        MissionError, match=r"num_cycles read -7 from /laps; it must lie in -1 ... 2147483647"
    ):
        tick_with(-7)
    Blackboard.unset("/laps")
    with pytest.raises(MissionError, match="num_cycles reads /laps, which nobody has written yet"):
        root.tick_once()
