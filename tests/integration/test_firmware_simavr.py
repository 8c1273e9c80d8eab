"""The image that is flashed, on a simulated ATmega2560 in real time, and the real driver at its serial line."""

from __future__ import annotations

import itertools
import random
import signal
import statistics
import time
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import TypeVar

import pytest

from target_nav.hardware import protocol
from target_nav.hardware.arduino_bridge import ArduinoBridge
from target_nav.hardware.protocol import AckLine, DeviceLine, EncLine, ErrorLine, OdomLine, VersionLine
from target_nav.state.types import Twist2D
from tests.utils.firmware import STANDING, AvrBench
from tests.utils.processes import ros_environment, running, wait_until

pytestmark = [pytest.mark.slow, pytest.mark.linux]

PERIOD_S = 0.05

STOP_LIMIT_S = 1.5
"""The firmware stops after 0.2 s of its own time; the rest is for a machine on which that passes slowly."""


Line = TypeVar("Line")


class Robot:
    """The bench and the bridge, with everything heard."""

    def __init__(self) -> None:
        self.bench = AvrBench()
        self.heard: list[tuple[float, DeviceLine]] = []
        self.bridge = ArduinoBridge(
            self.bench.port, 115200, lambda line, stamp_s: self.heard.append((stamp_s, line))
        )
        self.bridge.open()
        wait_until(lambda: bool(self.of(EncLine)), "the firmware's first line")

    def of(self, kind: type[Line]) -> list[Line]:
        return [line for _, line in list(self.heard) if isinstance(line, kind)]

    def drive(self, twist: Twist2D, seconds: float) -> float:
        """Send at 20 Hz; the time of the last line."""
        begin_s = sent_s = time.monotonic()
        while sent_s < begin_s + seconds:
            self.bridge.send_velocity(twist)
            sent_s = time.monotonic()
            time.sleep(PERIOD_S)
        return sent_s

    def drive_until(self, condition: Callable[[], bool], twist: Twist2D, what: str) -> None:
        """Send at 20 Hz until it is so: how fast the chip's time passes is up to the machine."""

        def check() -> bool:
            self.bridge.send_velocity(twist)
            time.sleep(PERIOD_S)
            return condition()

        wait_until(check, what, 60.0)

    @property
    def steady(self) -> list[OdomLine]:
        """ODOM since velocity mode was entered, after the integral has settled, which takes a second."""
        lines = [line for _, line in list(self.heard)]
        begin = max((i for i, line in enumerate(lines) if not isinstance(line, OdomLine)), default=-1)
        return [line for line in lines[begin + 21 :] if isinstance(line, OdomLine)]

    def close(self) -> dict[str, float]:
        self.bridge.close()
        return self.bench.close()


@pytest.fixture
def robot() -> Iterator[Robot]:
    robot = Robot()
    try:
        yield robot
    finally:
        figures = robot.close()
    assert figures["crashed"] == 0


def test_it_drives_as_it_is_told_and_reports_it_20_times_a_second(robot: Robot) -> None:
    robot.drive_until(
        lambda: len(robot.steady) >= 60, Twist2D(0.2, 0.0, 0.3), "three seconds of steady driving"
    )
    settled = robot.steady
    assert statistics.mean(line.vx_mmps for line in settled) == pytest.approx(200, abs=4)
    # Counts and the time they belong to are read together: 2 ms between them would be noise of 4 %.
    assert statistics.pstdev(line.vx_mmps for line in settled) < 3.0
    assert statistics.mean(line.vy_mmps for line in settled) == pytest.approx(0, abs=4)
    assert statistics.mean(line.wz_mradps for line in settled) == pytest.approx(300, abs=12)
    stamps = [line.device_us for line in settled if line.device_us is not None]
    intervals = [b - a for a, b in itertools.pairwise(stamps)]
    assert statistics.mean(intervals) == pytest.approx(50_000, rel=0.001)
    assert 45_000 < min(intervals) <= max(intervals) < 55_000
    statistics_ = robot.bridge.statistics
    assert (statistics_.garbled_lines, statistics_.overlong_lines) == (0, 0)
    # Slower outer wheels would show mirrored motors or encoders.
    fl, fr, rl, rr = robot.bench.duty
    assert min(fr, rr) > max(fl, rl) > 0


