"""The firmware in C++ against its imitation in Python: the same commands, the same lines and the same PWM.

Where both do the same by design they may differ by rounding only: 1 step of PWM, 1 mm/s, 1 mrad/s. Where the firmware
is better on purpose (docs/firmware.md names it) the difference has a test of its own.
"""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from target_nav.config import Config
from target_nav.hardware import protocol
from target_nav.hardware.protocol import EncLine, ErrorLine, MoveCommand, OdomLine, VersionLine
from target_nav.sim.arena import Arena, Bounds
from target_nav.sim.contact import ContactMonitor
from target_nav.sim.drive import Drive
from target_nav.sim.firmware import FirmwareEmulator
from target_nav.sim.firmware_types import Firmware, Mode, Pwm
from target_nav.sim.host_firmware import HostFirmware
from target_nav.sim.wheels import Base
from target_nav.sim.world import World
from target_nav.state.types import Pose2D

CONFIG = Config()
ROBOTS = {
    "mecanum": CONFIG,
    "differential": CONFIG.override({"robot.drive": "differential", "robot.max_speed_mps": 0.5}),
}
STEP_S = 0.01
CONTROL_STEPS = 2
STEPS_A_COMMAND = 4
HALL = Arena("hall", Bounds(-500, -500, 500, 500), Pose2D())

PWM_TOLERANCE = 1
ODOM_TOLERANCE = 1


def plant(config: Config = CONFIG) -> Drive:
    contact = ContactMonitor(World(HALL), 0.0, 0.0, 0.0)
    return Drive(config.robot, config.drive_sim, Pose2D(), contact, np.random.default_rng(1), STEP_S)


class Pair:
    """Both firmwares on one robot: the imitation drives it, the other one gets the same commands and counts."""

    def __init__(self, config: Config) -> None:
        self.imitation = FirmwareEmulator(config)
        self.firmware = HostFirmware(config)
        self.drive = plant(config)
        self.steps = 0

    def send(self, line: bytes) -> None:
        now_s = self.steps * STEP_S
        self.imitation.feed(line, now_s)
        self.firmware.feed(line, now_s)

    def run(self, steps: int) -> None:
        for _ in range(steps):
            self.steps += 1
            self.drive.step(self.imitation.pwm)
            for firmware in (self.imitation, self.firmware):
                firmware.step(self.steps * STEP_S, self.drive.ticks)
            self.compare()

    def compare(self) -> None:
        assert self.firmware.mode is self.imitation.mode
        # A velocity that ends a motor's trial: until the next control step the imitation leaves that motor on.
        decided = self.firmware.mode is not Mode.VELOCITY or self.steps % CONTROL_STEPS == 0
        assert not decided or all(
            abs(a - b) <= PWM_TOLERANCE for a, b in zip(self.firmware.pwm, self.imitation.pwm)
        ), (
            self.steps * STEP_S,
            self.firmware.pwm,
            self.imitation.pwm,
        )
        assert_same_lines(self.firmware.take_output(), self.imitation.take_output())


def assert_same_lines(ours: bytes, theirs: bytes) -> None:
    assert ours.count(b"\n") == theirs.count(b"\n"), (ours, theirs)
    for mine, other in zip(ours.splitlines(), theirs.splitlines()):
        a, b = protocol.parse_line(mine), protocol.parse_line(other)
        assert a is not None
        if isinstance(a, OdomLine) and isinstance(b, OdomLine):
            differences = (a.vx_mmps - b.vx_mmps, a.vy_mmps - b.vy_mmps, a.wz_mradps - b.wz_mradps)
            assert max(map(abs, differences)) <= ODOM_TOLERANCE, (mine, other)
        elif isinstance(a, VersionLine) and isinstance(b, VersionLine):
            assert a.protocol == b.protocol
        else:
            assert mine == other


def near_dead_band(line: bytes, config: Config) -> bool:
    """A wheel's speed at the very edge, where a rounding error of floating point decides."""
    command = protocol.parse_command(line)
    if not isinstance(command, protocol.VelocityCommand):
        return False
    twist = command.to_twist()
    wheels = Base.of(config.robot).wheel_speeds(twist.vx_mps, twist.vy_mps, twist.wz_radps)
    edge = config.drive_sim.deadband_mps
    return any(math.isclose(abs(wheel), edge, abs_tol=1e-5) for wheel in wheels)


velocities = st.builds(
    lambda vx, vy, wz: f"VEL,{vx},{vy},{wz}\n".encode(),
    st.integers(-400, 400),
    st.integers(-400, 400),
    st.integers(-2000, 2000),
)
others = st.sampled_from(
    [
        b"STOP\n",
        b"CALIB\r\n",
        b"VERSION\n",
        b"TMOTOR,RL,-120\n",
        b"VEL,5000,5000,-20000\n",
        b"VEL,1,\n",
        b"\xff\n",
        b"",
    ]
)


