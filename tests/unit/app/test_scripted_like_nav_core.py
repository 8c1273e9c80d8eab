"""The scripted mission takes an operator's words as the nav core does: the same words, the same leaves."""

from __future__ import annotations

from pathlib import Path

import py_trees
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from target_nav.app.nav_core import NavCore
from target_nav.config import Config
from target_nav.mission import load_mission
from target_nav.mission.scripted_mission import ScriptedMission
from target_nav.state.types import CommandKind
from tests.unit.app.test_nav_core import PERIOD_S, ScriptedWorld
from tests.unit.mission.scripted import document

WORDS = [CommandKind.GO, CommandKind.STOP, CommandKind.PAUSE, CommandKind.RESUME, CommandKind.STEP]
ENDS_BY_A_LEAF = document(
    """
    <WhileDoElse>
      <MissionRequested/>
      <Sequence><HoldStillFor100ms/><Arrived/></Sequence>
      <Idle/>
    </WhileDoElse>
    """.replace(
        "<HoldStillFor100ms/>", '<ForceSuccess><Timeout msec="100"><HoldStill/></Timeout></ForceSuccess>'
    )
)
ENDS_BY_ITSELF = document('<Sequence><MissionRequested/><Sleep msec="100"/><AlwaysFailure/></Sequence>')


def by_nav_core(path: Path, words: list[list[CommandKind]]) -> list[tuple[str, str, str]]:
    py_trees.blackboard.Blackboard.clear()
    world = ScriptedWorld()
    core = NavCore(Config(), load_mission(path).root, world, world, world)
    seen = []
    for tick, said in enumerate(words):
        world.commands = list(said)
        record = core.tick(tick * PERIOD_S)
        outcome = record.outcome.kind.value if record.outcome else ""
        seen.append((record.running_leaf, record.state.name, outcome))
    core.close()
    return seen


def by_script(path: Path, words: list[list[CommandKind]]) -> list[tuple[str, str, str]]:
    seen = []
    with ScriptedMission(path, drives=False) as mission:
        for said in words:
            for word in said:
                mission.say(word)
            tick = mission.tick()
            outcome = tick.outcome.kind.value if tick.outcome else ""
            seen.append((tick.leaf_name, tick.state.name, outcome))
    return seen


@pytest.mark.parametrize("xml", [ENDS_BY_A_LEAF, ENDS_BY_ITSELF], ids=["leaf", "root"])
@settings(max_examples=40, suppress_health_check=[HealthCheck.function_scoped_fixture], deadline=None)
@given(st.lists(st.lists(st.sampled_from(WORDS), max_size=1), min_size=1, max_size=25))
def test_the_same_words_the_same_leaves(tmp_path: Path, xml: str, words: list[list[CommandKind]]) -> None:
    path = tmp_path / "mission.xml"
    path.write_text(xml, encoding="utf-8")
    assert by_script(path, words) == by_nav_core(path, words)
