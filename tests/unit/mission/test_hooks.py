"""Stops and forced results on the nodes of a running tree."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import pytest
from py_trees.common import Status

from target_nav.mission.hooks import FORCED, Answer, NodeHook
from target_nav.mission.scripted_mission import ScriptedMission
from target_nav.state.types import NavState
from tests.unit.mission.scenarios import MISSION


@pytest.fixture
def mission(tmp_path: Path) -> Iterator[ScriptedMission]:
    path = tmp_path / "mission.xml"
    path.write_text(MISSION, encoding="utf-8")
    with ScriptedMission(path) as made:
        made.say("GO")
        yield made


def hook(mission: ScriptedMission, name: str, answers: list[Answer]) -> NodeHook:
    """Gives the answers in turn, the last one again and again."""
    node = mission.index.nodes[mission.index.find(name)[0]]
    left = list(answers)
    return NodeHook(node, lambda: left.pop(0) if len(left) > 1 else left[0])


@pytest.mark.parametrize("name", ["TurnSearch", "Mission", "On request"])
def test_a_node_that_is_held_is_left_as_it_was_and_begins_when_it_is_let_go(
    mission: ScriptedMission, name: str
) -> None:
    hook(mission, name, [Answer.HOLD, Answer.HOLD, Answer.GO_ON])
    for _ in range(2):
        mission.tick()
        assert mission.status("TurnSearch") is Status.INVALID
        assert mission.request is None
    mission.tick()
    assert (mission.leaf, mission.state) == ("TurnSearch", NavState.SEARCHING)


def test_a_running_leaf_that_is_held_goes_on_where_it_was(mission: ScriptedMission) -> None:
    mission.run_for(1.0)
    turned = mission.message("TurnSearch")
    made = hook(mission, "TurnSearch", [Answer.HOLD])
    mission.tick()
    assert (mission.message("TurnSearch"), mission.status("TurnSearch")) == (turned, Status.RUNNING)
    made.remove()
    mission.tick()
    assert mission.message("TurnSearch") != turned


def test_a_forced_result_takes_the_nodes_place(mission: ScriptedMission) -> None:
    hook(mission, "TurnSearch", [Answer.SUCCESS])
    mission.tick()
    assert mission.status("TurnSearch") is Status.SUCCESS
    assert mission.message("TurnSearch") == FORCED
    assert mission.leaf == "NavigateToTarget"


def test_a_running_leaf_ends_before_a_result_is_forced_and_takes_its_request_back(
    mission: ScriptedMission,
) -> None:
    mission.run_for(1.0)
    hook(mission, "TurnSearch", [Answer.FAILURE])
    mission.tick()
    assert mission.request is None
    assert mission.outcome is not None
    assert mission.outcome.kind.value == "failed"


def test_a_forced_control_node_halts_what_ran_below_it(mission: ScriptedMission) -> None:
    mission.run_for(1.0)
    hook(mission, "Mission", [Answer.FAILURE])
    mission.tick()
    assert mission.status("TurnSearch") is Status.INVALID
    assert mission.request is None


@pytest.mark.parametrize("name", ["TurnSearch", "Mission", "On request"])
def test_a_hook_that_was_removed_leaves_no_trace(mission: ScriptedMission, name: str) -> None:
    node = mission.index.nodes[mission.index.find(name)[0]]
    mission.tick()
    before = {key: value for key, value in vars(node).items() if callable(value)}
    made = hook(mission, name, [Answer.HOLD])
    mission.tick()
    made.remove()
    after = {key: value for key, value in vars(node).items() if callable(value)}
    assert before.keys() == after.keys()
    mission.tick()
    assert mission.leaf == "TurnSearch"


def test_a_hook_on_a_node_with_conditions_keeps_them(tmp_path: Path) -> None:
    path = tmp_path / "conditions.xml"
    path.write_text(
        MISSION.replace('<TurnSearch reason="{why}"/>', '<TurnSearch reason="{why}" _skipIf="true"/>'),
        encoding="utf-8",
    )
    with ScriptedMission(path) as mission:
        mission.say("GO")
        made = hook(mission, "TurnSearch", [Answer.HOLD])
        mission.tick()
        made.remove()
        mission.tick()
        assert mission.leaf == "NavigateToTarget"
