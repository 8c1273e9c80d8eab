"""The same missions in BehaviorTree.CPP itself and here: results, calls and halts, the blackboard, tick by tick.

Needs `behaviortreepy` (BehaviorTree.CPP 4 with Python leaves, on PyPI) and is skipped without it.
`TARGET_NAV_DIFFERENTIAL_TREES=10000` compares more trees,
`TARGET_NAV_DIFFERENTIAL_SEED=500000` others. What differs on purpose is in docs/mission-language.md, and
below, so that a BehaviorTree.CPP that changes its mind is noticed.
"""

from __future__ import annotations

import os
import random
import time
from collections.abc import Callable
from itertools import groupby
from pathlib import Path
from typing import Any
from xml.sax.saxutils import quoteattr

import pytest
from py_trees.blackboard import Blackboard

from target_nav.errors import MissionError
from target_nav.mission.nodes import halt
from target_nav.mission.script import ScriptError, parse_script
from tests.unit.mission.conftest import MakeTrace
from tests.unit.mission.oracle import Row, first_difference, run_here, run_there
from tests.unit.mission.random_trees import Trial, make_trial
from tests.unit.mission.scripted import document, set_clock

bt: Any = pytest.importorskip("behaviortreepy")

TREES = int(os.environ.get("TARGET_NAV_DIFFERENTIAL_TREES", "600"))
FIRST_SEED = int(os.environ.get("TARGET_NAV_DIFFERENTIAL_SEED", "0"))
CHUNKS = 10