@settings(max_examples=30, deadline=None)
@given(
    st.sampled_from(sorted(ROBOTS)),
    st.lists(st.tuples(st.integers(1, 60), st.one_of(velocities, velocities, others)), max_size=12),
)
def test_the_same_commands_give_the_same_pwm_and_lines(robot: str, script: list[tuple[int, bytes]]) -> None:
    config = ROBOTS[robot]
    assume(not any(near_dead_band(line, config) for _, line in script))
    pair = Pair(config)
    for steps, line in script:
        pair.send(line)
        pair.run(steps)
    pair.run(40)


def test_a_minute_of_driving_does_not_drift_apart() -> None:
    pair = Pair(CONFIG)
    for i in range(60 * 100 // STEPS_A_COMMAND):
        t = i * STEPS_A_COMMAND * STEP_S
        vx, vy, wz = round(250 * math.sin(t)), round(150 * math.sin(0.7 * t)), round(800 * math.cos(0.31 * t))
        line = f"VEL,{vx},{vy},{wz}\n".encode()
        if not near_dead_band(line, CONFIG):
            pair.send(line)
        pair.run(STEPS_A_COMMAND)


damaged = st.builds(
    lambda line, at, new: line[: at % (len(line) + 1)] + new + line[at % (len(line) + 1) + 1 :],
    st.sampled_from(
        [
            b"VEL,200,0,300",
            b"VEL,-5000,5000,20000",
            b"FWD,100,1719",
            b"TMOTOR,FL,100",
            b"STOP",
            b"CALIB",
            b"VERSION",
            b"CCW,5000,2147483647",
        ]
    ),
    st.integers(0, 30),
    st.one_of(st.binary(max_size=3), st.sampled_from([b",", b"-", b"+", b"0", b"00000000", b"\r"])),
)


@settings(deadline=None)
@given(st.one_of(damaged, st.binary(max_size=120)).filter(lambda line: b"\n" not in line))
def test_every_line_is_understood_and_answered_alike(line: bytes) -> None:
    command = protocol.parse_command(line)
    # Too slow for its motors: refused, where the imitation waits for its time-out.
    assume(not (isinstance(command, MoveCommand) and command.speed_mmps < 20))
    imitation, firmware = FirmwareEmulator(CONFIG), HostFirmware(CONFIG)
    for each in (imitation, firmware):
        each.feed(line + b"\n", 0.0)
    assert firmware.mode is imitation.mode
    assert_same_lines(firmware.take_output(), imitation.take_output())


def closed_loop(firmware: Firmware, line: bytes, seconds: float) -> Drive:
    drive = plant()
    firmware.feed(line, 0.0)
    for step in range(1, round(seconds / STEP_S) + 1):
        drive.step(firmware.pwm)
        firmware.step(step * STEP_S, drive.ticks)
    return drive


@pytest.mark.parametrize("move", protocol.MOVES)
def test_moves_end_nearer_to_their_counts(move: str) -> None:
    line = f"{move},200,1719\n".encode()
    errors = []
    for firmware in (HostFirmware(CONFIG), FirmwareEmulator(CONFIG)):
        drive = closed_loop(firmware, line, 12.0)
        assert firmware.mode is Mode.IDLE
        errors.append(abs(sum(map(abs, drive.ticks)) / 4 - 1719))
    slowed, not_slowed = errors
    assert slowed <= 15  # 3 mm
    assert slowed < not_slowed <= 120


def test_moves_go_the_same_way() -> None:
    for move in protocol.MOVES:
        line = f"{move},100,1000\n".encode()
        ours, theirs = (closed_loop(f, line, 12.0) for f in (HostFirmware(CONFIG), FirmwareEmulator(CONFIG)))
        assert (ours.x_m, ours.y_m, ours.yaw_rad) == pytest.approx(
            (theirs.x_m, theirs.y_m, theirs.yaw_rad), abs=0.06
        )


def stream_against_a_held_wheel(firmware: Firmware, seconds: float) -> tuple[Pwm, list[ErrorLine]]:
    """One wheel does not turn; VEL is streamed on."""
    errors: list[ErrorLine] = []
    for step in range(1, round(seconds / STEP_S) + 1):
        if step % 5 == 0:
            firmware.feed(b"VEL,100,0,0\n", step * STEP_S)
        firmware.step(step * STEP_S, (step * 5, step * 5, 0, step * 5))
        for line in firmware.take_output().splitlines():
            message = protocol.parse_line(line)
            assert message is not None
            if isinstance(message, ErrorLine):
                errors.append(message)
            elif isinstance(message, EncLine):
                assert firmware.mode is not Mode.VELOCITY
    return firmware.pwm, errors


def test_both_find_a_stalled_wheel_and_the_firmware_then_waits_for_a_stop() -> None:
    pwm, errors = stream_against_a_held_wheel(HostFirmware(CONFIG), 6.0)
    imitated_pwm, imitated_errors = stream_against_a_held_wheel(FirmwareEmulator(CONFIG), 6.0)
    assert errors[0] == imitated_errors[0] == ErrorLine("STALL", "RL does not turn for 5 s, stopped")
    assert {error.code for error in errors[1:]} == {"HELD"}
    assert pwm == (0, 0, 0, 0) != imitated_pwm
