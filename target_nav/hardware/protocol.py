"""The Arduino's serial protocol as pure functions: commands out, telemetry back, lines out of a byte stream.

ASCII lines of comma-separated fields, ended by a newline, integers in mm/s, mrad/s, encoder ticks and PWM
steps. A line carries no checksum, so a parser believes only what matches a form exactly and lies in the
drivetrain's range: anything else is None, to be counted and dropped. Both ends keep to this module, the bridge
and the firmware (deploy/firmware, in C++); tests compare them.

To the firmware: VEL,vx,vy,wz  STOP  FWD,speed,ticks (also BWD LEFT RIGHT CCW CW)  TMOTOR,FL,pwm  CALIB  VERSION
From the firmware: ODOM,vx,vy,wz,us  ENC,fl,fr,rl,rr  ERROR,code,text  ACK,command  VERSION,protocol,firmware
"""

from __future__ import annotations

import math
import re
from dataclasses import dataclass

from target_nav.errors import DeviceError
from target_nav.state.types import Twist2D

PROTOCOL_VERSION = 1
"""Of the lines below; a firmware says in its VERSION line which one it speaks."""

MAX_LINE_BYTES = 96
"""Longest line of either side, newline left out; the firmware's buffer has this size."""

MAX_LINEAR_MMPS = 5_000
MAX_ANGULAR_MRADPS = 20_000
"""No drivetrain of this kind goes faster: a value beyond is a damaged line or a mistake in units."""

MAX_TICKS = 2_147_483_647
"""Encoder counters are 32 bit and signed."""

MAX_DEVICE_US = 2**32 - 1
"""The firmware's clock wraps round after 71 minutes."""

MAX_PWM = 255

MAX_PROTOCOL_VERSION = 999

MOVES = ("FWD", "BWD", "LEFT", "RIGHT", "CCW", "CW")
"""Position moves: straight on, back, strafe to either side, turn counter-clockwise and clockwise."""

MOTORS = ("FL", "FR", "RL", "RR")

# Up to ten digits, ASCII only: int() by itself also takes blanks, underscores and every script's digits.
_INTEGER = re.compile(rb"[+-]?[0-9]{1,10}")


# --- from the firmware ---


@dataclass(frozen=True)
class OdomLine:
    """`ODOM`: the base's velocity from the encoders, 20 times a second in velocity mode.

    `device_us`: the firmware's clock when it read them, microseconds modulo 2**32; None from a firmware that does not
    tell.
    """

    vx_mmps: int
    vy_mmps: int
    wz_mradps: int
    device_us: int | None = None

    def to_twist(self) -> Twist2D:
        """The same in m/s and rad/s."""
        return Twist2D(self.vx_mmps / 1000.0, self.vy_mmps / 1000.0, self.wz_mradps / 1000.0)


@dataclass(frozen=True)
class EncLine:
    """`ENC`: raw encoder counts (front left, front right, rear left, rear right), outside velocity mode."""

    ticks: tuple[int, int, int, int]


@dataclass(frozen=True)
class ErrorLine:
    """`ERROR`: the firmware stopped by itself or refused a command."""

    code: str
    text: str


@dataclass(frozen=True)
class AckLine:
    """`ACK`: the firmware took a command that is not VEL (VEL is answered by ODOM)."""

    command: str


@dataclass(frozen=True)
class VersionLine:
    """`VERSION`: which protocol and which firmware answers, on request and unasked after a reset."""

    protocol: int
    firmware: str


DeviceLine = OdomLine | EncLine | ErrorLine | AckLine | VersionLine


