"""WasEntryUpdated, SkipUnlessUpdated, WaitValueUpdate: writing counts, not changing."""

from __future__ import annotations

from pathlib import Path

import pytest
from py_trees.blackboard import Blackboard, Client
from py_trees.common import Access

from tests.unit.mission.scripted import Trace, spaced


def make(folder: Path, tree: str, **scripts: str) -> Trace:
    return Trace(folder, scripts, tree, provided=["/x"])


@pytest.mark.parametrize("entry", ["x", "{x}", "@x", "{@x}"])
def test_an_entry_was_updated(entry: str, tmp_path: Path) -> None:
    tree = make(tmp_path, f'<WasEntryUpdated entry="{entry}"/>')
    rows = [tree.tick()]
    for value in (1, None, 1, 1, None, 2):
        if value is not None:
            Blackboard.set("/x", value)
        rows.append(tree.tick())
    assert rows == spaced("F", "S", "F", "S", "S", "F", "S")


def test_what_was_there_before_is_an_update(tmp_path: Path) -> None:
    Blackboard.set("/x", 1)
    assert make(tmp_path, '<WasEntryUpdated entry="x"/>').ticks(2) == spaced("S", "F")


def test_each_node_looks_for_itself(tmp_path: Path) -> None:
    tree = make(
        tmp_path, '<ParallelAll><WasEntryUpdated entry="x"/><WasEntryUpdated entry="x"/></ParallelAll>'
    )
    Blackboard.set("/x", 1)
    assert tree.ticks(2) == spaced("S", "F")


def test_clients_and_scripts_write_too(tmp_path: Path) -> None:
    tree = make(
        tmp_path,
        """<Fallback><WasEntryUpdated entry="x"/><Inverter><A _post="x = 5"/></Inverter></Fallback>""",
        A="S",
    )
    client = Client(name="somebody")
    client.register_key(key="/x", access=Access.WRITE)
    client.set("/x", 1)
    assert tree.ticks(3) == spaced("S", "F A>S", "S")


def test_nothing_is_lost_when_an_entry_is_unset_and_written_again(tmp_path: Path) -> None:
    """BehaviorTree.CPP counts from the start again, and takes the first new value for the one it has seen."""
    tree = make(tmp_path, '<WasEntryUpdated entry="x"/>')
    Blackboard.set("/x", 1)
    tree.tick()
    Blackboard.unset("/x")
    assert tree.tick() == ["F"]
    Blackboard.set("/x", 1)
    assert tree.tick() == ["S"]


def test_skip_unless_updated(tmp_path: Path) -> None:
    expected = spaced("-", "R A>R", "R A:R", "S A:S", "-", "R A>R")
    tree = make(tmp_path, '<SkipUnlessUpdated entry="{x}"><A/></SkipUnlessUpdated>', A="RRS")
    rows = [tree.tick()]
    for value in (1, None, None, None, 2):
        if value is not None:
            Blackboard.set("/x", value)
        rows.append(tree.tick())
    assert rows == expected


def test_an_update_while_the_child_runs_counts_afterwards(tmp_path: Path) -> None:
    tree = make(tmp_path, '<WaitValueUpdate entry="{x}"><A/></WaitValueUpdate>', A="RS")
    Blackboard.set("/x", 1)
    assert tree.tick() == ["R", "A>R"]
    Blackboard.set("/x", 2)
    assert tree.ticks(2) == spaced("S A:S", "R A>R")


def test_wait_value_update(tmp_path: Path) -> None:
    tree = make(tmp_path, '<WaitValueUpdate entry="{x}"><A/></WaitValueUpdate>', A="S")
    assert tree.ticks(2) == spaced("R", "R")
    Blackboard.set("/x", 1)
    assert tree.ticks(2) == spaced("S A>S", "R")


@pytest.mark.parametrize("tag", ["SkipUnlessUpdated", "WaitValueUpdate"])
def test_a_halt_reaches_the_child(tag: str, tmp_path: Path) -> None:
    """BehaviorTree.CPP 4.8 forgets it, and the child goes on."""
    tree = make(tmp_path, f'<{tag} entry="{{x}}"><A/></{tag}>', A="R")
    Blackboard.set("/x", 1)
    assert tree.tick() == ["R", "A>R"]
    assert tree.halt() == ["A!"]
    Blackboard.set("/x", 1)
    assert tree.tick() == ["R", "A>R"]
