"""Script, ScriptCondition, Precondition."""

from __future__ import annotations

from pathlib import Path

import pytest
from py_trees.blackboard import Blackboard

from target_nav.errors import MissionError
from tests.unit.mission.conftest import MakeTrace
from tests.unit.mission.scripted import Trace, spaced


def test_a_script_succeeds_and_leaves_its_values(trace: MakeTrace) -> None:
    tree = trace("""<Sequence><Script code="n := 1; n += 1; t := 'a' .. n"/><A/></Sequence>""", A="S")
    assert tree.tick() == ["S", "A>S"]
    assert (Blackboard.get("/n"), Blackboard.get("/t")) == (2, "a2")


def test_a_condition(trace: MakeTrace) -> None:
    tree = trace(
        """<Sequence>
            <Script code="n := 2"/><ScriptCondition code="n &gt; 1"/><ScriptCondition code="n &gt; 2"/>
        </Sequence>"""
    )
    assert tree.tick() == ["F"]
    assert [node.status.name for node in tree.root.children] == ["SUCCESS", "SUCCESS", "FAILURE"]


def test_a_condition_that_is_neither_true_nor_false(trace: MakeTrace) -> None:
    tree = trace("""<Sequence><Script code="n := 2"/><ScriptCondition name="ask" code="n"/></Sequence>""")
    with pytest.raises(MissionError, match=r'ask: code is "n"; 2 is neither true \(1\) nor false \(0\)'):
        tree.tick()


def test_constants_have_names(tmp_path: Path) -> None:
    tree = Trace(
        tmp_path,
        {},
        """<Sequence><Script code="c := GREEN"/><ScriptCondition code="c == 'GREEN'"/></Sequence>""",
        enums={"GREEN": 3},
    )
    assert tree.tick() == ["S"]
    assert Blackboard.get("/c") == 3.0


def test_a_precondition_is_asked_when_its_child_begins(tmp_path: Path) -> None:
    tree = Trace(tmp_path, {"A": "RS"}, """<Precondition if="x == 1"><A/></Precondition>""", provided=["/x"])
    rows = []
    for value in (0, 1, 0, 0):
        Blackboard.set("/x", value)
        rows.append(tree.tick())
    assert rows == spaced("F", "R A>R", "S A:S", "F")


@pytest.mark.parametrize(
    ("result", "letter"), [("SUCCESS", "S"), ("FAILURE", "F"), ("RUNNING", "R"), ("SKIPPED", "-")]
)
def test_what_a_precondition_is_instead(result: str, letter: str, trace: MakeTrace) -> None:
    assert trace(f"""<Precondition if="false" else="{result}"><A/></Precondition>""", A="S").tick() == [
        letter
    ]


def test_a_precondition_is_asked_again_after_a_halt(tmp_path: Path) -> None:
    """Not so in BehaviorTree.CPP, where a guard that was passed once is not asked until the child has ended."""
    tree = Trace(tmp_path, {"A": "R"}, """<Precondition if="x == 1"><A/></Precondition>""", provided=["/x"])
    Blackboard.set("/x", 1)
    assert tree.tick() == ["R", "A>R"]
    assert tree.halt() == ["A!"]
    Blackboard.set("/x", 0)
    assert tree.tick() == ["F"]


def test_scripts_of_subtrees_have_their_own_names(trace: MakeTrace) -> None:
    inner = """<BehaviorTree ID="T"><Script code="n := 2; m := 3; @k := 4; p := q .. 'b'"/></BehaviorTree>"""
    trace("""<Sequence><Script code="n := 1"/><SubTree ID="T" m="{mm}" q="a"/></Sequence>""", inner).tick()
    values = {key: value for key, value in Blackboard.storage.items() if not key.startswith("/clock")}
    assert values == {"/n": 1, "/T/n": 2, "/mm": 3, "/k": 4, "/T/q": "a", "/T/p": "ab"}


def test_a_subtree_can_be_given_a_script(trace: MakeTrace) -> None:
    inner = """<BehaviorTree ID="T"><Precondition if="{guard}"><Script code="{what}"/></Precondition></BehaviorTree>"""
    tree = trace("""<SubTree ID="T" guard="1 &lt; 2" what="@x := 5"/>""", inner)
    assert tree.tick() == ["S"]
    assert Blackboard.get("/x") == 5


def test_scripts_are_seen_by_watchers(trace: MakeTrace) -> None:
    tree = trace("""<Sequence><Script code="n := 1"/><A _skipIf="n == 2"/></Sequence>""", A="S")
    Blackboard.enable_activity_stream()
    try:
        tree.tick()
        assert Blackboard.activity_stream is not None
        activity = [
            (item.key, item.client_name, item.activity_type) for item in Blackboard.activity_stream.data
        ]
    finally:
        Blackboard.disable_activity_stream()
    # a leaf's ports have a client of their own, hence the number
    assert activity == [("/n", "Script", "INITIALISED"), ("/n", "A-1", "READ")]
