"""One tick of the nav core: what goes in, what comes out, and that nothing moves when it should not."""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np
import py_trees
import pytest
from py_trees.common import Status

from behaviours import Arrived, GiveUp, Idle, InputsFresh, MissionRequested
from behaviours.motion import MotionLeaf
from target_nav.app.nav_core import NavCore
from target_nav.config import Config
from target_nav.nav.skill import Skill, SkillStatus, SkillStep, View
from target_nav.state import keys
from target_nav.state.snapshots import NavSnapshot
from target_nav.state.types import (
    STOP,
    Command,
    CommandKind,
    DetectionFrame,
    Inputs,
    NavState,
    Odometry,
    OutcomeKind,
    Pose2D,
    Scan,
    TickRecord,
    Twist2D,
)

PERIOD_S = 0.05


class ScriptedWorld:
    """Source, sink and recorder in one: gives what the test sets, keeps what the core says."""

    def __init__(self) -> None:
        self.scan: Scan | None = None
        self.scan_age_s = 0.1
        self.odom_age_s = 0.02
        self.camera_age_s = 0.1
        self.pose = Pose2D()
        self.commands: list[CommandKind] = []
        self.published: list[NavSnapshot] = []
        self.recorded: list[TickRecord] = []
        self.resets = 0

    def read(self, now_s: float) -> Inputs:
        odometry = Odometry(now_s - self.odom_age_s, self.pose, STOP)
        ranges = np.full(360, 5.0)
        commands = tuple(Command(now_s, kind) for kind in self.commands)
        self.commands = []
        return Inputs(
            now_s=now_s,
            scan=Scan(now_s - self.scan_age_s, -math.pi, math.tau / 360, 0.0, 0.15, 12.0, ranges),
            odometry=odometry,
            odometry_since=(odometry,),
            detections=DetectionFrame(now_s - self.camera_age_s, 1),
            commands=commands,
        )

    def publish(self, snapshot: NavSnapshot, inputs: Inputs) -> None:
        self.published.append(snapshot)

    def reset_odometry(self) -> None:
        self.resets += 1

    def record(self, inputs: Inputs, record: TickRecord) -> None:
        self.recorded.append(record)


class Forward(MotionLeaf, register=False):
    """Drives ahead, for ever."""

    STATE = NavState.NAVIGATING
    INPUT_PORTS = {}
    OUTPUT_PORTS = {}
    twist = Twist2D(0.1, 0.0, 0.0)

    def make_skill(self) -> Skill:
        leaf = self

        class Drive:
            def start(self, view: View) -> None:
                """Nothing to prepare."""

            def step(self, view: View) -> SkillStep:
                return SkillStep(SkillStatus.RUNNING, leaf.twist, "ahead")

        return Drive()


def leaf(kind: type, name: str) -> py_trees.behaviour.Behaviour:
    made: py_trees.behaviour.Behaviour = kind(name)
    made.setup_ports()
    return made


def when_requested(*actions: py_trees.behaviour.Behaviour) -> py_trees.behaviour.Behaviour:
    go = py_trees.composites.Sequence(
        "go", memory=False, children=[leaf(MissionRequested, "requested"), *actions]
    )
    return py_trees.composites.Selector("root", memory=False, children=[go, leaf(Idle, "idle")])


@pytest.fixture
def world() -> Iterator[ScriptedWorld]:
    py_trees.blackboard.Blackboard.clear()
    yield ScriptedWorld()
    py_trees.blackboard.Blackboard.clear()


def run(core: NavCore, ticks: int, begin_s: float = 10.0) -> TickRecord:
    for n in range(ticks):
        record = core.tick(begin_s + n * PERIOD_S)
    return record


def test_without_go_the_robot_is_idle_and_stands(world: ScriptedWorld) -> None:
    core = NavCore(Config(), when_requested(leaf(Forward, "drive")), world, world, world)
    record = run(core, 5)
    assert (record.state, record.sent, record.running_leaf) == (NavState.IDLE, STOP, "idle")


def test_go_starts_the_mission_and_the_limiter_ramps_it_up(world: ScriptedWorld) -> None:
    core = NavCore(Config(), when_requested(leaf(Forward, "drive")), world, world, world)
    world.commands = [CommandKind.GO]
    speeds = [run(core, 1, 10.0 + n * PERIOD_S).sent.vx_mps for n in range(20)]
    assert speeds == sorted(speeds)
    assert speeds[-1] == pytest.approx(0.1)
    steps = np.diff([0.0, *speeds])
    assert steps.max() <= Config().robot.max_accel_mps2 * PERIOD_S + 1e-9


def test_stop_ends_motion_within_the_braking_limit(world: ScriptedWorld) -> None:
    core = NavCore(Config(), when_requested(leaf(Forward, "drive")), world, world, world)
    world.commands = [CommandKind.GO]
    run(core, 20)
    world.commands = [CommandKind.STOP]
    record = run(core, 4, 11.0)
    assert (record.state, record.sent) == (NavState.IDLE, STOP)


@pytest.mark.parametrize(("stale", "age_s"), [("scan_age_s", 0.9), ("odom_age_s", 0.4)])
def test_a_stale_input_stops_the_wheels_at_once_whatever_the_tree_wants(
    world: ScriptedWorld, stale: str, age_s: float
) -> None:
    core = NavCore(Config(), when_requested(leaf(Forward, "drive")), world, world, world)
    world.commands = [CommandKind.GO]
    assert run(core, 20).sent.vx_mps > 0.0
    setattr(world, stale, age_s)
    record = run(core, 1, 11.0)
    assert record.requested.vx_mps > 0.0
    assert record.sent == STOP
    assert record.limited_by


