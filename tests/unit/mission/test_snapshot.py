"""Snapshots keep what `py-trees-tree-watcher` insists on, and changes are noticed."""

from __future__ import annotations

from contextlib import suppress
from pathlib import Path

import py_trees
import pytest
from py_trees.blackboard import Blackboard
from py_trees.common import Status

from target_nav.errors import MissionError
from target_nav.mission.nodes import halt
from target_nav.mission.snapshot_types import (
    NO_ID,
    BehaviourSnapshot,
    BehaviourType,
    StatusCode,
    TreeSnapshot,
)
from target_nav.mission.tree_note import TreeNotebook
from target_nav.mission.values_text import MAX_TEXT
from tests.unit.mission.conftest import MakeTrace
from tests.unit.mission.oracle import load_here
from tests.unit.mission.random_trees import make_trial
from tests.unit.mission.scripted import set_clock
from tests.utils.snapshots import snapshot_of

EVERY_NODE = (
    """<ReactiveFallback>
  <Sequence name="first"><A/><SubTree ID="T"/></Sequence>
  <SequenceWithMemory><A/></SequenceWithMemory>
  <IfThenElse><A/><A/><A/></IfThenElse>
  <WhileDoElse><A/><A/></WhileDoElse>
  <Parallel><Timeout msec="100"><A/></Timeout><Repeat num_cycles="2"><RunOnce><A/></RunOnce></Repeat></Parallel>
  <ReactiveSequence><Sleep msec="1"/></ReactiveSequence>
</ReactiveFallback>""",
    '<BehaviorTree ID="T"><Fallback><A/><AlwaysFailure/></Fallback></BehaviorTree>',
)


def by_name(snapshot: TreeSnapshot) -> dict[str, BehaviourSnapshot]:
    return {each.name: each for each in snapshot.behaviours}


def insisted_on(snapshot: TreeSnapshot) -> None:
    """What py_trees_ros' watcher stops on."""
    ids = [each.own_id for each in snapshot.behaviours]
    assert len(set(ids)) == len(ids)
    assert [each.parent_id for each in snapshot.behaviours].count(NO_ID) == 1
    for each in snapshot.behaviours:
        assert each.own_id.version == 4
        assert each.parent_id in (NO_ID, *ids)
        assert each.type in (1, 2, 3, 4, 6)
        assert each.status in (1, 2, 3, 4)
        assert each.blackbox_level in (1, 2, 3, 4)
        assert set(each.child_ids) <= set(ids)
        assert each.tip_id in (NO_ID, *ids)
        assert each.current_child_id in (NO_ID, *each.child_ids)
        assert all(
            isinstance(text, str)
            for text in (each.name, each.class_name, each.message, each.additional_detail)
        )
        if each.type == BehaviourType.DECORATOR:
            assert len(each.child_ids) == 1
        if each.type == BehaviourType.BEHAVIOUR:
            assert each.child_ids == ()
        parents = [other for other in snapshot.behaviours if each.own_id in other.child_ids]
        assert [parent.own_id for parent in parents] == ([] if each.parent_id == NO_ID else [each.parent_id])


def test_of_a_tree_that_was_never_ticked(trace: MakeTrace) -> None:
    snapshot = snapshot_of(trace(*EVERY_NODE, A="S").root)
    insisted_on(snapshot)
    assert {each.status for each in snapshot.behaviours} == {StatusCode.INVALID}
    assert not any(each.is_active for each in snapshot.behaviours)


@pytest.mark.parametrize("seed", range(40))
def test_of_random_trees_in_every_tick(seed: int, tmp_path: Path) -> None:
    trial = make_trial(seed, mixes=False)
    root = load_here(trial, tmp_path, [])
    for tick in range(8):
        set_clock(0.05 * tick)
        # A script of a random tree may fail.
        with suppress(MissionError):
            root.tick_once()
        insisted_on(snapshot_of(root, blackboard_data=True))
        if tick in trial.halts:
            halt(root)
            insisted_on(snapshot_of(root))


def test_types_and_memory(trace: MakeTrace) -> None:
    snapshot = by_name(snapshot_of(trace(*EVERY_NODE, A="S").root))
    kinds = {name: (each.type.name, each.additional_detail) for name, each in snapshot.items()}
    assert kinds == {
        "ReactiveFallback": ("SELECTOR", ""),
        "first": ("SEQUENCE", "WithMemory"),
        "SequenceWithMemory": ("SEQUENCE", "WithMemory"),
        "ReactiveSequence": ("SEQUENCE", ""),
        "Fallback": ("SELECTOR", "WithMemory"),
        "IfThenElse": ("SELECTOR", "WithMemory"),
        "WhileDoElse": ("SELECTOR", ""),
        "Parallel": ("PARALLEL", "OnAll"),
        "T": ("DECORATOR", ""),
        "Timeout": ("DECORATOR", ""),
        "Repeat": ("DECORATOR", ""),
        "RunOnce": ("DECORATOR", ""),
        "A": ("BEHAVIOUR", ""),
        "AlwaysFailure": ("BEHAVIOUR", ""),
        "Sleep": ("BEHAVIOUR", ""),
    }
    assert snapshot["first"].class_name == "target_nav.mission.nodes.in_order.Sequence"
    assert {each.blackbox_level for each in snapshot.values()} == {4}


