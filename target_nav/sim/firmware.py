"""The Arduino's firmware, byte for byte on its serial line: commands in, PWM to the motors, telemetry out.

Velocity mode: VEL sets wheel speeds by inverse kinematics, a PI loop at 50 Hz holds them, ODOM reports the encoders 20
times a second, and 200 ms without VEL stops it. Otherwise ENC is reported. A wheel that should turn and does not for
5 s, and a position move of over 30 s, stop it with an ERROR line.
"""

from __future__ import annotations

from target_nav.config import Config
from target_nav.hardware import protocol
from target_nav.sim.firmware_types import Mode, Pwm, Ticks
from target_nav.sim.wheels import TICK_M, Base, Wheels, top_wheel_speed_mps
from target_nav.state.types import Twist2D

CONTROL_S = 0.02
TELEMETRY_S = 0.05
STALL_S = 5.0
STALL_TICKS = 3
"""Fewer counts than this are a wheel that trembles."""
MOVE_LIMIT_S = 30.0

KP = 0.5
KI_PER_S = 4.0
"""Of the speed error. Poles at -3 and -15 /s with a motor lag of 80 ms; a step overshoots by a tenth for half a second,
for the integral fills while the motor spins up."""
INTEGRAL_LIMIT = 0.3
"""Of the top speed; keeps a blocked wheel from winding up."""

VERSION = "imitation"
"""What it answers to VERSION, in place of a firmware's number."""

MAX_OUTPUT_BYTES = 8192
"""Nobody listens: the oldest is lost, as in a full port."""

_EARLY_S = 1e-4
"""Sums of periods are not exact: this early is on time."""
_DIRECTIONS = {
    "FWD": (1.0, 0.0, 0.0),
    "BWD": (-1.0, 0.0, 0.0),
    "LEFT": (0.0, 1.0, 0.0),
    "RIGHT": (0.0, -1.0, 0.0),
    "CCW": (0.0, 0.0, 1.0),
    "CW": (0.0, 0.0, -1.0),
}

_STANDING: Wheels = (0.0, 0.0, 0.0, 0.0)
_OFF: Pwm = (0, 0, 0, 0)


