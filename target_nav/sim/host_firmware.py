"""The robot's own firmware, compiled for this machine: what is flashed on the Arduino drives the simulator too.

In real time and in virtual time alike: it reads no clock, so the same bytes at the same times give the same answers.
"""

from __future__ import annotations

import ctypes
import weakref
from pathlib import Path

from target_nav.config import Config
from target_nav.errors import ConfigError
from target_nav.sim.firmware_library import Params, load_library
from target_nav.sim.firmware_types import Mode, Pwm, Ticks
from target_nav.sim.wheels import TICK_M, Base, top_wheel_speed_mps

_MODES = (Mode.IDLE, Mode.VELOCITY, Mode.MOVE, Mode.MOTOR)
_OUTPUT_BYTES = 512
"""More than the firmware's queue holds."""


class HostFirmware:
    """One Arduino with the firmware on it: `target_nav.sim.firmware_types.Firmware`.

    Its control step is due every 20 ms and telemetry every 50 ms of the times it is given; `step` is called at least
    every 10 ms, so that a watchdog is at most that late.

    Raises:
        DeviceError: the library cannot be built or loaded; see `firmware_library`.
        ConfigError: the robot is beyond what the firmware's arithmetic is made for.
    """

    def __init__(self, config: Config, start_s: float = 0.0, library: Path | None = None) -> None:
        api = load_library(library)
        params = params_of(config)
        self._start_s = start_s
        handle = api.tnf_create(ctypes.byref(params), 0)
        if not handle:
            raise ConfigError(
                f"the firmware cannot drive this robot: {params.as_dict()}; a lever of 1 mm to 10 m and wheels of "
                "1 mm/s to 50 m/s are within its arithmetic (keys robot.* and drive_sim.deadband_mps)"
            )
        self._handle = ctypes.c_void_p(handle)
        weakref.finalize(self, api.tnf_destroy, self._handle)
        self._feed, self._step = api.tnf_feed, api.tnf_step
        self._take, self._mode = api.tnf_take, api.tnf_mode
        self._counts = (ctypes.c_int32 * 4)()
        self._motors = (ctypes.c_int16 * 4)()
        self._buffer = ctypes.create_string_buffer(_OUTPUT_BYTES)
        self._waiting = 0
        self.pwm: Pwm = (0, 0, 0, 0)
        """What the motors get now."""

    def feed(self, data: bytes, now_s: float) -> None:
        """Bytes from the host. What is no command is answered by an ERROR line and otherwise ignored."""
        self._waiting = self._feed(self._handle, data, len(data), self._micros(now_s), self._motors)
        self._read_motors()

    def step(self, now_s: float, ticks: Ticks) -> Pwm:
        """The PWM of each motor from now on. `ticks` are the encoders' counts now; they wrap round at 32 bit."""
        self._counts[:] = list(ticks)
        self._waiting = self._step(self._handle, self._micros(now_s), self._counts, self._motors)
        self._read_motors()
        return self.pwm

    @property
    def mode(self) -> Mode:
        return _MODES[self._mode(self._handle)]

    @property
    def has_output(self) -> bool:
        return self._waiting > 0

    def take_output(self) -> bytes:
        """What the firmware has sent since the last call. Its queue is short: lines nobody takes are dropped."""
        count = self._take(self._handle, self._buffer, _OUTPUT_BYTES)
        self._waiting = 0
        return self._buffer.raw[:count]

    def _read_motors(self) -> None:
        motors = self._motors
        self.pwm = (motors[0], motors[1], motors[2], motors[3])

    def _micros(self, now_s: float) -> int:
        return max(round((now_s - self._start_s) * 1e6), 0)


def params_of(config: Config) -> Params:
    """The firmware's parameters of a robot; of the reference robot, what is flashed."""
    return Params(
        tick_nm=round(TICK_M * 1e9),
        lever_um=round(Base.of(config.robot).lever_m * 1e6),
        top_speed_umps=round(top_wheel_speed_mps(config.robot) * 1e6),
        deadband_umps=round(config.drive_sim.deadband_mps * 1e6),
        watchdog_us=round(config.serial.vel_watchdog_s * 1e6),
        strafes=int(config.robot.drive == "mecanum"),
    )
