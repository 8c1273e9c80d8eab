"""The firmware's arithmetic and its reader against the same written down once more in Python.

The reader against `hardware.protocol`, which is the contract of the line; kinematics and control against the formulas
in floating point. The firmware counts in whole numbers, so they may differ by rounding: 1 of 255 PWM, 1 mm/s, 1 mrad/s.
"""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from target_nav.config import Config
from target_nav.hardware import protocol
from target_nav.hardware.protocol import AckLine, ErrorLine, OdomLine, VersionLine
from target_nav.sim.arena import Arena, Bounds
from target_nav.sim.contact import ContactMonitor
from target_nav.sim.drive import Drive
from target_nav.sim.firmware_types import Mode
from target_nav.sim.host_firmware import HostFirmware
from target_nav.sim.wheels import TICK_M, Base, top_wheel_speed_mps
from target_nav.sim.world import World
from target_nav.state.types import Pose2D

CONFIG = Config()
ROBOTS = {
    "mecanum": CONFIG,
    "differential": CONFIG.override({"robot.drive": "differential", "robot.max_speed_mps": 0.5}),
}
STANDING = (0, 0, 0, 0)
STEP_S = 0.01
CONTROL_S = 0.02
TELEMETRY_S = 0.05

KP = 0.5
KI_PER_S = 4.0

linear = st.integers(-400, 400)
angular = st.integers(-2000, 2000)


def answer(firmware: HostFirmware) -> list[protocol.DeviceLine]:
    lines = [protocol.parse_line(line) for line in firmware.take_output().splitlines()]
    assert None not in lines
    return [line for line in lines if line is not None]


# --- the reader ---

damaged = st.builds(
    lambda line, at, new: line[: at % (len(line) + 1)] + new + line[at % (len(line) + 1) + 1 :],
    st.sampled_from(
        [b"VEL,200,0,300", b"VEL,-5000,5000,20000", b"FWD,100,1719", b"TMOTOR,FL,100", b"STOP", b"CALIB", b"VERSION",
         b"CCW,5000,2147483647"]
    ),
    st.integers(0, 30),
    st.one_of(st.binary(max_size=3), st.sampled_from([b",", b"-", b"+", b"0", b"00000000", b"\r"])),
)  # fmt: skip


def expected_answer(line: bytes) -> tuple[Mode, protocol.DeviceLine | None]:
    """The mode that a line leads to from IDLE, and what is said to it; None: nothing."""
    command = protocol.parse_command(line)
    if command is None:
        shown = "".join(chr(byte) if 0x20 <= byte <= 0x7E else "?" for byte in line.rstrip(b"\r")[:40])
        return Mode.IDLE, protocol.parse_line(f"ERROR,BADCMD,{shown}".encode())
    if isinstance(command, protocol.VelocityCommand):
        return Mode.VELOCITY, None
    if isinstance(command, protocol.MoveCommand):
        if command.speed_mmps < 20:
            refusal = f"{command.move}: motors do not turn below 20 mm/s"
            return Mode.IDLE, ErrorLine("BADCMD", refusal)
        return Mode.MOVE, AckLine(command.move)
    if isinstance(command, protocol.MotorCommand):
        return Mode.MOTOR, AckLine("TMOTOR")
    if isinstance(command, protocol.VersionCommand):
        return Mode.IDLE, VersionLine(protocol.PROTOCOL_VERSION, "")
    return Mode.IDLE, AckLine("STOP" if isinstance(command, protocol.StopCommand) else "CALIB")


@given(st.one_of(damaged, st.binary(max_size=97)).filter(lambda line: b"\n" not in line))
def test_both_ends_take_the_same_lines_for_commands(line: bytes) -> None:
    firmware = HostFirmware(CONFIG)
    firmware.feed(line + b"\n", 0.0)
    if not line.rstrip(b"\r"):
        assert (firmware.mode, answer(firmware)) == (Mode.IDLE, [])
        return
    mode, said = expected_answer(line)
    heard = answer(firmware)
    if isinstance(said, VersionLine):
        assert [type(one) for one in heard] == [VersionLine]
    else:
        assert heard == ([said] if said is not None else [])
    assert firmware.mode is mode


# --- kinematics and control ---


@given(st.sampled_from(sorted(ROBOTS)), linear, linear, angular)
def test_a_velocity_becomes_the_wheels_speeds(robot: str, vx: int, vy: int, wz: int) -> None:
    """The first control step of standing wheels: feed-forward, and PI of an error that is the whole speed."""
    config = ROBOTS[robot]
    top_mps = top_wheel_speed_mps(config.robot)
    wheels = Base.of(config.robot).wheel_speeds(vx / 1e3, vy / 1e3, wz / 1e3)
    slowed = min(1.0, top_mps / max(max(map(abs, wheels)), 1e-9))
    firmware = HostFirmware(config)
    firmware.feed(f"VEL,{vx},{vy},{wz}\n".encode(), 0.0)
    pwm = firmware.step(CONTROL_S, STANDING)
    for given_pwm, wheel in zip(pwm, wheels):
        speed = wheel * slowed
        if math.isclose(abs(speed), config.drive_sim.deadband_mps, abs_tol=1e-5):
            continue  # at the very edge rounding decides
        driven = speed if abs(speed) >= config.drive_sim.deadband_mps else 0.0
        wanted = 255 * driven * (1 + KP + KI_PER_S * CONTROL_S) / top_mps
        assert given_pwm == pytest.approx(max(-255, min(255, wanted)), abs=1)


