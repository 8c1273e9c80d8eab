"""Mocked leaves: what they answer, when, what they write, and what is left as it was."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import pytest
from py_trees.blackboard import Blackboard
from py_trees.common import Status

from target_nav.errors import MissionError
from target_nav.mission.mocks import MockSpec
from target_nav.mission.scripted_mission import ScriptedMission
from target_nav.state.types import NavState, Twist2D
from tests.unit.mission.scripted import document

R, S, F = Status.RUNNING, Status.SUCCESS, Status.FAILURE
XML = document(
    """
    <Fallback>
      <Sequence name="first">
        <TurnSearch name="look"/>
        <NavigateToTarget reason="{why}"/>
      </Sequence>
      <SubTree ID="Other" why="{why}"/>
    </Fallback>
    """,
    """
    <BehaviorTree ID="Other">
      <Sequence>
        <NavigateToTarget name="again" reason="{why}"/>
        <HoldStill reason="{why}"/>
      </Sequence>
    </BehaviorTree>
    """,
)


@pytest.fixture
def path(tmp_path: Path) -> Iterator[Path]:
    file = tmp_path / "mission.xml"
    file.write_text(XML, encoding="utf-8")
    yield file
    Blackboard.clear()


def statuses(mission: ScriptedMission, pattern: str, ticks: int) -> list[Status]:
    seen = []
    for _ in range(ticks):
        mission.tick()
        seen.append(mission.status(pattern))
    return seen


def test_one_status_a_tick_the_last_one_again_and_again(path: Path) -> None:
    with ScriptedMission(path, mocks=[MockSpec("look", [R, R, S])]) as mission:
        mission.set(track={"range_m": 3.0})
        assert statuses(mission, "look", 4) == [R, R, S, S]


def test_after_a_failure_it_begins_anew_with_the_next(path: Path) -> None:
    mocks = [MockSpec("look", [F, R, F]), MockSpec("Other", [F])]
    with ScriptedMission(path, mocks=mocks) as mission:
        mission.tick()
        # the root has failed, and is ticked no more until GO
        mission.say("GO")
        assert statuses(mission, "look", 2) == [R, F]
        (mock,) = mission.mocks["look"]
        assert mock.begun == 2


def test_it_runs_for_a_time_each_time_it_begins(path: Path) -> None:
    with ScriptedMission(path, mocks=[MockSpec("look", [S], after_s=0.15)]) as mission:
        mission.set(track={"range_m": 3.0})
        assert statuses(mission, "look", 4) == [R, R, R, S]


def test_a_motion_leaf_still_owns_the_state_and_asks_for_what_it_is_told(path: Path) -> None:
    twist = Twist2D(0.05, 0.0, 0.1)
    with ScriptedMission(path, mocks=[MockSpec("look", [R, F], message="looking", twist=twist)]) as mission:
        seen = mission.tick()
        assert (seen.state, seen.leaf_name, seen.reason) == (NavState.SEARCHING, "look", "looking")
        assert seen.request is not None
        assert seen.request.twist == twist
        assert mission.tick().leaf_name != "look"
        assert mission.request is None or mission.request.owner != mission.index.nodes[0].id.hex


def test_it_writes_its_outputs_and_keys_when_it_ends(path: Path) -> None:
    spec = MockSpec("*/first/NavigateToTarget", [R, F], writes={"reason": "no way", "/elsewhere": 3})
    with ScriptedMission(path, mocks=[MockSpec("look", [S]), spec, MockSpec("again", [R])]) as mission:
        mission.tick()
        assert mission.read("/why") is None
        mission.tick()
        assert (mission.read("/why"), mission.read("/elsewhere")) == ("no way", 3)


def test_a_mock_of_a_subtree_answers_for_all_below_it(path: Path) -> None:
    with ScriptedMission(path, mocks=[MockSpec("look", [F]), MockSpec("Other", [R, S])]) as mission:
        mission.tick()
        assert mission.status("again") is Status.INVALID
        mission.tick()
        assert mission.outcome is not None
        assert mission.outcome.kind.value == "succeeded"


def test_a_halt_reaches_the_mock(path: Path) -> None:
    mission = ScriptedMission(path, mocks=[MockSpec("look", [R])])
    mission.tick()
    (mock,) = mission.mocks["look"]
    mission.close()
    assert (mock.begun, mock.halted) == (1, 1)


def test_the_first_pattern_that_fits_counts(path: Path) -> None:
    mocks = [MockSpec("look", [S]), MockSpec("*/first/NavigateToTarget", [R]), MockSpec("*", [F])]
    with ScriptedMission(path, mocks=mocks[:2]) as mission:
        mission.mock([MockSpec("NavigateToTarget", [S])])
        assert [len(each) for each in mission.mocks.values()] == [1, 1, 1]
        mission.tick()
        assert mission.leaf == "NavigateToTarget"


def test_a_pattern_that_fits_nothing_and_an_output_that_is_not_there_are_told_together(path: Path) -> None:
    mocks = [MockSpec("lookk", [S]), MockSpec("look", [S], writes={"raeson": "x"})]
    with pytest.raises(MissionError) as told:
        ScriptedMission(path, mocks=mocks)
    first, second = str(told.value).splitlines()
    assert first == "no behaviour of the mission is 'lookk'; did you mean \"look\"?"
    assert second.endswith("/first/look has no output 'raeson'")


def test_a_mock_that_returns_nothing_is_refused() -> None:
    with pytest.raises(ValueError, match="returns nothing"):
        MockSpec("look", [])