def parse_line(line: bytes) -> DeviceLine | None:
    """What the firmware says in one line (with or without its end), or None if it is none of its lines."""
    fields = _fields(line)
    if fields is None:
        return None
    word = fields[0]
    if word == b"ODOM":
        velocity = _velocity(fields[1:4])
        if velocity is None or len(fields) == 4:
            return OdomLine(*velocity) if velocity is not None else None
        stamp = _integers(fields[4:], (MAX_DEVICE_US,))
        return OdomLine(*velocity, device_us=stamp[0]) if stamp is not None and stamp[0] >= 0 else None
    if word == b"ENC":
        ticks = _integers(fields[1:], (MAX_TICKS,) * 4)
        return EncLine((ticks[0], ticks[1], ticks[2], ticks[3])) if ticks is not None else None
    if word == b"ERROR" and len(fields) >= 2 and fields[1]:
        return ErrorLine(fields[1].decode("ascii"), b",".join(fields[2:]).decode("ascii"))
    if word == b"ACK" and len(fields) == 2 and fields[1]:
        return AckLine(fields[1].decode("ascii"))
    if word == b"VERSION" and len(fields) == 3 and fields[2]:
        number = _integers(fields[1:2], (MAX_PROTOCOL_VERSION,))
        if number is not None and number[0] >= 1:
            return VersionLine(number[0], fields[2].decode("ascii"))
    return None


# --- to the firmware ---


@dataclass(frozen=True)
class VelocityCommand:
    """`VEL`: keep this velocity of the base until the next one, or until the firmware's watchdog ends it."""

    vx_mmps: int
    vy_mmps: int
    wz_mradps: int

    def to_twist(self) -> Twist2D:
        """The same in m/s and rad/s."""
        return Twist2D(self.vx_mmps / 1000.0, self.vy_mmps / 1000.0, self.wz_mradps / 1000.0)


@dataclass(frozen=True)
class StopCommand:
    """`STOP`: stand, and leave velocity or position mode."""


@dataclass(frozen=True)
class MoveCommand:
    """`FWD` and its like: a position move of so many encoder ticks at a speed in mm/s."""

    move: str
    speed_mmps: int
    ticks: int


@dataclass(frozen=True)
class MotorCommand:
    """`TMOTOR`: turn one motor at a PWM of -255 ... 255, to try it."""

    motor: str
    pwm: int


@dataclass(frozen=True)
class CalibrateCommand:
    """`CALIB`: stand, and count the wheels' positions from here."""


@dataclass(frozen=True)
class VersionCommand:
    """`VERSION`: say which protocol and which firmware this is. Changes nothing."""


Command = VelocityCommand | StopCommand | MoveCommand | MotorCommand | CalibrateCommand | VersionCommand


def parse_command(line: bytes) -> Command | None:
    """What a line (with or without its end) asks of the firmware, or None if it is no command."""
    fields = _fields(line)
    if fields is None:
        return None
    word, rest = fields[0], fields[1:]
    if word == b"VEL":
        velocity = _velocity(rest)
        return VelocityCommand(*velocity) if velocity is not None else None
    if word == b"STOP":
        return StopCommand() if not rest else None
    if word == b"CALIB":
        return CalibrateCommand() if not rest else None
    if word == b"VERSION":
        return VersionCommand() if not rest else None
    name = word.decode("ascii")
    if name in MOVES:
        values = _integers(rest, (MAX_LINEAR_MMPS, MAX_TICKS))
        return MoveCommand(name, *values) if values is not None and min(values) >= 0 else None
    if word == b"TMOTOR" and len(rest) == 2 and rest[0].decode("ascii") in MOTORS:
        pwm = _integers(rest[1:], (MAX_PWM,))
        return MotorCommand(rest[0].decode("ascii"), pwm[0]) if pwm is not None else None
    return None


def encode_velocity(twist: Twist2D) -> bytes:
    """`VEL` for a velocity of the base: `Twist2D(0.2, 0, 0.3)` is `VEL,200,0,300`.

    Raises:
        DeviceError: the velocity is not finite, or so large that it cannot be meant.
    """
    values = (twist.vx_mps * 1000.0, twist.vy_mps * 1000.0, twist.wz_radps * 1000.0)
    if not all(math.isfinite(value) for value in values):
        raise DeviceError(f"{twist} is not finite; it was not sent")
    vx, vy, wz = (round(value) for value in values)
    if max(abs(vx), abs(vy)) > MAX_LINEAR_MMPS or abs(wz) > MAX_ANGULAR_MRADPS:
        raise DeviceError(
            f"velocity ({twist.vx_mps:g}, {twist.vy_mps:g}, {twist.wz_radps:g}) is beyond the protocol's "
            f"{MAX_LINEAR_MMPS / 1000:g} m/s, {MAX_ANGULAR_MRADPS / 1000:g} rad/s; units are m/s and rad/s"
        )
    return f"VEL,{vx},{vy},{wz}\n".encode("ascii")