@given(st.sampled_from(sorted(ROBOTS)), st.tuples(*[st.integers(-150, 150)] * 4))
def test_odom_is_what_the_counts_say(robot: str, counts: tuple[int, int, int, int]) -> None:
    config = ROBOTS[robot]
    fl, fr, rl, rr = (count * TICK_M / TELEMETRY_S for count in counts)
    vx, vy, wz = Base.of(config.robot).body_speeds((fl, fr, rl, rr))
    firmware = HostFirmware(config)
    firmware.feed(b"VEL,100,0,0\n", 0.0)
    firmware.step(TELEMETRY_S, counts)
    (line,) = answer(firmware)
    assert isinstance(line, OdomLine)
    assert (line.vx_mmps, line.vy_mmps, line.wz_mradps) == pytest.approx(
        (1e3 * vx, 1e3 * vy, 1e3 * wz), abs=1
    )


# --- with the simulator's plant ---


def plant(config: Config = CONFIG) -> Drive:
    contact = ContactMonitor(World(Arena("hall", Bounds(-500, -500, 500, 500), Pose2D())), 0.0, 0.0, 0.0)
    return Drive(config.robot, config.drive_sim, Pose2D(), contact, np.random.default_rng(1), STEP_S)


def closed_loop(line: bytes, seconds: float) -> tuple[Drive, HostFirmware]:
    drive, firmware = plant(), HostFirmware(CONFIG)
    firmware.feed(line, 0.0)
    for step in range(1, round(seconds / STEP_S) + 1):
        drive.step(firmware.pwm)
        firmware.step(step * STEP_S, drive.ticks)
    return drive, firmware


@pytest.mark.parametrize("move", protocol.MOVES)
def test_a_move_ends_at_its_counts_and_goes_its_way(move: str) -> None:
    drive, firmware = closed_loop(f"{move},200,1719\n".encode(), 12.0)
    assert firmware.mode is Mode.IDLE
    assert sum(map(abs, drive.ticks)) / 4 == pytest.approx(1719, abs=15)  # 3 mm
    directions = {
        "FWD": (1, 0, 0), "BWD": (-1, 0, 0), "LEFT": (0, 1, 0), "RIGHT": (0, -1, 0), "CCW": (0, 0, 1), "CW": (0, 0, -1)
    }  # fmt: skip
    way_m = 1719 * TICK_M
    x, y, turn = directions[move]
    lever_m = Base.of(CONFIG.robot).lever_m
    # Strafing is over-reported by up to 10 %, and the heading drifts by up to 0.01 rad a metre.
    assert (drive.x_m, drive.y_m, drive.yaw_rad) == pytest.approx(
        (x * way_m, y * way_m, turn * way_m / lever_m), abs=0.04
    )


def test_a_minute_of_driving_is_followed() -> None:
    drive, firmware = plant(), HostFirmware(CONFIG)
    base, errors = Base.of(CONFIG.robot), []
    for step in range(60 * 100):
        t = step * STEP_S
        wanted = (0.25 * math.sin(0.5 * t), 0.15 * math.sin(0.35 * t), 0.8 * math.cos(0.31 * t))
        if step % 4 == 0:
            firmware.feed(
                f"VEL,{wanted[0] * 1e3:.0f},{wanted[1] * 1e3:.0f},{wanted[2] * 1e3:.0f}\n".encode(), t
            )
        before = drive.ticks
        drive.step(firmware.pwm)
        firmware.step(t + STEP_S, drive.ticks)
        if t > 1.0:
            fl, fr, rl, rr = ((b - a) * TICK_M / STEP_S for a, b in zip(before, drive.ticks))
            errors.append(np.subtract(base.body_speeds((fl, fr, rl, rr)), wanted))
    # Two ticks in 10 ms are 38 mm/s of quantisation; the mean over the minute has none of it.
    assert np.abs(np.mean(errors, axis=0)) == pytest.approx((0.0, 0.0, 0.0), abs=0.005)
    assert np.sqrt(np.mean(np.square(errors), axis=0)).max() < 0.1


def test_a_stalled_wheel_waits_for_a_stop() -> None:
    """Who streams velocities would set the wheels going again 50 ms later."""
    firmware, said = HostFirmware(CONFIG), []
    for step in range(1, 601):
        if step % 5 == 0:
            firmware.feed(b"VEL,100,0,0\n", step * STEP_S)
        firmware.step(step * STEP_S, (step * 5, step * 5, 0, step * 5))
        said += [line for line in answer(firmware) if isinstance(line, ErrorLine)]
    assert said[0] == ErrorLine("STALL", "RL does not turn for 5 s, stopped")
    assert {error.code for error in said[1:]} == {"HELD"}
    assert firmware.pwm == STANDING
    firmware.feed(b"STOP\nVEL,100,0,0\n", 6.01)
    assert min(firmware.step(6.03, (3005, 3005, 0, 3005))) > 0