class FirmwareEmulator:
    """Call `feed` with what the host sends, and `step` at least every 20 ms with the encoders' counts."""

    def __init__(self, config: Config, start_s: float = 0.0) -> None:
        self._base = Base.of(config.robot)
        self._top_mps = top_wheel_speed_mps(config.robot)
        self._min_mps = config.drive_sim.deadband_mps
        self._watchdog_s = config.serial.vel_watchdog_s
        self._lines = protocol.LineAssembler()
        self._overflows = 0
        self._output = bytearray()

        self.mode = Mode.IDLE
        self._setpoints = _STANDING
        self._integrals = [0.0, 0.0, 0.0, 0.0]
        self.pwm = _OFF
        """What the motors get now."""
        self._entered_s = start_s
        self._last_vel_s = start_s
        self._move_ticks = 0
        self._move_from: Ticks | None = None

        self._next_control_s = start_s + CONTROL_S
        self._next_telemetry_s = start_s + TELEMETRY_S
        self._control_ticks: Ticks = (0, 0, 0, 0)
        self._telemetry_ticks: Ticks = (0, 0, 0, 0)
        self._telemetry_s = start_s
        self._zero: Ticks = (0, 0, 0, 0)
        self._ticks: Ticks = (0, 0, 0, 0)
        self._progress_ticks = [0, 0, 0, 0]
        self._progress_s = [start_s] * 4

    def feed(self, data: bytes, now_s: float) -> None:
        """Bytes from the host. What is no command is answered by an ERROR line and otherwise ignored."""
        for line in self._lines.feed(data):
            command = protocol.parse_command(line)
            if command is None:
                self._say(protocol.encode_error("BADCMD", line[:40].decode("ascii", "replace")))
            else:
                self._obey(command, now_s)
        if self._lines.overflows > self._overflows:
            self._overflows = self._lines.overflows
            self._say(protocol.encode_error("OVERFLOW", f"a line is at most {protocol.MAX_LINE_BYTES} bytes"))

    def step(self, now_s: float, ticks: Ticks) -> Pwm:
        """The PWM of each motor from now on. `ticks` are the encoders' counts now."""
        self._ticks = ticks
        if self.mode is not Mode.IDLE:
            self._look_after(now_s)
        if now_s >= self._next_control_s - _EARLY_S:
            self._next_control_s = max(self._next_control_s + CONTROL_S, now_s)
            self._control(now_s, ticks)
        if now_s >= self._next_telemetry_s - _EARLY_S:
            self._next_telemetry_s = max(self._next_telemetry_s + TELEMETRY_S, now_s)
            self._report(now_s, ticks)
        return self.pwm

    @property
    def has_output(self) -> bool:
        return bool(self._output)

    def take_output(self) -> bytes:
        """What the firmware has sent since the last call."""
        data = bytes(self._output)
        self._output.clear()
        return data

    def _obey(self, command: protocol.Command, now_s: float) -> None:
        if isinstance(command, protocol.VelocityCommand):
            self._enter(Mode.VELOCITY, now_s)
            twist = command.to_twist()
            self._setpoints = self._within_reach(
                self._base.wheel_speeds(twist.vx_mps, twist.vy_mps, twist.wz_radps)
            )
            self._last_vel_s = now_s
        elif isinstance(command, protocol.StopCommand):
            self._stop(now_s)
            self._say(protocol.encode_ack("STOP"))
        elif isinstance(command, protocol.MoveCommand):
            self._begin_move(command, now_s)
        elif isinstance(command, protocol.MotorCommand):
            self._stop(now_s)
            self._enter(Mode.MOTOR, now_s)
            pwm = [command.pwm if motor == command.motor else 0 for motor in protocol.MOTORS]
            self.pwm = (pwm[0], pwm[1], pwm[2], pwm[3])
            self._say(protocol.encode_ack("TMOTOR"))
        elif isinstance(command, protocol.VersionCommand):
            self._say(protocol.encode_version(VERSION))
        else:
            self._stop(now_s)
            self._zero = self._ticks
            self._say(protocol.encode_ack("CALIB"))

    def _begin_move(self, command: protocol.MoveCommand, now_s: float) -> None:
        vx, vy, turn = _DIRECTIONS[command.move]
        if vy and not self._base.strafes:
            self._say(protocol.encode_error("BADCMD", f"{command.move}: this base cannot strafe"))
            return
        self._stop(now_s)
        self._enter(Mode.MOVE, now_s)
        speed = command.speed_mmps / 1000.0
        wheels = self._base.wheel_speeds(vx * speed, vy * speed, turn * speed / self._base.lever_m)
        self._setpoints = self._within_reach(wheels)
        self._move_ticks = command.ticks
        self._move_from = self._ticks
        self._say(protocol.encode_ack(command.move))

    def _within_reach(self, wheels: Wheels) -> Wheels:
        """All wheels slowed by the same factor when one cannot keep up: the direction of motion stays."""
        fastest = max(abs(speed) for speed in wheels)
        if fastest <= self._top_mps:
            return wheels
        factor = self._top_mps / fastest
        a, b, c, d = wheels
        return (a * factor, b * factor, c * factor, d * factor)

    def _enter(self, mode: Mode, now_s: float) -> None:
        if self.mode is not mode:
            self.mode = mode
            self._entered_s = now_s
            self._integrals = [0.0, 0.0, 0.0, 0.0]
            self._progress_s = [now_s] * 4
            self._progress_ticks = list(self._ticks)

    def _stop(self, now_s: float) -> None:
        self._enter(Mode.IDLE, now_s)
        self._setpoints = _STANDING
        self.pwm = _OFF

    def _look_after(self, now_s: float) -> None:
        """The rules that stop the wheels without being asked."""
        if self.mode is Mode.VELOCITY:
            if now_s - self._last_vel_s >= self._watchdog_s - _EARLY_S:
                self._stop(now_s)
                self._say(
                    protocol.encode_error("WATCHDOG", f"no VEL for {self._watchdog_s * 1000:.0f} ms, stopped")
                )
            return
        if now_s - self._entered_s >= MOVE_LIMIT_S:
            self._stop(now_s)
            self._say(protocol.encode_error("TIMEOUT", f"move took over {MOVE_LIMIT_S:.0f} s, stopped"))
        elif self.mode is Mode.MOVE and self._move_from is not None:
            done = sum(abs(tick - begin) for tick, begin in zip(self._ticks, self._move_from)) / 4
            if done >= self._move_ticks:
                self._stop(now_s)

    def _control(self, now_s: float, ticks: Ticks) -> None:
        """The 50 Hz interrupt: a PI loop with feed-forward for each wheel."""
        before, self._control_ticks = self._control_ticks, ticks
        if self.mode not in (Mode.VELOCITY, Mode.MOVE):
            return
        pwm = [0, 0, 0, 0]
        limit = INTEGRAL_LIMIT * self._top_mps
        for i in range(4):
            wanted = self._setpoints[i]
            if -self._min_mps < wanted < self._min_mps or wanted == 0.0:
                # Under its dead-band a motor only hums, and the integral would push it off with a jerk later.
                self._integrals[i] = 0.0
                self._progress_s[i] = now_s
                continue
            error = wanted - (ticks[i] - before[i]) * (TICK_M / CONTROL_S)
            integral = self._integrals[i] + KI_PER_S * CONTROL_S * error
            integral = self._integrals[i] = max(-limit, min(limit, integral))
            drive = (wanted + KP * error + integral) / self._top_mps * protocol.MAX_PWM
            pwm[i] = max(-protocol.MAX_PWM, min(protocol.MAX_PWM, round(drive)))
            if abs(ticks[i] - self._progress_ticks[i]) >= STALL_TICKS:
                self._progress_ticks[i] = ticks[i]
                self._progress_s[i] = now_s
            elif now_s - self._progress_s[i] >= STALL_S - _EARLY_S:
                self._stop(now_s)
                text = f"{protocol.MOTORS[i]} does not turn for {STALL_S:.0f} s, stopped"
                self._say(protocol.encode_error("STALL", text))
                return
        self.pwm = (pwm[0], pwm[1], pwm[2], pwm[3])

    def _report(self, now_s: float, ticks: Ticks) -> None:
        before, self._telemetry_ticks = self._telemetry_ticks, ticks
        dt_s, self._telemetry_s = now_s - self._telemetry_s, now_s
        if self.mode is not Mode.VELOCITY:
            a, b, c, d = (tick - zero for tick, zero in zip(ticks, self._zero))
            self._say(protocol.encode_encoders((a, b, c, d)))
            return
        scale = TICK_M / dt_s
        fl, fr, rl, rr = ((tick - old) * scale for tick, old in zip(ticks, before))
        vx, vy, wz = self._base.body_speeds((fl, fr, rl, rr))
        linear, angular = protocol.MAX_LINEAR_MMPS / 1000.0, protocol.MAX_ANGULAR_MRADPS / 1000.0
        self._say(protocol.encode_odom(Twist2D(_clamp(vx, linear), _clamp(vy, linear), _clamp(wz, angular))))

    def _say(self, line: bytes) -> None:
        self._output += line
        if len(self._output) > MAX_OUTPUT_BYTES:
            del self._output[: len(self._output) - MAX_OUTPUT_BYTES]


def _clamp(value: float, limit: float) -> float:
    return max(-limit, min(limit, value))