def test_strafing_turns_each_wheel_the_right_way(robot: Robot) -> None:
    robot.drive_until(lambda: len(robot.steady) > 5, Twist2D(0.0, 0.15, 0.0), "steady strafing")
    assert tuple((duty > 0) - (duty < 0) for duty in robot.bench.duty) == (-1, 1, 1, -1)
    assert robot.steady[-1].vy_mmps == pytest.approx(150, abs=25)


def test_without_vel_the_motors_are_off_after_200_ms(robot: Robot) -> None:
    robot.drive_until(lambda: min(robot.bench.duty) > 0, Twist2D(0.2, 0.0, 0.0), "turning wheels")
    last_s = robot.drive(Twist2D(0.2, 0.0, 0.0), 0.5)
    wait_until(lambda: robot.bench.duty == STANDING, "standing")
    stopped_after_s = robot.bench.drives[-1][0] - last_s
    print(f"stopped {stopped_after_s * 1e3:.0f} ms after the last VEL")
    assert 0.0 < stopped_after_s < STOP_LIMIT_S
    wait_until(lambda: bool(robot.of(ErrorLine)), "the watchdog's line")
    assert robot.of(ErrorLine)[-1:] == [ErrorLine("WATCHDOG", "no VEL for 200 ms, stopped")]


def test_stop_turns_the_motors_off_at_once(robot: Robot) -> None:
    robot.drive_until(lambda: min(robot.bench.duty) > 0, Twist2D(0.2, 0.0, 0.0), "turning wheels")
    sent_s = time.monotonic()
    robot.bridge.send_stop()
    wait_until(lambda: robot.bench.duty == STANDING, "standing")
    print(f"stopped {(robot.bench.drives[-1][0] - sent_s) * 1e3:.1f} ms after STOP was sent")
    assert robot.bench.drives[-1][0] - sent_s < STOP_LIMIT_S
    wait_until(lambda: AckLine("STOP") in robot.of(AckLine), "the answer")


def test_a_position_move_ends_at_its_counts(robot: Robot) -> None:
    robot.bridge.send(protocol.encode_command(protocol.MoveCommand("CCW", 200, 1000)))
    wait_until(lambda: bool(robot.bench.drives), "the move's begin")
    wait_until(lambda: robot.bench.duty == STANDING, "the move's end")
    seen = len(robot.of(EncLine))
    # The wheels run out for half a second.
    wait_until(lambda: len(robot.of(EncLine)) > seen + 10, "half a second of the chip's time")
    last = robot.of(EncLine)[-1]
    assert isinstance(last, EncLine)
    fl, fr, rl, rr = last.ticks
    assert (fl < 0, fr > 0, rl < 0, rr > 0) == (True, True, True, True)
    assert sum(map(abs, last.ticks)) / 4 == pytest.approx(1000, abs=20)


def test_garbage_moves_nothing_and_the_next_line_is_understood(robot: Robot) -> None:
    garbage = random.Random(1)
    for _ in range(200):
        robot.bridge.send(garbage.randbytes(100))
        time.sleep(0.01)
    assert robot.bench.drives == []
    robot.bridge.send(b"\nVERSION\n")
    wait_until(lambda: bool(robot.of(VersionLine)), "an answer")
    assert robot.bridge.statistics.garbled_lines == 0
    robot.drive_until(lambda: min(robot.bench.duty) > 0, Twist2D(0.1, 0.0, 0.0), "turning wheels")


def test_a_held_wheel_stops_all_until_there_was_a_stop(robot: Robot) -> None:
    robot.bench.tell("jam RL")
    stalled = ErrorLine("STALL", "RL does not turn for 5 s, stopped")
    robot.drive_until(lambda: stalled in robot.of(ErrorLine), Twist2D(0.1, 0.0, 0.0), "the stall")
    wait_until(lambda: robot.bench.duty == STANDING, "standing")
    robot.drive(Twist2D(0.1, 0.0, 0.0), 0.3)
    assert robot.bench.duty == STANDING
    robot.bench.tell("free RL")
    robot.drive(Twist2D(0.1, 0.0, 0.0), 0.3)
    assert robot.bench.duty == STANDING
    robot.bridge.send_stop()
    robot.drive_until(lambda: min(robot.bench.duty) > 0, Twist2D(0.1, 0.0, 0.0), "turning wheels")


