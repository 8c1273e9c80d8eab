"""Who owns the wheels: one request, and only its owner takes it back."""

from __future__ import annotations

import py_trees
import pytest
from py_trees.common import Status

from behaviours import LEAVES, Arrived, GiveUp, HoldStill, Idle
from behaviours.leaf import MissionLeaf
from behaviours.motion import MotionLeaf
from behaviours.standing import EndingLeaf
from target_nav.nav.skill import Skill, SkillStatus, SkillStep, View
from target_nav.state import keys
from target_nav.state.types import STOP, MotionRequest, NavState, OutcomeKind, Twist2D
from tests.utils.board import ScriptedBoard


class ScriptedSkill:
    """Goes through given steps, and counts its starts."""

    def __init__(self, steps: list[SkillStep]) -> None:
        self.steps, self.starts, self.views = list(steps), 0, list[View]()

    def start(self, view: View) -> None:
        self.starts += 1

    def step(self, view: View) -> SkillStep:
        self.views.append(view)
        return self.steps.pop(0)


class Scripted(MotionLeaf, register=False):
    STATE = NavState.NAVIGATING
    INPUT_PORTS = {}
    OUTPUT_PORTS = {}

    def __init__(self, name: str, steps: list[SkillStep]) -> None:
        super().__init__(name)
        self.setup_ports()
        self.scripted = ScriptedSkill(steps)

    def make_skill(self) -> Skill:
        return self.scripted


FORWARD = Twist2D(0.1, 0.0, 0.0)
RUNNING = SkillStep(SkillStatus.RUNNING, FORWARD, "driving")


def test_a_running_leaf_asks_for_its_skills_velocity_in_its_own_name(board: ScriptedBoard) -> None:
    leaf = Scripted("drive", [RUNNING])
    leaf.tick_once()
    assert board.read(keys.REQUEST) == MotionRequest(leaf.id.hex, NavState.NAVIGATING, FORWARD, "driving")
    assert leaf.feedback_message == "driving"


@pytest.mark.parametrize("end", [SkillStatus.SUCCESS, SkillStatus.FAILURE])
def test_a_leaf_that_ends_takes_its_request_back(board: ScriptedBoard, end: SkillStatus) -> None:
    leaf = Scripted("drive", [RUNNING, SkillStep(end, FORWARD)])
    leaf.tick_once()
    leaf.tick_once()
    assert board.read(keys.REQUEST) is None


def test_a_halted_leaf_leaves_its_successors_request_alone(board: ScriptedBoard) -> None:
    # A reactive selector starts the higher-priority child before it stops the one that ran.
    first = Scripted("first", [SkillStep(SkillStatus.FAILURE), RUNNING])
    second = Scripted("second", [SkillStep(SkillStatus.RUNNING, STOP)])
    root = py_trees.composites.Selector("either", memory=False, children=[first, second])
    root.tick_once()
    assert board.read(keys.REQUEST).owner == second.id.hex
    root.tick_once()
    assert second.status is Status.INVALID
    assert board.read(keys.REQUEST).owner == first.id.hex


def test_a_leaf_that_begins_again_starts_its_skill_again(board: ScriptedBoard) -> None:
    leaf = Scripted("drive", [RUNNING, RUNNING])
    leaf.tick_once()
    leaf.stop(Status.INVALID)
    leaf.tick_once()
    assert leaf.scripted.starts == 2


@pytest.mark.parametrize(
    ("leaf_type", "state"),
    [(Idle, NavState.IDLE), (HoldStill, NavState.IDLE), (GiveUp, NavState.IDLE), (Arrived, NavState.ARRIVED)],
)
def test_standing_leaves_ask_for_zero_and_do_not_end(
    board: ScriptedBoard, leaf_type: type[MotionLeaf], state: NavState
) -> None:
    leaf = leaf_type("stand")
    leaf.setup_ports()
    for _ in range(3):
        leaf.tick_once()
        assert leaf.status is Status.RUNNING
        assert board.read(keys.REQUEST).twist == STOP
        assert board.read(keys.REQUEST).state is state


@pytest.mark.parametrize(
    ("leaf_type", "kind"), [(Arrived, OutcomeKind.SUCCEEDED), (GiveUp, OutcomeKind.FAILED)]
)
def test_an_outcome_lasts_as_long_as_the_leaf_that_told_it(
    board: ScriptedBoard, leaf_type: type[EndingLeaf], kind: OutcomeKind
) -> None:
    leaf = leaf_type("end")
    leaf.setup_ports()
    leaf.tick_once()
    assert board.read(keys.OUTCOME).kind is kind
    leaf.stop(Status.INVALID)
    assert board.read(keys.OUTCOME) is None


def _matches(leaf: type[MissionLeaf], names: tuple[str, ...]) -> bool:
    groups = {"*motion": issubclass(leaf, MotionLeaf), "*ending": issubclass(leaf, EndingLeaf)}
    return leaf.__name__ in names or any(groups.get(name, False) for name in names)


@pytest.mark.parametrize("leaf", LEAVES)
def test_the_table_of_keys_names_every_leafs_reads_and_writes(leaf: type[MissionLeaf]) -> None:
    for key in leaf.WRITES:
        assert _matches(leaf, (key.writer,)), (
            f"{leaf.__name__} writes {key.name}; the table says {key.writer}"
        )
    for key in leaf.READS:
        assert _matches(leaf, key.readers), f"{leaf.__name__} reads {key.name}; the table says {key.readers}"


def test_every_leaf_in_the_table_exists() -> None:
    known = {leaf.__name__ for leaf in LEAVES}
    for key in keys.ALL:
        for name in (key.writer, *key.readers):
            assert name in known or name.startswith("*") or name in ("nav loop", "decorators"), (
                f"{key.name}: {name}"
            )