def test_statuses_activity_tip_and_current_child(trace: MakeTrace) -> None:
    tree = trace("<Fallback><A/><Sequence><B/><C/></Sequence><D/></Fallback>", A="F", B="S", C="R", D="S")
    tree.tick()
    shown = by_name(snapshot_of(tree.root))
    assert {name: (each.status.name, each.is_active) for name, each in shown.items()} == {
        "A": ("FAILURE", True),
        "B": ("SUCCESS", True),
        "C": ("RUNNING", True),
        "Sequence": ("RUNNING", True),
        "D": ("INVALID", False),
        "Fallback": ("RUNNING", True),
    }
    assert shown["Fallback"].tip_id == shown["Sequence"].tip_id == shown["C"].own_id
    assert shown["C"].tip_id == NO_ID
    assert shown["Fallback"].current_child_id == shown["Sequence"].own_id

    tree.tick()
    assert {name for name, each in by_name(snapshot_of(tree.root)).items() if each.is_active} == {
        "Fallback",
        "Sequence",
        "C",
    }


def test_a_skipped_node_is_invalid_with_a_message(trace: MakeTrace) -> None:
    tree = trace("<Sequence><RunOnce><A/></RunOnce><B/></Sequence>", A="S", B="S")
    tree.tick()
    assert by_name(snapshot_of(tree.root))["RunOnce"].message == ""
    tree.tick()
    skipped = by_name(snapshot_of(tree.root))["RunOnce"]
    assert (skipped.status, skipped.message, skipped.is_active) == (StatusCode.INVALID, "skipped", True)


def test_a_part_of_a_tree_is_shown_as_a_tree(trace: MakeTrace) -> None:
    tree = trace("<Fallback><Sequence><A/></Sequence></Fallback>", A="R")
    tree.tick()
    part = snapshot_of(tree.root.children[0])
    insisted_on(part)
    assert [each.name for each in part.behaviours] == ["A", "Sequence"]


def test_any_py_trees_tree_can_be_shown() -> None:
    root = py_trees.composites.Sequence(
        "root", memory=False, children=[py_trees.behaviours.Success("a"), py_trees.behaviours.Running("b")]
    )
    root.tick_once()
    snapshot = snapshot_of(root)
    insisted_on(snapshot)
    assert {each.name for each in snapshot.behaviours if each.is_active} == {"a", "b", "root"}


def test_blackboard_access_values_and_activity(trace: MakeTrace) -> None:
    tree = trace('<Sequence><Timeout msec="100"><A/></Timeout><Sleep msec="1"/></Sequence>', A="R")
    set_clock(1.5)
    Blackboard.enable_activity_stream()
    tree.root.tick_once()
    snapshot = snapshot_of(tree.root, blackboard_data=True, blackboard_activity=True)
    assert by_name(snapshot)["Timeout"].blackboard_access == (("/clock/now_s", "r"),)
    assert snapshot.blackboard_on_visited_path == (("/clock/now_s", "1.5"),)
    (read,) = snapshot.blackboard_activity
    assert (read.key, read.client_name, read.activity_type) == ("/clock/now_s", "Timeout (clock)", "READ")

    bare = snapshot_of(tree.root)
    assert (bare.blackboard_on_visited_path, bare.blackboard_activity) == ((), ())


def test_long_values_are_cut_and_missing_ones_are_dashes(trace: MakeTrace) -> None:
    tree = trace('<Timeout msec="100"><A/></Timeout>', A="R")
    tree.tick()
    Blackboard.set("/clock/now_s", "x" * (2 * MAX_TEXT))
    ((_, text),) = snapshot_of(tree.root, blackboard_data=True).blackboard_on_visited_path
    assert text == "x" * MAX_TEXT + "..."
    Blackboard.unset("/clock/now_s")
    assert snapshot_of(tree.root, blackboard_data=True).blackboard_on_visited_path == (("/clock/now_s", "-"),)


# -- changes -------------------------------------------------------------------------------------------------


def test_changes_are_noticed(trace: MakeTrace) -> None:
    tree, notebook = trace("<Sequence><A/><B/></Sequence>", A="RRS", B="R"), TreeNotebook()
    observed = []
    for _ in range(5):
        tree.tick()
        observed.append(notebook.note(tree.root).changed)
    # begun; the same; the second child; only that one visited any more; the same
    assert observed == [True, False, True, True, False]
    assert tree.halt()
    assert notebook.note(tree.root).changed
    assert not notebook.note(tree.root).changed


def test_a_message_alone_is_no_change(trace: MakeTrace) -> None:
    # as py_trees has it: a leaf may say something else in every tick
    tree, notebook = trace("<A/>", A="R"), TreeNotebook()
    tree.tick()
    notebook.note(tree.root)
    tree.root.feedback_message = "3 m away"
    assert not notebook.note(tree.root).changed


def test_another_tree_is_a_change(trace: MakeTrace) -> None:
    notebook = TreeNotebook()
    for _ in range(2):
        assert notebook.note(trace("<A/>", A="R").root).changed


def test_a_tree_that_was_changed_is_looked_at_anew_after_being_told(trace: MakeTrace) -> None:
    root = py_trees.composites.Sequence("root", memory=True, children=[py_trees.behaviours.Running("a")])
    notebook = TreeNotebook()
    root.tick_once()
    notebook.note(root)
    root.add_child(py_trees.behaviours.Running("b"))
    notebook.forget()
    assert notebook.note(root).changed
    root.children[1].status = Status.FAILURE
    assert notebook.note(root).changed
