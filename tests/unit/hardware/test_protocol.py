"""The serial protocol: exact forms in, None for everything else, both directions inverse to each other."""

from __future__ import annotations

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from target_nav.errors import DeviceError
from target_nav.hardware import protocol
from target_nav.hardware.protocol import (
    AckLine,
    CalibrateCommand,
    EncLine,
    ErrorLine,
    LineAssembler,
    MotorCommand,
    MoveCommand,
    OdomLine,
    StopCommand,
    VelocityCommand,
    VersionCommand,
    VersionLine,
    encode_command,
    encode_velocity,
    parse_command,
    parse_line,
)
from target_nav.state.types import Twist2D

linear = st.integers(-protocol.MAX_LINEAR_MMPS, protocol.MAX_LINEAR_MMPS)
angular = st.integers(-protocol.MAX_ANGULAR_MRADPS, protocol.MAX_ANGULAR_MRADPS)
ticks = st.integers(-protocol.MAX_TICKS, protocol.MAX_TICKS)
printable = st.text(st.characters(min_codepoint=0x20, max_codepoint=0x7E), max_size=60)
commands = st.one_of(
    st.builds(VelocityCommand, linear, linear, angular),
    st.just(StopCommand()),
    st.builds(
        MoveCommand,
        st.sampled_from(protocol.MOVES),
        st.integers(0, protocol.MAX_LINEAR_MMPS),
        st.integers(0, protocol.MAX_TICKS),
    ),
    st.builds(MotorCommand, st.sampled_from(protocol.MOTORS), st.integers(-255, 255)),
    st.just(CalibrateCommand()),
    st.just(VersionCommand()),
)


@pytest.mark.parametrize(
    ("line", "meaning"),
    [
        (b"ODOM,198,-3,301\n", OdomLine(198, -3, 301)),
        (b"ODOM,198,-3,301\r\n", OdomLine(198, -3, 301)),
        (b"ODOM,198,-3,301,4294967295\n", OdomLine(198, -3, 301, 4294967295)),
        (b"ODOM,198,-3,301,0\n", OdomLine(198, -3, 301, 0)),
        (b"ENC,1,-2,2147483647,0", EncLine((1, -2, 2147483647, 0))),
        (b"ERROR,STALL,FL does not turn, stopped", ErrorLine("STALL", "FL does not turn, stopped")),
        (b"ERROR,STALL", ErrorLine("STALL", "")),
        (b"ACK,STOP", AckLine("STOP")),
        (b"VERSION,1,0.1.0\r\n", VersionLine(1, "0.1.0")),
    ],
)
def test_the_firmwares_lines(line: bytes, meaning: object) -> None:
    assert parse_line(line) == meaning


@pytest.mark.parametrize(
    ("line", "meaning"),
    [
        (b"VEL,200,0,300\n", VelocityCommand(200, 0, 300)),
        (b"STOP", StopCommand()),
        (b"FWD,100,1719", MoveCommand("FWD", 100, 1719)),
        (b"TMOTOR,FL,100", MotorCommand("FL", 100)),
        (b"CALIB\r\n", CalibrateCommand()),
        (b"VERSION", VersionCommand()),
    ],
)
def test_the_references_commands(line: bytes, meaning: object) -> None:
    assert parse_command(line) == meaning


@pytest.mark.parametrize(
    "line",
    [
        b"",
        b"\n",
        b"ODOM",
        b"ODOM,1,2",
        b"ODOM,1,2,3,4,5",
        b"ODOM,1,2,3,",
        b"ODOM,1,2,3,-1",
        b"ODOM,1,2,3,4294967296",
        b"ODOM,1,2,3ODOM,1,2,3",
        b"ODOM,1,,3",
        b"ODOM,1.5,2,3",
        b"ODOM, 1,2,3",
        b"ODOM,1_0,2,3",
        b"ODOM,nan,0,0",
        b"ODOM,0x1,0,0",
        "ODOM,١,2,3".encode(),
        b"odom,1,2,3",
        b"DOM,1,2,3",
        b"ODOM,5001,0,0",
        b"ODOM,0,0,-20001",
        b"ODOM,99999999999,0,0",
        b"ENC,1,2,3",
        b"ENC,1,2,3,2147483648",
        b"ERROR,",
        b"ACK",
        b"ACK,STOP,1",
        b"VERSION",
        b"VERSION,1",
        b"VERSION,1,",
        b"VERSION,0,0.1.0",
        b"VERSION,one,0.1.0",
        b"VERSION,1,0.1.0,x",
        b"\x00ODOM,1,2,3",
        b"ODOM,1,2,3\x00",
        b"ODOM,1,2,3" + b" " * protocol.MAX_LINE_BYTES,
    ],
)
def test_a_damaged_line_means_nothing(line: bytes) -> None:
    assert parse_line(line) is None


@pytest.mark.parametrize(
    "line",
    [
        b"",
        b"STOP,1",
        b"VEL,1,2",
        b"VEL,200,0,300VEL,200,0,300",
        b"VEL,20VEL,200,0,300",
        b"VEL,6000,0,0",
        b"FWD,-100,10",
        b"FWD,100",
        b"UP,100,10",
        b"TMOTOR,XX,1",
        b"TMOTOR,FL,256",
        b"VERSION,1",
    ],
)
def test_a_damaged_command_means_nothing(line: bytes) -> None:
    assert parse_command(line) is None


