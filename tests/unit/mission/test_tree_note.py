"""Notes of ticks: cheap to take, and a snapshot made of one later is the tree as it stood then."""

from __future__ import annotations

from contextlib import suppress
from pathlib import Path

import py_trees
import pytest

from target_nav.errors import MissionError
from target_nav.mission.nodes import halt
from target_nav.mission.snapshot_builder import SnapshotBuilder, ValueTexts
from target_nav.mission.snapshot_types import NO_ID
from target_nav.mission.tree_note import TreeNotebook
from tests.unit.mission.conftest import MakeTrace
from tests.unit.mission.oracle import load_here
from tests.unit.mission.random_trees import make_trial
from tests.unit.mission.scripted import set_clock
from tests.utils.snapshots import snapshot_of


@pytest.mark.parametrize("seed", range(40))
def test_a_snapshot_of_a_note_is_the_tree_as_it_stood_then(seed: int, tmp_path: Path) -> None:
    """What py_trees itself says of tips and current children, while the tree has gone on since."""
    trial = make_trial(seed, mixes=False)
    root, notebook, builder = load_here(trial, tmp_path, []), TreeNotebook(), SnapshotBuilder()
    expected, notes = [], []
    for tick in range(8):
        set_clock(0.05 * tick)
        with suppress(MissionError):  # a script of a random tree may fail
            root.tick_once()
        notes.append(notebook.note(root))
        expected.append(
            [
                (
                    node.id,
                    node.status.name,
                    node.feedback_message,
                    (tip.id if (tip := node.tip()) not in (None, node) else NO_ID),
                    getattr(node, "current_child", None),
                )
                for node in root.iterate()
            ]
        )
        if tick in trial.halts:
            halt(root)
    for note, wanted in zip(notes, expected, strict=True):
        shown = builder.build(note).behaviours
        assert [
            (each.own_id, each.status.name, each.message, each.tip_id, each.current_child_id)
            for each in shown
        ] == [(*rest, NO_ID if child is None else child.id) for *rest, child in wanted]


def test_a_note_has_the_values_of_its_tick(trace: MakeTrace) -> None:
    tree = trace('<Timeout msec="1000"><A/></Timeout>', A="R")
    builder, notebook = SnapshotBuilder(), TreeNotebook()
    notes = []
    for now_s in (0.5, 1.0):
        tree.tick(now_s)
        notes.append(notebook.note(tree.root, board=True))
    assert [builder.build(note).blackboard_on_visited_path for note in notes] == [
        (("/clock/now_s", "0.5"),),
        (("/clock/now_s", "1"),),
    ]
    assert builder.build(notebook.note(tree.root)).blackboard_on_visited_path == ()


def test_a_part_of_a_tree_that_py_trees_made_has_its_own_tips() -> None:
    leaf = py_trees.behaviours.Running("leaf")
    inner = py_trees.composites.Selector(
        "inner", memory=False, children=[py_trees.behaviours.Failure("no"), leaf]
    )
    root = py_trees.decorators.Inverter("root", inner)
    root.tick_once()
    shown = {each.name: each for each in snapshot_of(root).behaviours}
    assert shown["root"].tip_id == shown["inner"].tip_id == shown["leaf"].own_id
    assert shown["no"].tip_id == NO_ID


def test_texts_are_made_anew_only_for_other_objects() -> None:
    class Counted:
        times = 0

        def __str__(self) -> str:
            self.times += 1
            return f"text {self.times}"

    value, texts = Counted(), ValueTexts()
    assert [texts.of("/a", {"/a": value}) for _ in range(2)] == ["text 1", "text 1"]
    assert texts.of("/a", {"/a": Counted()}) == "text 1"
    assert texts.of("/b", {}) == "-"
    growing: list[int] = []
    assert texts.of("/c", {"/c": growing}) == "[]"
    growing.append(1)
    assert texts.of("/c", {"/c": growing}) == "[1]"
