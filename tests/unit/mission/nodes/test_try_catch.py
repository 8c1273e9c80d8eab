"""TryCatch, of BehaviorTree.CPP 4.9: the oracle does not have it, so all it does is written here."""

from __future__ import annotations

from tests.unit.mission.conftest import MakeTrace
from tests.unit.mission.scripted import spaced


def test_success_leaves_the_last_child_alone(trace: MakeTrace) -> None:
    assert trace("<TryCatch><A/><B/><C/></TryCatch>", A="S", B="RS", C="S").ticks(3) == spaced(
        "R A>S B>R", "S B:S", "R A>S B>R"
    )


def test_a_failure_ticks_the_last_child_at_once_and_is_the_result(trace: MakeTrace) -> None:
    for result in ("S", "F"):
        assert trace("<TryCatch><A/><B/><C/></TryCatch>", A="F", B="S", C=result).tick() == [
            "F",
            "A>F",
            f"C>{result}",
        ]


def test_the_last_child_is_ticked_until_it_ends(trace: MakeTrace) -> None:
    tree = trace("<TryCatch><A/><B/></TryCatch>", A="F", B="RRS")
    assert tree.ticks(4) == spaced("R A>F B>R", "R B:R", "F B:S", "R A>F B>R")


def test_it_goes_on_with_the_running_child(trace: MakeTrace) -> None:
    tree = trace("<TryCatch><A/><B/><C/></TryCatch>", A="S", B="RF", C="S")
    assert tree.ticks(2) == spaced("R A>S B>R", "F B:F C>S")


def test_skipped_children_count_as_none(trace: MakeTrace) -> None:
    tree = trace("<TryCatch><RunOnce><A/></RunOnce><B/><C/></TryCatch>", A="S", B="SF", C="S")
    assert tree.ticks(2) == spaced("S A>S B>S", "F B>F C>S")
    skipped = trace("<TryCatch><RunOnce><A/></RunOnce><C/></TryCatch>", A="S", C="S")
    assert skipped.ticks(2) == spaced("S A>S", "-")


def test_a_halt_is_no_failure(trace: MakeTrace) -> None:
    tree = trace("<TryCatch><A/><B/></TryCatch>", A="R", B="S")
    tree.tick()
    assert tree.halt() == ["A!"]
    assert tree.tick() == ["R", "A>R"]


def test_a_halt_can_be_caught_too(trace: MakeTrace) -> None:
    for result, rest in (("S", []), ("R", ["B!"])):
        tree = trace('<TryCatch catch_on_halt="true"><A/><B/></TryCatch>', A="R", B=result)
        tree.tick()
        assert tree.halt() == ["A!", f"B>{result}", *rest]
        assert tree.halt() == [], "it does not run any more"


def test_a_halt_while_it_catches_halts_the_last_child(trace: MakeTrace) -> None:
    tree = trace('<TryCatch catch_on_halt="true"><A/><B/></TryCatch>', A="FR", B="R")
    assert tree.tick() == ["R", "A>F", "B>R"]
    assert tree.halt() == ["B!"]
    assert tree.tick() == ["R", "A>R"]


def test_a_parent_that_moves_on_has_it_caught(trace: MakeTrace) -> None:
    tree = trace(
        '<ReactiveFallback><C/><TryCatch catch_on_halt="true"><A/><B/></TryCatch></ReactiveFallback>',
        A="R", B="S", C="FS",
    )  # fmt: skip
    assert tree.ticks(2) == spaced("R C>F A>R", "S C>S A! B>S")