@pytest.mark.parametrize(
    "bad", [Twist2D(math.nan, 0.0, 0.0), Twist2D(0.1, math.inf, 0.0), Twist2D(0, 0, -math.inf)]
)
def test_a_velocity_that_is_not_a_number_never_leaves(world: ScriptedWorld, bad: Twist2D) -> None:
    drive = leaf(Forward, "drive")
    drive.twist = bad
    core = NavCore(Config(), when_requested(drive), world, world, world)
    world.commands = [CommandKind.GO]
    assert run(core, 3).sent == STOP


def test_pause_holds_still_and_resume_goes_on(world: ScriptedWorld) -> None:
    core = NavCore(Config(), when_requested(leaf(Forward, "drive")), world, world, world)
    world.commands = [CommandKind.GO]
    run(core, 20)
    world.commands = [CommandKind.PAUSE]
    assert run(core, 10, 11.0).sent == STOP
    assert world.published[-1].reason == "paused"
    world.commands = [CommandKind.RESUME]
    assert run(core, 10, 11.5).sent.vx_mps > 0.0


def test_an_outcome_stays_until_the_operator_speaks(world: ScriptedWorld) -> None:
    core = NavCore(Config(), when_requested(leaf(Arrived, "arrived")), world, world, world)
    world.commands = [CommandKind.GO]
    record = run(core, 50)
    assert record.state is NavState.ARRIVED
    assert record.outcome is not None
    assert record.outcome.kind is OutcomeKind.SUCCEEDED
    world.commands = [CommandKind.STOP]
    record = run(core, 2, 13.0)
    assert (record.state, record.outcome) == (NavState.IDLE, None)


def test_go_after_an_end_begins_anew(world: ScriptedWorld) -> None:
    ending = leaf(GiveUp, "give up")
    core = NavCore(Config(), when_requested(ending), world, world, world)
    world.commands = [CommandKind.GO]
    run(core, 3)
    halted: list[Status] = []
    stop = ending.terminate
    ending.terminate = lambda status: (halted.append(status), stop(status))
    world.commands = [CommandKind.GO]
    record = run(core, 1, 11.0)
    assert halted == [Status.INVALID]
    assert record.outcome is not None


@pytest.mark.parametrize(
    ("ends", "kind"),
    [(py_trees.behaviours.Success, OutcomeKind.SUCCEEDED), (py_trees.behaviours.Failure, OutcomeKind.FAILED)],
)
def test_a_tree_that_ends_is_ticked_no_more_until_the_next_go(
    world: ScriptedWorld, ends: type, kind: OutcomeKind
) -> None:
    root = py_trees.composites.Sequence("root", memory=True, children=[ends(name="end")])
    core = NavCore(Config(), root, world, world, world)
    record = run(core, 1)
    assert record.outcome is not None
    assert record.outcome.kind is kind
    ticks = world.published[-1].tick
    run(core, 5, 11.0)
    assert world.published[-1].tick == ticks
    world.commands = [CommandKind.GO]
    run(core, 1, 12.0)
    assert world.published[-1].tick == ticks + 1


def test_resetting_odometry_is_passed_on_and_forgets_what_was_in_the_old_frame(world: ScriptedWorld) -> None:
    core = NavCore(Config(), when_requested(leaf(Forward, "drive")), world, world, world)
    world.pose = Pose2D(3.0, 1.0, 0.5)
    run(core, 3)
    world.commands, world.pose = [CommandKind.RESET_ODOM], Pose2D()
    run(core, 2, 10.15)
    assert world.resets == 1
    assert world.published[-1].pose_in_odom.x_m == pytest.approx(0.0, abs=1e-6)


def test_every_tick_is_published_and_recorded_once(world: ScriptedWorld) -> None:
    core = NavCore(Config(), when_requested(leaf(Forward, "drive")), world, world, world)
    run(core, 7)
    assert len(world.published) == len(world.recorded) == 7


def test_ages_reach_the_guards(world: ScriptedWorld) -> None:
    core = NavCore(
        Config(), when_requested(leaf(InputsFresh, "fresh"), leaf(Forward, "drive")), world, world, world
    )
    world.commands, world.camera_age_s = [CommandKind.GO], 1.2
    record = run(core, 2)
    assert record.running_leaf == "idle"
    assert "camera 1.20 s old (limit 1.00 s)" in core.root.children[0].children[1].feedback_message


def test_the_slowest_leaf_is_known_by_its_path(world: ScriptedWorld) -> None:
    core = NavCore(Config(), when_requested(leaf(Forward, "drive")), world, world, world)
    run(core, 3)
    assert core.probe.slowest.name in {"/root/go/requested", "/root/idle"}
    assert core.probe.slowest.duration_s > 0.0


def test_closing_leaves_an_empty_board(world: ScriptedWorld) -> None:
    core = NavCore(Config(), when_requested(leaf(Forward, "drive")), world, world, world)
    run(core, 1)
    core.close()
    assert not py_trees.blackboard.Blackboard.storage


def test_a_key_of_the_table_exists_from_the_first_tick_on(world: ScriptedWorld) -> None:
    NavCore(Config(), when_requested(leaf(Forward, "drive")), world, world, world).tick(10.0)
    assert {key.name for key in keys.ALL} <= set(py_trees.blackboard.Blackboard.storage)
