"""Driving by hand, settings, mission, target and motor test: recorded inputs, and never against a mission that runs."""

from __future__ import annotations

import math
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import py_trees
import pytest

from behaviours import Idle, MissionRequested
from target_nav.app.nav_core import NavCore
from target_nav.app.operator_desk import MOTOR_HOLD_S, target_of
from target_nav.app.paths import mission_path
from target_nav.config import Config
from target_nav.errors import ConfigError
from target_nav.mission import load_mission
from target_nav.state import keys
from target_nav.state.live_settings import fingerprint
from target_nav.state.snapshots import NavSnapshot
from target_nav.state.types import (
    STOP,
    Command,
    CommandKind,
    Inputs,
    NavState,
    Odometry,
    Pose2D,
    Scan,
    TargetSpec,
    TickRecord,
)

PERIOD_S = 0.05
AHEAD = "0.15,0,0"


class World:
    """An open floor with a wall as far ahead as the test likes; keeps what the core publishes."""

    def __init__(self) -> None:
        self.ahead_m = 5.0
        self.commands: list[Command] = []
        self.published: list[NavSnapshot] = []

    def say(self, kind: CommandKind, argument: str = "", stamp_s: float = 0.0) -> None:
        self.commands.append(Command(stamp_s, kind, argument))

    def read(self, now_s: float) -> Inputs:
        ranges = np.full(360, 5.0)
        ranges[150:210] = self.ahead_m
        odometry = Odometry(now_s - 0.02, Pose2D(), STOP)
        commands, self.commands = tuple(self.commands), []
        scan = Scan(now_s - 0.1, -math.pi, math.tau / 360, 0.0, 0.15, 12.0, ranges)
        return Inputs(now_s, scan, odometry, (odometry,), None, commands)

    def publish(self, snapshot: NavSnapshot, inputs: Inputs) -> None:
        self.published.append(snapshot)

    def reset_odometry(self) -> None:
        """Nothing here needs it."""


def leaf(kind: type, name: str) -> py_trees.behaviour.Behaviour:
    made: py_trees.behaviour.Behaviour = kind(name)
    made.setup_ports()
    return made


@pytest.fixture
def world() -> Iterator[World]:
    py_trees.blackboard.Blackboard.clear()
    yield World()
    py_trees.blackboard.Blackboard.clear()


@pytest.fixture
def core(world: World) -> NavCore:
    wanted = leaf(MissionRequested, "requested")
    root = py_trees.composites.Selector("root", memory=False, children=[wanted, leaf(Idle, "idle")])
    return NavCore(Config(), root, world, world)


def tick(core: NavCore, now_s: float) -> TickRecord:
    return core.tick(now_s)


def hold(core: NavCore, world: World, begin_s: float, ticks: int, argument: str = AHEAD) -> TickRecord:
    """Say in every tick that it is held."""
    for n in range(ticks):
        now_s = begin_s + n * PERIOD_S
        world.say(CommandKind.MANUAL, argument, now_s)
        record = tick(core, now_s)
    return record


def test_what_is_held_moves_the_robot_through_the_limiters_ramp(core: NavCore, world: World) -> None:
    speeds = [hold(core, world, 10.0 + n * PERIOD_S, 1).sent.vx_mps for n in range(12)]
    assert speeds == sorted(speeds)
    assert speeds[-1] == pytest.approx(0.15)
    assert speeds[0] <= Config().robot.max_accel_mps2 * 0.2 + 1e-9
    assert world.published[-1].manual
    assert world.published[-1].state is NavState.IDLE


@pytest.mark.parametrize(
    ("argument", "axis"), [("0,0.1,0", "vy_mps"), ("0,0,0.5", "wz_radps"), ("-0.1,0,0", "vx_mps")]
)
def test_it_strafes_turns_and_backs(core: NavCore, world: World, argument: str, axis: str) -> None:
    record = hold(core, world, 10.0, 12, argument)
    wanted = [float(value) for value in argument.split(",")]
    sent = [record.sent.vx_mps, record.sent.vy_mps, record.sent.wz_radps]
    assert sent == pytest.approx(wanted)
    assert getattr(record.sent, axis) != 0.0