def test_a_motor_driver_that_is_lost_is_held_off_and_found_again(robot: Robot) -> None:
    robot.drive_until(lambda: min(robot.bench.duty) > 0, Twist2D(0.2, 0.0, 0.0), "turning wheels")
    robot.bench.tell("driver off")
    # Its registers cannot be written any more: OE has to hold the motors.
    robot.drive_until(lambda: robot.bench.duty == STANDING, Twist2D(0.2, 0.0, 0.1), "motors held off")
    wait_until(lambda: any(line.code == "DRIVER" for line in robot.of(ErrorLine)), "the firmware's word")
    robot.drive(Twist2D(0.2, 0.0, 0.1), 0.5)
    assert robot.bench.duty == STANDING
    assert [line for line in robot.of(ErrorLine) if line.code == "DRIVER"] == [
        ErrorLine("DRIVER", "motor driver does not answer, stopped")
    ]
    robot.bench.tell("driver on")
    robot.drive_until(lambda: min(robot.bench.duty) > 0, Twist2D(0.2, 0.0, 0.0), "turning wheels")


def test_a_main_loop_that_hangs_is_cut_off_by_the_timer(robot: Robot) -> None:
    robot.drive_until(lambda: min(robot.bench.duty) > 0, Twist2D(0.2, 0.0, 0.0), "turning wheels")
    robot.bench.tell("hang")
    told_s = time.monotonic()
    wait_until(lambda: robot.bench.duty == STANDING, "standing")
    stopped_after_s = robot.bench.drives[-1][0] - told_s
    print(f"stopped {stopped_after_s * 1e3:.0f} ms after the main loop hung")
    assert 0.0 < stopped_after_s < STOP_LIMIT_S
    time.sleep(0.3)  # for what was on its way
    heard = len(robot.heard)
    robot.drive(Twist2D(0.2, 0.0, 0.0), 0.5)
    assert robot.bench.duty == STANDING
    assert len(robot.heard) == heard


def test_the_stack_never_comes_near_what_is_left_of_the_ram() -> None:
    robot = Robot()
    robot.drive(Twist2D(0.3, 0.2, 0.5), 1.0)
    robot.bridge.send(b"garbage\nVERSION\nFWD,100,100\n" + b"x" * 200 + b"\n")
    robot.drive(Twist2D(0.1, 0.0, 0.0), 0.5)
    figures = robot.close()
    print(figures)
    # Of 8192 bytes a fifth is static.
    assert 100 < figures["stack_bytes"] < 2000
    assert figures["bytes_lost"] == 0


@pytest.mark.ros
def test_cmd_vel_turns_the_wheels_and_a_killed_node_stops_them(tmp_path: Path) -> None:
    from target_nav.app.ros_convert import twist_to_msg
    from target_nav.app.ros_support import RosNode, command_qos

    ros_environment()
    bench = AvrBench()
    try:
        with running("target_nav.app.arduino_node", "--port", bench.port, folder=tmp_path) as node:
            from geometry_msgs.msg import Twist

            with RosNode("test_host") as ros:
                publish = ros.publisher(Twist, "/cmd_vel", command_qos())
                ros.start()
                wait_until(lambda: ros.node.count_subscribers("/cmd_vel") > 0, "discovery")

                def drives() -> bool:
                    publish(twist_to_msg(Twist2D(0.2, 0.0, 0.0)))
                    time.sleep(PERIOD_S)
                    return min(bench.duty) > 0

                wait_until(drives, "turning wheels")
                node.process.send_signal(signal.SIGKILL)
                killed_s = time.monotonic()
                wait_until(lambda: bench.duty == STANDING, "standing")
                stopped_after_s = bench.drives[-1][0] - killed_s
                print(f"stopped {stopped_after_s * 1e3:.0f} ms after the node was killed")
                assert stopped_after_s < STOP_LIMIT_S
    finally:
        bench.close()
