"""The firmware's library from Python: what it is built from, how it is found, and what it does with a robot."""

from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from target_nav.config import Config
from target_nav.errors import ConfigError
from target_nav.hardware import protocol
from target_nav.sim import firmware_library, host_firmware
from target_nav.sim.firmware_types import Firmware, Mode
from target_nav.sim.host_firmware import HostFirmware

CONFIG = Config()
STANDING = (0, 0, 0, 0)


def lines_of(firmware: Firmware) -> list[bytes]:
    data = firmware.take_output()
    assert data == b"" or data.endswith(b"\n")
    return data.split(b"\n")[:-1]


def test_what_is_flashed_is_the_configured_robot() -> None:
    assert firmware_library.reference_params().as_dict() == host_firmware.params_of(CONFIG).as_dict()


def test_it_speaks_the_protocol_of_this_version() -> None:
    firmware = HostFirmware(CONFIG)
    firmware.feed(b"VERSION\n", 0.0)
    (line,) = lines_of(firmware)
    version = firmware_library.firmware_version()
    assert protocol.parse_line(line) == protocol.VersionLine(protocol.PROTOCOL_VERSION, version)


def test_a_velocity_begins_with_the_next_control_step_and_stop_ends_it_at_once() -> None:
    firmware = HostFirmware(CONFIG)
    firmware.feed(b"VEL,200,0,0\n", 0.0)
    assert (firmware.mode, firmware.pwm) == (Mode.VELOCITY, STANDING)
    assert firmware.step(0.01, STANDING) == STANDING
    assert min(firmware.step(0.02, STANDING)) > 0
    firmware.feed(b"STOP\n", 0.02)
    assert (firmware.mode, firmware.pwm) == (Mode.IDLE, STANDING)


def test_output_is_there_until_it_is_taken() -> None:
    firmware = HostFirmware(CONFIG)
    assert not firmware.has_output
    firmware.feed(b"STOP\n", 0.0)
    assert firmware.has_output
    assert firmware.take_output() == b"ACK,STOP\n"
    assert not firmware.has_output
    assert firmware.take_output() == b""


def test_nobody_reads_and_what_is_left_are_whole_lines() -> None:
    firmware = HostFirmware(CONFIG)
    for step in range(1000):
        firmware.step(step * 0.05, STANDING)
    lines = lines_of(firmware)
    assert 5 < len(lines) < 50
    assert set(lines) == {b"ENC,0,0,0,0"}


def test_time_begins_at_the_given_start() -> None:
    firmware = HostFirmware(CONFIG, start_s=123_456.789)
    firmware.step(123_456.789 + 0.04, STANDING)
    assert not firmware.has_output
    firmware.step(123_456.789 + 0.05, STANDING)
    assert lines_of(firmware) == [b"ENC,0,0,0,0"]


def test_counts_wrap_round_at_32_bit() -> None:
    firmware = HostFirmware(CONFIG)
    firmware.step(0.05, (2**31, 2**32 + 5, -(2**31) - 1, 0))
    assert lines_of(firmware) == [b"ENC,-2147483647,5,2147483647,0"]


def test_two_robots_do_not_meet() -> None:
    one, other = HostFirmware(CONFIG), HostFirmware(CONFIG)
    one.feed(b"TMOTOR,FL,100\n", 0.0)
    assert (one.pwm, other.pwm) == ((100, 0, 0, 0), STANDING)
    assert not other.has_output


def test_the_robots_own_limits_are_used() -> None:
    slow = HostFirmware(CONFIG.override({"robot.max_speed_mps": 0.1, "serial.vel_watchdog_s": 1.0}))
    slow.feed(b"VEL,100,0,0\n", 0.0)
    # 0.1 m/s of a top speed of 0.2, and half as much again for the wheels stand yet, and the integral's part
    assert slow.step(0.02, STANDING) == (201, 201, 201, 201)
    slow.step(0.99, (1, 1, 1, 1))
    assert slow.mode is Mode.VELOCITY
    slow.step(1.0, (1, 1, 1, 1))
    assert slow.mode is Mode.IDLE


@given(
    st.sampled_from(["mecanum", "differential"]),
    st.floats(0.02, 2.0),
    st.floats(0.02, 2.0),
    st.floats(0.02, 5.0),
    st.floats(0.05, 5.0),
)
def test_every_robot_that_can_be_configured_can_be_driven(
    drive: str, length_m: float, half_width_m: float, speed_mps: float, watchdog_s: float
) -> None:
    config = CONFIG.override(
        {
            "robot.drive": drive,
            "robot.front_m": length_m,
            "robot.rear_m": length_m,
            "robot.half_width_m": half_width_m,
            "robot.max_speed_mps": speed_mps,
            "serial.vel_watchdog_s": watchdog_s,
        }
    )
    firmware = HostFirmware(config)
    firmware.feed(b"VEL,5000,-5000,20000\n", 0.0)
    firmware.step(0.02, (2**31 - 1, -(2**31), 0, 1))
    assert all(abs(pwm) <= 255 for pwm in firmware.pwm)


def test_parameters_beyond_the_arithmetic_are_refused(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(host_firmware, "TICK_M", 1e-9)
    with pytest.raises(ConfigError, match="tick_nm"):
        HostFirmware(CONFIG)