def test_without_a_fresh_word_the_deadman_stops_it_in_braking_time(core: NavCore, world: World) -> None:
    config = Config()
    hold(core, world, 10.0, 12)
    last_s = 10.0 + 11 * PERIOD_S
    brakes_s = 0.15 / config.robot.max_decel_mps2
    still_s = None
    for n in range(1, 20):
        now_s = last_s + n * PERIOD_S
        record = tick(core, now_s)
        if record.sent == STOP:
            still_s = now_s
            break
    assert still_s is not None
    assert still_s - last_s <= config.manual.timeout_s + brakes_s + 2 * PERIOD_S + 1e-9
    assert still_s - last_s > config.manual.timeout_s
    assert not world.published[-1].manual


def test_a_word_that_arrives_late_counts_from_when_it_was_said(core: NavCore, world: World) -> None:
    world.say(CommandKind.MANUAL, AHEAD, 10.0)
    record = tick(core, 10.0 + Config().manual.timeout_s + 0.01)
    assert record.sent == STOP
    assert not world.published[-1].manual


def test_zero_ends_the_hold_at_once(core: NavCore, world: World) -> None:
    hold(core, world, 10.0, 12)
    world.say(CommandKind.MANUAL, "0,0,0", 10.6)
    tick(core, 10.6)
    assert not world.published[-1].manual


def test_a_wall_stops_a_robot_that_is_driven_by_hand(core: NavCore, world: World) -> None:
    world.ahead_m = Config().robot.front_m + Config().avoid.stop_clearance_m + 0.005
    record = hold(core, world, 10.0, 20)
    assert record.sent.vx_mps == 0.0
    assert record.limited_by == "clearance"


@pytest.mark.parametrize("argument", ["", "fast", "0.1,0", "nan,0,0", "inf,0,0", "1,2,3,4"])
def test_what_is_no_velocity_moves_nothing_and_is_told(core: NavCore, world: World, argument: str) -> None:
    assert hold(core, world, 10.0, 3, argument).sent == STOP
    assert "velocity" in world.published[-1].notice


def test_while_a_mission_is_wanted_nothing_is_driven_by_hand_and_the_operator_is_told(
    core: NavCore, world: World
) -> None:
    world.say(CommandKind.GO)
    tick(core, 10.0)
    record = hold(core, world, 10.05, 5)
    assert record.sent == STOP
    assert "STOP first" in world.published[-1].notice
    world.say(CommandKind.STOP)
    tick(core, 10.4)
    assert hold(core, world, 10.45, 5).sent.vx_mps > 0.0


@pytest.mark.parametrize("word", [CommandKind.GO, CommandKind.STOP])
def test_go_and_stop_end_a_hold(core: NavCore, world: World, word: CommandKind) -> None:
    hold(core, world, 10.0, 12)
    world.say(word)
    tick(core, 10.6)
    assert not world.published[-1].manual
    for n in range(6):
        record = tick(core, 10.65 + n * PERIOD_S)
    assert record.sent == STOP


def test_a_leaf_that_asks_for_nothing_does_not_inherit_what_the_hand_asked(
    core: NavCore, world: World
) -> None:
    hold(core, world, 10.0, 6)
    world.say(CommandKind.GO)
    # MissionRequested is the only leaf that is ticked now, and it asks for no motion
    assert tick(core, 10.3).requested == STOP


def test_a_setting_reaches_leaves_limiter_and_screen(core: NavCore, world: World) -> None:
    tick(core, 10.0)
    before = world.published[-1].settings_crc
    world.say(CommandKind.SETTING, "robot.max_speed_mps=0.05")
    tick(core, 10.05)
    changed = Config().override({"robot.max_speed_mps": 0.05})
    assert world.published[-1].settings_crc == fingerprint(changed) != before
    assert py_trees.blackboard.Blackboard.storage[keys.CONFIG.name] == changed
    assert hold(core, world, 10.1, 12).sent.vx_mps == pytest.approx(0.05)


@pytest.mark.parametrize(
    ("argument", "told"),
    [
        ("approach.stand_off_m=9", "must lie in"),
        ("approach.stand_of_m=0.1", "did you mean"),
        ("lidar.rate_hz=6.0", "restart"),
        ("approach.stand_off_m", "key=value"),
        ("approach.stand_off_m=", "key=value"),
    ],
)
def test_a_setting_that_cannot_be_taken_is_told_and_changes_nothing(
    core: NavCore, world: World, argument: str, told: str
) -> None:
    world.say(CommandKind.SETTING, argument)
    tick(core, 10.0)
    assert told in world.published[-1].notice
    assert world.published[-1].settings_crc == fingerprint(Config())


