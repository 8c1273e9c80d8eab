"""SetBlackboard and UnsetBlackboard."""

from __future__ import annotations

from pathlib import Path

import pytest
from py_trees.blackboard import Blackboard

from target_nav.errors import MissionError
from tests.unit.mission.conftest import MakeTrace
from tests.unit.mission.scripted import Trace


def test_a_text_is_written(trace: MakeTrace) -> None:
    assert trace('<SetBlackboard output_key="x" value="42"/>').tick() == ["S"]
    assert Blackboard.get("/x") == "42"


def test_a_text_becomes_what_ports_read(trace: MakeTrace) -> None:
    tree = """<Sequence><SetBlackboard output_key="n" value="2"/><Repeat num_cycles="{n}"><A/></Repeat></Sequence>"""
    trace(tree, A="R").tick()
    assert Blackboard.get("/n") == 2


def test_an_entry_is_copied_whatever_it_holds(tmp_path: Path) -> None:
    tree = Trace(tmp_path, {}, '<SetBlackboard output_key="x" value="{y}"/>', provided=["/y"])
    assert tree.tick() == ["F"]
    assert tree.root.feedback_message == "value has no value yet"
    for value in (1.5, "text", [1], (2, 3)):
        Blackboard.set("/y", value)
        assert tree.tick() == ["S"]
        assert Blackboard.get("/x") is value
    assert tree.root.feedback_message == ""


def test_what_does_not_fit_is_told(tmp_path: Path) -> None:
    tree = """<Sequence><SetBlackboard output_key="n" value="{y}"/><Repeat num_cycles="{n}"><A/></Repeat></Sequence>"""
    trace = Trace(tmp_path, {"A": "S"}, tree, provided=["/y"])
    Blackboard.set("/y", 2.5)
    with pytest.raises(MissionError, match=r"output_key /n is given 2.5; it must be a whole number"):
        trace.tick()


def test_the_root_blackboard_can_be_written(trace: MakeTrace) -> None:
    inner = """<BehaviorTree ID="T"><SetBlackboard output_key="@x" value="a"/></BehaviorTree>"""
    trace('<SubTree ID="T"/>', inner).tick()
    assert Blackboard.get("/x") == "a"


def test_unset_removes_what_the_key_means(trace: MakeTrace) -> None:
    """Through remapping too, where BehaviorTree.CPP's does nothing."""
    inner = """<BehaviorTree ID="T"><UnsetBlackboard key="y"/></BehaviorTree>"""
    tree = trace("""<Sequence><Script code="x := 1"/><SubTree ID="T" y="{x}"/></Sequence>""", inner)
    assert tree.tick() == ["S"]
    assert not Blackboard.exists("/x")


def test_what_is_not_there_can_be_unset(tmp_path: Path) -> None:
    assert Trace(tmp_path, {}, '<UnsetBlackboard key="x"/>', provided=["/x"]).tick() == ["S"]


def test_an_entry_that_was_unset_must_be_made_again(trace: MakeTrace) -> None:
    script = '<Script code="x = 2"/>'
    tree = trace(
        f"""<Sequence><Script code="x := 1"/>{script}<UnsetBlackboard key="x"/>{script}</Sequence>"""
    )
    with pytest.raises(MissionError, match="there is no entry x yet; to make one, write x :="):
        tree.tick()
