"""What is said reaches the nav process's end of the ring, and what is not heard is known."""

from __future__ import annotations

import os
from collections.abc import Iterator

import pytest

from target_nav.gui.commands import ACK_LIMIT_S, REPEAT_STOP_S, CommandPort
from target_nav.ipc import channels
from target_nav.state.types import CommandKind, TargetSpec, Twist2D

pytestmark = pytest.mark.linux


class Clock:
    now_s = 100.0

    def __call__(self) -> float:
        return self.now_s


@pytest.fixture
def prefix() -> Iterator[str]:
    name = f"t{os.getpid()}-gui-commands"
    yield name
    channels.remove(name)


@pytest.fixture
def clock() -> Clock:
    return Clock()


@pytest.fixture
def port(prefix: str, clock: Clock) -> Iterator[CommandPort]:
    made = CommandPort(prefix, clock)
    yield made
    made.close()


def test_a_word_is_acknowledged_when_the_nav_process_has_read_it(
    prefix: str, port: CommandPort, clock: Clock
) -> None:
    with channels.open_command_reader(prefix) as nav:
        port.go()
        assert port.poll().acknowledged_s is None
        assert port.waiting
        assert [command.kind for command in nav.pop_all()] == [CommandKind.GO]
        clock.now_s += 0.03
        said = port.poll()
        assert said.acknowledged_s == pytest.approx(0.03)
        assert said.text(clock.now_s) == "GO acknowledged (30 ms)"
        assert not port.waiting


def test_a_word_that_nobody_reads_in_time_is_late(prefix: str, port: CommandPort, clock: Clock) -> None:
    with channels.open_command_reader(prefix):
        port.go()
        clock.now_s += ACK_LIMIT_S + 0.001
        assert port.poll().text(clock.now_s) == "GO NOT ACKNOWLEDGED"


def test_without_a_nav_process_nothing_is_sent_and_that_is_told(port: CommandPort, clock: Clock) -> None:
    said = port.go()
    assert "NOT SENT" in said.text(clock.now_s)
    assert said.is_late(clock.now_s)


def test_a_stop_is_said_again_until_it_is_heard(prefix: str, port: CommandPort, clock: Clock) -> None:
    assert port.stop().problem
    with channels.open_command_reader(prefix) as nav:
        clock.now_s += REPEAT_STOP_S + 0.01
        port.poll()
        assert [command.kind for command in nav.pop_all()] == [CommandKind.STOP]
        assert port.poll().acknowledged_s is not None
        clock.now_s += REPEAT_STOP_S + 0.01
        port.poll()
        assert nav.pop_all() == []


def test_a_go_is_never_said_again(prefix: str, port: CommandPort, clock: Clock) -> None:
    port.go()
    with channels.open_command_reader(prefix) as nav:
        for _ in range(20):
            clock.now_s += 0.1
            port.poll()
        assert nav.pop_all() == []


def test_two_screens_take_turns_word_by_word(prefix: str, port: CommandPort) -> None:
    other = CommandPort(prefix)
    with channels.open_command_reader(prefix) as nav:
        port.go()
        other.stop()
        port.drive(Twist2D(0.1, 0.0, -0.2))
        assert [command.kind.name for command in nav.pop_all()] == ["GO", "STOP", "MANUAL"]
    other.close()


def test_arguments_arrive_as_the_nav_process_reads_them(prefix: str, port: CommandPort) -> None:
    with channels.open_command_reader(prefix) as nav:
        port.setting("approach.stand_off_m", 0.12)
        port.target(TargetSpec("bottle", 0.3, 0.07))
        port.target(None)
        port.load("/missions/patrol.xml")
        port.firmware("TMOTOR,FL,80")
        port.drive(Twist2D(0.1, 0.0, -0.2))
        assert [command.argument for command in nav.pop_all()] == [
            *("approach.stand_off_m=0.12", "bottle,0.3,0.07,0", "", "/missions/patrol.xml", "TMOTOR,FL,80"),
            "0.1,0,-0.2",
        ]


def test_a_word_that_is_too_long_is_a_problem_and_no_crash(prefix: str, port: CommandPort) -> None:
    with channels.open_command_reader(prefix) as nav:
        assert port.load("x" * 500).problem
        assert nav.pop_all() == []