def test_a_setting_is_not_void_because_a_stop_came_after_it(core: NavCore, world: World) -> None:
    world.say(CommandKind.SETTING, "robot.max_speed_mps=0.05")
    world.say(CommandKind.MANUAL, AHEAD, 10.0)
    world.say(CommandKind.STOP)
    tick(core, 10.0)
    assert core.config.robot.max_speed_mps == 0.05
    assert not world.published[-1].manual


def test_the_operators_target_beats_the_missions_until_he_gives_it_back(world: World) -> None:
    core = NavCore(Config(), load_mission(mission_path("bowling_pin")).root, world, world)
    world.say(CommandKind.TARGET, "bottle,0.3,0.07")
    tick(core, 10.0)
    assert world.published[-1].spec == TargetSpec("bottle", 0.3, 0.07)
    world.say(CommandKind.TARGET, "bottle,0.3,0.07,0.03")
    tick(core, 10.02)
    assert world.published[-1].spec.width_at_lidar_m == 0.03
    world.say(CommandKind.TARGET, "")
    tick(core, 10.05)
    assert world.published[-1].spec == TargetSpec("bowling_pin", 0.28, 0.08, 0.032)


@pytest.mark.parametrize(
    "argument",
    [
        "pin",
        "pin,0.3",
        "pin,a,b",
        "pin,9,0.1",
        "pin,nan,0.1",
        ",0.3,0.1",
        "pin,0.3,0.1,-1",
        "pin,0.3,0.1,0,0",
    ],
)
def test_a_target_without_a_size_is_none(argument: str) -> None:
    with pytest.raises(ConfigError, match="class,height_m,width_m"):
        target_of(argument)


def test_a_mission_and_a_motor_test_wait_until_no_mission_is_wanted(core: NavCore, world: World) -> None:
    world.say(CommandKind.GO)
    world.say(CommandKind.LOAD, "patrol")
    world.say(CommandKind.FIRMWARE, "TMOTOR,FL,80")
    tick(core, 10.0)
    assert core.operator.take_load() == ""
    assert core.operator.take_firmware_lines(10.0) == ()
    world.say(CommandKind.STOP)
    world.say(CommandKind.LOAD, "patrol")
    tick(core, 10.05)
    assert (core.operator.take_load(), core.operator.take_load()) == ("patrol", "")


def test_a_motor_turns_while_its_key_is_held_and_not_a_moment_longer_than_the_hold(
    core: NavCore, world: World
) -> None:
    lines: list[str] = []
    for n in range(40):
        now_s = 10.0 + n * PERIOD_S
        if n < 20 and n % 4 == 0:
            world.say(CommandKind.FIRMWARE, "TMOTOR,FL,80", now_s)
        tick(core, now_s)
        lines += core.operator.take_firmware_lines(now_s)
        if now_s <= 10.0 + 16 * PERIOD_S + MOTOR_HOLD_S - PERIOD_S:
            assert lines == ["TMOTOR,FL,80"]
    assert lines == ["TMOTOR,FL,80", "STOP"]


@pytest.mark.parametrize("word", [CommandKind.GO, CommandKind.STOP])
def test_go_and_stop_end_a_motor_test(core: NavCore, world: World, word: CommandKind) -> None:
    world.say(CommandKind.FIRMWARE, "TMOTOR,RR,-80", 10.0)
    tick(core, 10.0)
    world.say(word)
    tick(core, 10.05)
    assert core.operator.take_firmware_lines(10.05) == ("TMOTOR,RR,-80", "STOP")


def test_what_an_operator_did_is_the_same_in_a_replay(world: World, tmp_path: Path) -> None:
    pytest.importorskip("mcap")
    from target_nav.app.recording import RunRecorder, header_of
    from target_nav.app.replay import replay

    mission = load_mission(mission_path("bowling_pin"))
    path = tmp_path / "run.mcap"
    with RunRecorder(path, header_of(Config(), mission)) as recorder:
        core = NavCore(Config(), mission.root, world, world, recorder)
        for n in range(40):
            now_s = 10.0 + n * PERIOD_S
            if n == 5:
                world.say(CommandKind.SETTING, "robot.max_speed_mps=0.07", now_s)
            if 3 <= n < 20:
                world.say(CommandKind.MANUAL, "0.15,0.05,0.1", now_s - 0.01)
            if n == 25:
                world.say(CommandKind.GO, stamp_s=now_s)
            tick(core, now_s)
        core.close()
    assert any(snapshot.manual for snapshot in world.published)
    report = replay(path)
    assert (report.ticks, report.differences) == (40, ())
