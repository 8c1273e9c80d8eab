"""Switch2 to Switch6."""

from __future__ import annotations

from enum import Enum
from pathlib import Path

import pytest
from py_trees.blackboard import Blackboard

from target_nav.mission.nodes.switch import is_case
from tests.unit.mission.conftest import MakeTrace
from tests.unit.mission.scripted import Trace, spaced

TREE = """<Switch2 variable="{x}" case_1="1" case_2="two"><A/><B/><C/></Switch2>"""


class Mode(Enum):
    IDLE = 0
    DRIVE = 1


def ticks_with(tree: Trace, *values: object) -> list[list[str]]:
    rows = []
    for value in values:
        Blackboard.set("/x", value)
        rows.append(tree.tick())
    return rows


def test_the_case_decides_and_a_change_halts_the_other_child(tmp_path: Path) -> None:
    expected = spaced("R A>R", "R A:R", "R A! B>R", "R B! C>R", "R C! A>R")
    tree = Trace(tmp_path, {"A": "R", "B": "R", "C": "R"}, TREE, provided=["/x"])
    assert ticks_with(tree, 1, 1.0, "two", "three", 1) == expected


def test_without_a_value_it_is_the_last_child(tmp_path: Path) -> None:
    tree = Trace(tmp_path, {"A": "S", "B": "S", "C": "S"}, TREE, provided=["/x"])
    assert tree.tick() == ["S", "C>S"]


def test_a_result_is_the_childs_and_skips_pass_through(tmp_path: Path) -> None:
    tree = """<Switch2 variable="{x}" case_1="1" case_2="2"><A/><RunOnce><B/></RunOnce><C/></Switch2>"""
    trace = Trace(tmp_path, {"A": "F", "B": "S", "C": "S"}, tree, provided=["/x"])
    assert ticks_with(trace, 1, 2, 2, 3) == spaced("F A>F", "S B>S", "-", "S C>S")


def test_cases_can_be_entries_and_constants(tmp_path: Path) -> None:
    tree = """<Switch3 variable="{x}" case_1="{y}" case_2="DRIVE" case_3="true"><A/><B/><C/><D/></Switch3>"""
    trace = Trace(tmp_path, dict.fromkeys("ABCD", "S"), tree, provided=["/x", "/y"], enums={"DRIVE": 7})
    assert ticks_with(trace, 5)[0] == ["S", "D>S"], "{y} has no value"
    Blackboard.set("/y", 5)
    assert ticks_with(trace, 5, 7, Mode.DRIVE, True, False) == spaced(
        "S A>S", "S B>S", "S B>S", "S C>S", "S D>S"
    )


@pytest.mark.parametrize("cases", [4, 5, 6])
def test_more_cases(cases: int, trace: MakeTrace) -> None:
    said = "".join(f' case_{number}="{number}"' for number in range(1, cases + 1))
    children = "".join(f"<A{number}/>" for number in range(1, cases + 2))
    scripts = {f"A{number}": "S" for number in range(1, cases + 2)}
    switch = f"""<Switch{cases} variable="{{x}}"{said}>{children}</Switch{cases}>"""
    tree = trace(f"""<Sequence><Script code="x := {cases}"/>{switch}</Sequence>""", **scripts)
    assert tree.tick() == ["S", f"A{cases}>S"]


@pytest.mark.parametrize(
    ("value", "case", "same"),
    [
        ("a", "a", True),
        ("a", "b", False),
        (1, "1", True),
        (1.0, "1", True),
        (1.9, "1", False),
        ("1.0", "1", True),
        ("5a", "5", False),
        (0.1 + 0.2, "0.3", True),
        (True, "true", True),
        (True, "1", True),
        (False, "true", False),
        ("RED", "3", True),
        (3, "RED", True),
        (Mode.DRIVE, "DRIVE", True),
        (Mode.DRIVE, "1", True),
        ([1], "1", False),
    ],
)
def test_what_a_case_means(value: object, case: str, same: bool) -> None:
    assert is_case(value, case, {"RED": 3}) is same
