"""Who drives: /cmd_vel or a position command, and when nobody does. Decides which line goes to the firmware next.

Two command paths share one serial port. A velocity is sent as it comes and again until the next one, for the firmware
stops after 0.2 s without. When none has come for `serial.cmd_vel_stale_s` it is zero that is sent, so that the motors
of a robot whose nav process died are off within 0.3 s; when none has come for `serial.cmd_vel_timeout_s`, STOP is sent,
once. A position command takes over from that. The nav process sends zero velocities even while it wants nothing, so a
zero does not end a position command, but any other velocity, STOP or the firmware's own time limit does.
"""

from __future__ import annotations

from enum import Enum

from target_nav.config import RobotConfig, SerialConfig
from target_nav.errors import DeviceError
from target_nav.hardware.protocol import (
    StopCommand,
    VelocityCommand,
    VersionCommand,
    encode_command,
    encode_stop,
    encode_velocity,
    parse_command,
)
from target_nav.state.types import STOP, Twist2D

REFRESH_S = 0.045
"""A velocity this old is sent again at the next turn of the timer: at most 0.1 s between two lines."""

POSITION_LIMIT_S = 30.0
"""The firmware ends a position move after so long (reference)."""

NOTHING = b""


class DriveMode(Enum):
    IDLE = "idle"
    VELOCITY = "velocity"
    POSITION = "position"


class DriveArbiter:
    """Every method returns the line to send now, or NOTHING. Reads no clock."""

    def __init__(self, robot: RobotConfig, serial: SerialConfig) -> None:
        self._robot = robot
        self._stale_s, self._timeout_s = serial.cmd_vel_stale_s, serial.cmd_vel_timeout_s
        self._twist = STOP
        self._received_s = self._sent_s = self._position_since_s = float("-inf")
        self.mode = DriveMode.IDLE
        self.timeouts = 0
        self.stale = 0
        """How often a motion was ended because nobody had sent a velocity for `cmd_vel_stale_s`."""

    def velocity(self, now_s: float, twist: Twist2D) -> bytes:
        """A velocity came. It is scaled into the robot's limits; one that is not finite stops the robot."""
        if not twist.is_finite():
            return self.halt()
        if self._holds_position(now_s) and twist == STOP:
            return NOTHING
        self._twist = within_limits(twist, self._robot)
        self._received_s = now_s
        self.mode = DriveMode.VELOCITY
        return self._send_velocity(now_s)

    def command(self, now_s: float, text: str) -> bytes:
        """A command in the firmware's own words came.

        Raises:
            DeviceError: the firmware has no such command, or it is VEL, which would go round the limits.
        """
        parsed = parse_command(text.strip().encode("ascii", errors="replace"))
        if parsed is None:
            raise DeviceError(f"{text!r} is not a command of the firmware; as in FWD,100,1719 or STOP")
        if isinstance(parsed, VelocityCommand):
            raise DeviceError(f"{text!r}: velocities go through /cmd_vel, where the limits are")
        if isinstance(parsed, StopCommand):
            return self.halt()
        if isinstance(parsed, VersionCommand):
            # A question moves nothing: whoever drives goes on.
            return encode_command(parsed)
        self.mode = DriveMode.POSITION
        self._position_since_s = now_s
        return encode_command(parsed)

    def refresh(self, now_s: float) -> bytes:
        """The timer, 20 times a second or more: the velocity again; zero, then STOP, once, when nobody has sent one for
        too long."""
        if self.mode is not DriveMode.VELOCITY:
            return NOTHING
        age_s = now_s - self._received_s
        if age_s > self._timeout_s:
            self.timeouts += 1
            return self.halt()
        if age_s > self._stale_s and self._twist != STOP:
            self.stale += 1
            self._twist = STOP
            return self._send_velocity(now_s)
        if now_s - self._sent_s < REFRESH_S:
            return NOTHING
        return self._send_velocity(now_s)

    def halt(self) -> bytes:
        """Stop whatever is going on."""
        self.mode = DriveMode.IDLE
        self._twist = STOP
        return encode_stop()

    def _holds_position(self, now_s: float) -> bool:
        return self.mode is DriveMode.POSITION and now_s - self._position_since_s < POSITION_LIMIT_S

    def _send_velocity(self, now_s: float) -> bytes:
        self._sent_s = now_s
        return encode_velocity(self._twist)


def within_limits(twist: Twist2D, robot: RobotConfig) -> Twist2D:
    """`twist`, scaled down as a whole where one component is beyond its limit, so that the path keeps its shape.

    A differential drive cannot strafe: its lateral component is dropped.
    """
    vy_mps = twist.vy_mps if robot.drive == "mecanum" else 0.0
    factor = 1.0
    for value, limit in (
        (twist.vx_mps, robot.max_speed_mps),
        (vy_mps, robot.max_lateral_speed_mps),
        (twist.wz_radps, robot.max_yaw_rate_radps),
    ):
        if abs(value) > limit:
            factor = min(factor, limit / abs(value))
    return Twist2D(twist.vx_mps * factor, vy_mps * factor, twist.wz_radps * factor)