def test_velocity_is_sent_in_rounded_millimetres_and_milliradians() -> None:
    assert encode_velocity(Twist2D(0.2, 0.0, 0.3)) == b"VEL,200,0,300\n"
    assert encode_velocity(Twist2D(-0.0004, 0.0006, -0.29999)) == b"VEL,0,1,-300\n"


@pytest.mark.parametrize("bad", [math.nan, math.inf, -math.inf])
@pytest.mark.parametrize("axis", [0, 1, 2])
def test_a_velocity_that_is_not_finite_is_refused(bad: float, axis: int) -> None:
    values = [0.1, 0.1, 0.1]
    values[axis] = bad
    with pytest.raises(DeviceError, match="not finite"):
        encode_velocity(Twist2D(*values))


@pytest.mark.parametrize(
    "twist", [Twist2D(200.0, 0.0, 0.0), Twist2D(0.0, 5.01, 0.0), Twist2D(0.0, 0.0, -300.0)]
)
def test_a_velocity_in_the_wrong_unit_is_refused(twist: Twist2D) -> None:
    with pytest.raises(DeviceError, match="m/s and rad/s"):
        encode_velocity(twist)


@given(linear, linear, angular)
def test_odometry_survives_the_line(vx: int, vy: int, wz: int) -> None:
    sent = OdomLine(vx, vy, wz)
    assert parse_line(f"ODOM,{vx},{vy},{wz}".encode()) == sent
    assert parse_command(encode_velocity(sent.to_twist())) == VelocityCommand(vx, vy, wz)


@given(commands)
def test_every_command_survives_the_line(command: protocol.Command) -> None:
    line = encode_command(command)
    assert line.endswith(b"\n")
    assert len(line) <= protocol.MAX_LINE_BYTES + 1
    assert parse_command(line) == command


@pytest.mark.parametrize(
    "command",
    [
        VelocityCommand(9999, 0, 0),
        MoveCommand("UP", 1, 1),
        MoveCommand("FWD", -1, 1),
        MotorCommand("FL\nSTOP", 1),
    ],
)
def test_a_command_the_firmware_would_not_take_is_refused(command: protocol.Command) -> None:
    with pytest.raises(DeviceError, match="no command"):
        encode_command(command)


@given(st.tuples(ticks, ticks, ticks, ticks))
def test_encoder_counts_survive_the_line(counts: tuple[int, int, int, int]) -> None:
    assert parse_line(("ENC," + ",".join(map(str, counts)) + "\r\n").encode()) == EncLine(counts)


def test_a_version_survives_the_line() -> None:
    assert parse_line(b"VERSION,7,1.2.3-rc4\n") == VersionLine(7, "1.2.3-rc4")


@given(st.binary(max_size=200))
def test_no_bytes_upset_the_parsers(line: bytes) -> None:
    parse_line(line)
    parse_command(line)


@given(st.lists(st.binary(max_size=60).filter(lambda b: b"\n" not in b and b"\r" not in b)), st.data())
def test_lines_do_not_depend_on_how_the_stream_is_cut(lines: list[bytes], data: st.DataObject) -> None:
    stream = b"".join(line + b"\n" for line in lines)
    assembler = LineAssembler()
    got: list[bytes] = []
    while stream:
        cut = data.draw(st.integers(1, len(stream)))
        got += assembler.feed(stream[:cut])
        stream = stream[cut:]
    assert got == [line for line in lines if line]
    assert assembler.overflows == 0


@given(st.lists(st.binary(max_size=500)))
def test_memory_is_bounded_and_the_next_line_is_understood(chunks: list[bytes]) -> None:
    assembler = LineAssembler()
    for chunk in chunks:
        assert all(len(line) <= protocol.MAX_LINE_BYTES + 1 for line in assembler.feed(chunk))
        assert len(assembler._partial) <= protocol.MAX_LINE_BYTES + 1
    assembler.feed(b"\n")
    assert assembler.feed(b"ODOM,1,2,3\r\n") == [b"ODOM,1,2,3"]


def test_an_endless_line_is_one_overflow() -> None:
    assembler = LineAssembler()
    for _ in range(1000):
        assert assembler.feed(b"x" * 100) == []
    assert assembler.feed(b"x\nSTOP\n") == [b"STOP"]
    assert assembler.overflows == 1


def test_a_line_of_the_greatest_length_passes_with_either_end() -> None:
    assembler = LineAssembler()
    longest = b"A" * protocol.MAX_LINE_BYTES
    assert assembler.feed(longest + b"\n" + longest + b"\r\n") == [longest, longest]
    assert assembler.overflows == 0


def test_a_line_begun_is_forgotten_on_reset() -> None:
    assembler = LineAssembler()
    assembler.feed(b"ODOM,1,2")
    assembler.reset()
    assert assembler.feed(b",3\nACK,STOP\n") == [b",3", b"ACK,STOP"]
