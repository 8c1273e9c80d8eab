"""A mission ticked from Python against a scripted blackboard."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import pytest
from py_trees.blackboard import Blackboard
from py_trees.common import Status

from target_nav.config import Config
from target_nav.errors import MissionError
from target_nav.mission.scenario_values import BadScript
from target_nav.mission.scripted_mission import ScriptedMission
from target_nav.state import keys
from target_nav.state.types import CommandKind, NavState
from tests.unit.mission.scenarios import MISSION
from tests.unit.mission.scripted import document


@pytest.fixture
def mission(tmp_path: Path) -> Iterator[ScriptedMission]:
    path = tmp_path / "mission.xml"
    path.write_text(MISSION, encoding="utf-8")
    with ScriptedMission(path) as made:
        yield made


def test_it_goes_through_the_mission(mission: ScriptedMission) -> None:
    mission.tick()
    assert (mission.leaf, mission.state) == ("Idle", NavState.IDLE)
    mission.say("GO")
    mission.run_for(1.0)
    assert mission.leaf == "TurnSearch"
    mission.set(track={"range_m": 1.2})
    seen = mission.run_until(lambda seen: seen.state is NavState.ARRIVED, within_s=10.0)
    assert seen.outcome is not None
    assert mission.status("NavigateToTarget") is Status.SUCCESS
    assert mission.message("NavigateToTarget").startswith(("target 0.79 m", "target 0.80 m"))
    assert mission.read("track").range_m == pytest.approx(0.8, abs=0.01)
    assert mission.now_s == len(mission.observations) * 0.05


def test_what_does_not_happen_says_what_did(mission: ScriptedMission) -> None:
    with pytest.raises(
        AssertionError, match=r"within 1 s; at 0\.95 s the robot is IDLE, Idle runs: waiting for GO"
    ):
        mission.run_until(lambda seen: seen.state is NavState.ARRIVED, within_s=1.0)


def test_a_time_runs_its_ticks(mission: ScriptedMission) -> None:
    mission.run_for(1.0)
    assert len(mission.observations) == 20
    mission.run_for(0.05)
    assert len(mission.observations) == 21


def test_the_configuration_reaches_the_leaves_and_the_clock(tmp_path: Path) -> None:
    path = tmp_path / "mission.xml"
    path.write_text(MISSION, encoding="utf-8")
    config = Config().override({"loop.rate_hz": 10.0, "search.time_limit_s": 2.0})
    with ScriptedMission(path, config=config, drives=False) as mission:
        mission.say(CommandKind.GO)
        mission.run_for(2.5)
        assert len(mission.observations) == 25
        assert mission.message("TurnSearch").startswith("not found")


def test_a_pattern_must_mean_one_behaviour(mission: ScriptedMission) -> None:
    mission.tick()
    with pytest.raises(BadScript, match="no behaviour of the mission is 'Idel'"):
        mission.status("Idel")
    with pytest.raises(BadScript, match="fits 3 behaviours"):
        mission.message("*/Mission/*")


def test_there_is_nothing_to_be_seen_before_the_first_tick(mission: ScriptedMission) -> None:
    with pytest.raises(BadScript, match="nothing was ticked yet"):
        _ = mission.leaf


def test_other_words_are_refused(mission: ScriptedMission) -> None:
    with pytest.raises(BadScript, match="GO, STOP, PAUSE, RESUME, STEP"):
        mission.say("JUMP")


def test_closing_leaves_an_empty_board_and_a_halted_tree(mission: ScriptedMission) -> None:
    mission.tick()
    root = mission.root
    mission.close()
    assert not Blackboard.storage
    assert root.status is Status.INVALID


def test_a_root_that_ends_is_ticked_no_more_until_go(tmp_path: Path) -> None:
    path = tmp_path / "mission.xml"
    path.write_text(document("<Sequence><Sleep msec='100'/><AlwaysFailure/></Sequence>"), encoding="utf-8")
    with ScriptedMission(path) as mission:
        mission.run_for(1.0)
        assert mission.outcome is not None
        assert (mission.outcome.kind.value, mission.leaf) == ("failed", "AlwaysFailure")
        mission.say("GO")
        assert mission.tick().outcome is None
        assert mission.leaf == "Sleep"


def test_entries_of_the_missions_own_can_be_provided(tmp_path: Path) -> None:
    path = tmp_path / "mission.xml"
    path.write_text(document('<HoldStill reason="{goal}"/>'), encoding="utf-8")
    with pytest.raises(MissionError, match="nobody writes"):
        ScriptedMission(path)
    with ScriptedMission(path, provided_keys=["/goal"]) as mission:
        mission.set({"/goal": "the kitchen"})
        assert mission.tick().reason == "the kitchen"
        assert Blackboard.get(keys.REQUEST.name).reason == "the kitchen"