def encode_stop() -> bytes:
    """`STOP`."""
    return b"STOP\n"


def encode_command(command: Command) -> bytes:
    """The line of a command.

    Raises:
        DeviceError: the command has a value the firmware would not take.
    """
    if isinstance(command, VelocityCommand):
        text = f"VEL,{command.vx_mmps},{command.vy_mmps},{command.wz_mradps}"
    elif isinstance(command, StopCommand):
        text = "STOP"
    elif isinstance(command, MoveCommand):
        text = f"{command.move},{command.speed_mmps},{command.ticks}"
    elif isinstance(command, MotorCommand):
        text = f"TMOTOR,{command.motor},{command.pwm}"
    elif isinstance(command, CalibrateCommand):
        text = "CALIB"
    else:
        text = "VERSION"
    line = text.encode("ascii", errors="replace")
    if parse_command(line) != command:
        raise DeviceError(f"the firmware has no command {text!r}; known: {_KNOWN_COMMANDS}")
    return line + b"\n"


_KNOWN_COMMANDS = (
    f"VEL,vx,vy,wz  STOP  {'|'.join(MOVES)},speed,ticks  TMOTOR,{'|'.join(MOTORS)},pwm  CALIB  VERSION"
)


# --- lines out of a stream ---


class LineAssembler:
    """Cuts a byte stream into lines and never holds more than one line of `max_bytes`.

    A line that gets longer is thrown away up to its end and counted in `overflows`: whatever a broken cable
    sends, memory stays bounded and the next whole line is understood again.
    """

    def __init__(self, max_bytes: int = MAX_LINE_BYTES) -> None:
        self._max_bytes = max_bytes
        self._partial = bytearray()
        self._discarding = False
        self.overflows = 0

    def feed(self, data: bytes) -> list[bytes]:
        """The lines that `data` completes, without their ends; empty lines are left out."""
        lines: list[bytes] = []
        *ended, rest = data.split(b"\n")
        for piece in ended:
            self._append(piece)
            line = bytes(self._partial).rstrip(b"\r")
            if line and not self._discarding:
                lines.append(line)
            self.reset()
        self._append(rest)
        return lines

    def reset(self) -> None:
        """Forget the line begun, as after a port was opened again."""
        self._partial.clear()
        self._discarding = False

    def _append(self, piece: bytes) -> None:
        if self._discarding:
            return
        # One byte more: a carriage return before the newline belongs to the end of the line.
        if len(self._partial) + len(piece) > self._max_bytes + 1:
            self._partial.clear()
            self._discarding = True
            self.overflows += 1
            return
        self._partial += piece


# --- forms ---


def _fields(line: bytes) -> list[bytes] | None:
    line = line.rstrip(b"\r\n")
    if not line or len(line) > MAX_LINE_BYTES or not all(0x20 <= byte <= 0x7E for byte in line):
        return None
    return line.split(b",")


def _integers(fields: list[bytes], limits: tuple[int, ...]) -> tuple[int, ...] | None:
    if len(fields) != len(limits) or not all(_INTEGER.fullmatch(field) for field in fields):
        return None
    values = tuple(int(field) for field in fields)
    return values if all(abs(value) <= limit for value, limit in zip(values, limits)) else None


def _velocity(fields: list[bytes]) -> tuple[int, int, int] | None:
    values = _integers(fields, (MAX_LINEAR_MMPS, MAX_LINEAR_MMPS, MAX_ANGULAR_MRADPS))
    return (values[0], values[1], values[2]) if values is not None else None