@pytest.mark.timeout(max(120, TREES // 10))
@pytest.mark.parametrize("chunk", range(CHUNKS))
def test_random_trees_do_the_same(chunk: int, tmp_path: Path) -> None:
    for number in range(chunk * TREES // CHUNKS, (chunk + 1) * TREES // CHUNKS):
        seed = FIRST_SEED + number
        Blackboard.clear()
        set_clock(0.0)
        trial = make_trial(seed)
        difference = first_difference(run_here(trial, tmp_path), run_there(trial, bt))
        assert not difference, f"seed {seed}: {difference}\n{trial.xml}\n{trial.scripts}\n{trial.writes}"


PIECES = (
    "x", "y1", "_z", "@x", "1", "2.5", "1e3", "0x1F", "'a'", '"b"', "true", "(", ")", "?", ":", ";", ":=", "=", "+=",
    "==", "!=", "<", ">=", "+", "-", "*", "/", "..", "&", "|", "^", "~", "!", "&&", "||", " ", " ", "\n", ".", "#",
    "truth",
)  # fmt: skip


def is_script_there(text: str) -> bool:
    """Whether BehaviorTree.CPP makes a tree with it."""
    factory = bt.BehaviorTreeFactory()
    code = quoteattr(text, {"\n": "&#10;"})
    try:
        factory.create_tree_from_text(document(f"<Script code={code}/>"))
    except RuntimeError:
        return False
    return True


def refusal(text: str) -> str:
    """Why a text is no script here."""
    try:
        parse_script(text)
    except ScriptError as error:
        return error.message
    return ""


def test_random_texts_are_scripts_alike() -> None:
    rng = random.Random(1)
    accepted = 0
    for _ in range(3000):
        text = "".join(rng.choices(PIECES, k=rng.randint(1, 8)))
        refused = refusal(text)
        # There, that is noticed when it runs.
        if "must be the name of an entry" not in refused:
            assert is_script_there(text) is not bool(refused), f"{text!r}: {refused}"
        accepted += not refused
    assert accepted > 100


# -- time ----------------------------------------------------------------------------------------------------


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


# -- what differs on purpose ---------------------------------------------------------------------------------


def calls(rows: list[Row]) -> list[Row]:
    """Without what the blackboard holds."""
    return [[word for word in row if "=" not in word] for row in rows]


def value_there(script: str, name: str) -> str:
    factory = bt.BehaviorTreeFactory()
    entries = bt.Blackboard.create()
    tree = factory.create_tree_from_text(document(f"<Script code={quoteattr(script)}/>"), entries)
    tree.tick_exactly_once()
    text: str = entries.get_string(name)
    return text


def both(
    folder: Path, tree: str, scripts: dict[str, str], writes: dict[str, tuple[str, int]] | None = None
) -> tuple[list[Row], list[Row]]:
    """The calls here and there; here with the differences that the random trees do without."""
    set_clock(0.0)
    trial = Trial(document(tree), scripts, writes or {}, frozenset())
    return calls(run_here(trial, folder, as_there=False)), calls(run_there(trial, bt))


def test_a_stateful_condition_is_asked_again(trace: MakeTrace) -> None:
    """There a stateful leaf that has ended keeps its result in WhileDoElse until the node ends."""
    trial = Trial(
        document("<WhileDoElse><A0/><A1/></WhileDoElse>"), {"A0": "SSF", "A1": "R"}, {}, frozenset()
    )
    assert calls(run_there(trial, bt))[:3] == [["R", "A0>S", "A1>R"], ["R", "A1:R"], ["R", "A1:R"]]
    here = trace("<WhileDoElse><A0/><A1/></WhileDoElse>", A0="SSF", A1="R")
    assert here.ticks(3) == [["R", "A0>S", "A1>R"], ["R", "A0>S", "A1:R"], ["F", "A0>F", "A1!"]]
    halt(here.root)


def test_a_precondition_is_asked_again_after_a_halt(tmp_path: Path) -> None:
    tree = (
        """<ReactiveSequence><C0/><Precondition if="i0 == 1"><A1/></Precondition><C2/></ReactiveSequence>"""
    )
    tree = f"""<Sequence><ForceSuccess>{tree}</ForceSuccess><Script code="i0 := 2"/></Sequence>"""
    here, there = both(tmp_path, tree, {"C0": "SFS", "A1": "R", "C2": "S"})
    assert here[:3] == [["R", "C0:S", "A1>R"], ["S", "C0:F", "A1!"], ["S", "C0:S"]]
    assert there[:3] == [["R", "C0:S", "A1>R"], ["S", "C0:F", "A1!"], ["R", "C0:S", "A1>R"]]


def test_a_halt_reaches_the_child_of_skip_unless_updated(tmp_path: Path) -> None:
    tree = """<ReactiveSequence><C0/><SkipUnlessUpdated entry="i0"><A1/></SkipUnlessUpdated></ReactiveSequence>"""
    here, there = both(tmp_path, tree, {"C0": "SF", "A1": "R"})
    assert here[:2] == [["R", "C0:S", "A1>R"], ["F", "C0:F", "A1!"]]
    assert there[:2] == [["R", "C0:S", "A1>R"], ["F", "C0:F"]]


def test_a_count_that_falls_halts_the_child(tmp_path: Path) -> None:
    tree = """<Repeat num_cycles="{p0}"><Sequence><Script code="p0 := 0"/><A0/></Sequence></Repeat>"""
    here, there = both(tmp_path, tree, {"A0": "R"})
    assert here[:2] == [["R", "A0>R"], ["S", "A0!"]]
    assert there[:2] == [["R", "A0>R"], ["S"]]


def test_an_entry_that_was_unset_and_written_again_is_updated(tmp_path: Path) -> None:
    tree = """<Sequence><ForceSuccess><WasEntryUpdated entry="x0" _onSuccess="i0 += 1"/></ForceSuccess>
        <UnsetBlackboard key="x0"/><Script code="x0 := 1"/></Sequence>"""
    trial = Trial(document(tree), {}, {}, frozenset())
    assert "i0=12" in run_here(trial, tmp_path)[-1]
    assert "i0=2" in run_there(trial, bt)[-1]


@pytest.mark.parametrize(
    ("script", "there", "here"),
    [
        ("x := 10 - 3 - 2", "9.000000", "5.000000"),
        ("x := 100 / 10 * 5", "2.000000", "50.000000"),
        ("x := 1; x = '1.5abc'", "1.500000", None),
        ("x := 1; x = 'inf'", "inf", None),
    ],
)
def test_scripts(script: str, there: str, here: str | None, trace: MakeTrace) -> None:
    assert value_there(script, "x") == there
    tree = trace(f"<Script code={quoteattr(script)}/>")
    if here is None:
        with pytest.raises(MissionError, match="is no number"):
            tree.tick()
    else:
        tree.tick()
        assert f"{Blackboard.get('/x'):f}" == here


def test_a_case_is_not_matched_by_the_beginning_of_a_text(tmp_path: Path) -> None:
    tree = """<Sequence><Script code="v0 := '5a'"/>
        <Switch2 variable="{v0}" case_1="5" case_2="x"><C0/><C1/><C2/></Switch2></Sequence>"""
    here, there = both(tmp_path, tree, {"C0": "S", "C1": "S", "C2": "S"})
    assert (here[0], there[0]) == (["S", "C2:S"], ["S", "C0:S"])


def test_set_blackboard_replaces_what_a_script_made(tmp_path: Path) -> None:
    tree = """<Sequence><Script code="s0 := 1"/><SetBlackboard output_key="s0" value="5"/></Sequence>"""
    trial = Trial(document(tree), {}, {}, frozenset())
    assert "s0=5" in run_here(trial, tmp_path)[0]
    assert not [word for word in run_there(trial, bt)[0] if word.startswith("s0")], "it is empty"


def test_unset_goes_through_remapping(tmp_path: Path) -> None:
    inner = """<BehaviorTree ID="T0"><UnsetBlackboard key="x0"/></BehaviorTree>"""
    tree = """<Sequence><Script code="x0 := 1"/><SubTree ID="T0" x0="{x0}"/></Sequence>"""
    trial = Trial(document(tree, inner), {}, {}, frozenset())
    assert not [word for word in run_here(trial, tmp_path)[0] if word.startswith("x0")]
    assert "x0=1" in run_there(trial, bt)[0]


def test_halting_a_tree_tells_only_what_ran(tmp_path: Path) -> None:
    tree = """<Sequence><A0 _onHalted="i0 += 1"/><A1 _onHalted="i1 += 1"/></Sequence>"""
    trial = Trial(document(tree), {"A0": "S", "A1": "R"}, {}, frozenset([0]))
    set_clock(0.0)
    assert {"i0=1", "i1=4"} <= set(run_here(trial, tmp_path)[1])
    assert {"i0=2", "i1=5"} <= set(run_there(trial, bt)[1])


def test_a_port_gives_its_entry_its_type(tmp_path: Path) -> None:
    tree = """<Sequence><Script code="x1 := 2.0; t0 := 'a' .. x1"/>
        <Repeat num_cycles="{x1}"><C0/></Repeat></Sequence>"""
    trial = Trial(document(tree), {"C0": "R"}, {}, frozenset())
    assert "t0=a2" in run_here(trial, tmp_path)[0]
    assert "t0=a2.000000" in run_there(trial, bt)[0]


def test_explicit_forms_may_stand_in_a_reactive_sequence(trace: MakeTrace) -> None:
    tree = """<ReactiveSequence><Condition ID="AlwaysSuccess"/></ReactiveSequence>"""
    with pytest.raises(RuntimeError, match="Unknown node type: Condition"):
        bt.BehaviorTreeFactory().create_tree_from_text(document(tree))
    assert trace(tree).tick() == ["S"]


def test_an_argument_can_be_a_key_of_the_main_tree(trace: MakeTrace) -> None:
    inner = """<BehaviorTree ID="T"><Script code="x := 1"/></BehaviorTree>"""
    there = bt.BehaviorTreeFactory().create_tree_from_text(document('<SubTree ID="T" x="{@q}"/>', inner))
    with pytest.raises(RuntimeError, match="Bug: report"):
        there.tick_exactly_once()
    trace('<SubTree ID="T" x="{@q}"/>', inner).tick()
    assert Blackboard.get("/q") == 1
