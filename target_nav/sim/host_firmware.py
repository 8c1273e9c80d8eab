"""The robot's own firmware, compiled for this machine: what is flashed on the Arduino drives the simulator too.

The library is built from deploy/firmware by `deploy/firmware/build-host.sh`, which takes a C++ compiler and nothing
else; nothing is built here.
"""

from __future__ import annotations

import ctypes
import os
import sys
import weakref
from functools import cache
from pathlib import Path

from target_nav.config import Config
from target_nav.errors import ConfigError, DeviceError
from target_nav.sim.firmware_types import Mode, Pwm, Ticks
from target_nav.sim.wheels import TICK_M, Base, top_wheel_speed_mps

ABI = 1
"""TNF_ABI of deploy/firmware/host/c_api.h."""

LIBRARY_NAME = "libtarget_nav_firmware.so"
LIBRARY_VARIABLE = "TARGET_NAV_FIRMWARE_LIBRARY"
"""Names another library than the one in the checkout or the environment."""

_CHECKOUT = Path(__file__).resolve().parents[2] / "deploy" / "firmware"
_MODES = (Mode.IDLE, Mode.VELOCITY, Mode.MOVE, Mode.MOTOR)
_OUTPUT_BYTES = 512
"""More than the firmware's queue holds."""


class Params(ctypes.Structure):
    """`tnf_params`: the base and its motors in micrometres and microseconds."""

    _fields_ = tuple(
        (name, ctypes.c_int32)
        for name in ("tick_nm", "lever_um", "top_speed_umps", "deadband_umps", "watchdog_us", "strafes")
    )

    def as_dict(self) -> dict[str, int]:
        return {field[0]: int(getattr(self, field[0])) for field in self._fields_}


class HostFirmware:
    """One Arduino with the firmware on it: `target_nav.sim.firmware_types.Firmware`.

    Its control step is due every 20 ms and telemetry every 50 ms of the times it is given; `step` is called at least
    every 10 ms, so that a watchdog is at most that late.

    Raises:
        DeviceError: the library is not there, or is not built from these sources.
        ConfigError: the robot is beyond what the firmware's arithmetic is made for.
    """

    def __init__(self, config: Config, start_s: float = 0.0, library: Path | None = None) -> None:
        api = load_library(library or find_library())
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


def find_library() -> Path:
    """The library to load: the one named by the environment, the checkout's, or the installed one.

    Raises:
        DeviceError: there is none, or the one that is named is not there.
    """
    named = os.environ.get(LIBRARY_VARIABLE)
    places = [Path(named)] if named else [_CHECKOUT / "build" / LIBRARY_NAME, _installed()]
    for path in places:
        if path.is_file():
            return path
    raise DeviceError(
        f"the firmware's library is not there (looked for {', '.join(map(str, places))}); "
        f"build it with deploy/firmware/build-host.sh, or name one with {LIBRARY_VARIABLE}"
    )


def _installed() -> Path:
    return Path(sys.prefix) / "lib" / "target_nav" / LIBRARY_NAME


@cache
def load_library(path: Path) -> ctypes.CDLL:
    """The library with its functions' types declared.

    Raises:
        DeviceError: it cannot be loaded, or speaks another version of this interface.
    """
    try:
        api = ctypes.CDLL(str(path))
        found = int(api.tnf_abi())
    except (OSError, AttributeError) as error:
        raise DeviceError(
            f"{path} is not the firmware's library: {error}; build it with deploy/firmware/build-host.sh"
        ) from error
    if found != ABI:
        raise DeviceError(
            f"{path} has interface {found}, this program needs {ABI}; build it anew with deploy/firmware/build-host.sh"
        )
    counts, motors = ctypes.POINTER(ctypes.c_int32), ctypes.POINTER(ctypes.c_int16)
    handle, integer, micros = ctypes.c_void_p, ctypes.c_int32, ctypes.c_uint64
    signatures = {
        "tnf_create": (handle, [ctypes.POINTER(Params), micros]),
        "tnf_destroy": (None, [handle]),
        "tnf_feed": (integer, [handle, ctypes.c_char_p, ctypes.c_size_t, micros, motors]),
        "tnf_step": (integer, [handle, micros, counts, motors]),
        "tnf_take": (integer, [handle, ctypes.c_char_p, integer]),
        "tnf_mode": (integer, [handle]),
        "tnf_set_driver": (None, [handle, integer]),
        "tnf_reference": (None, [ctypes.POINTER(Params)]),
        "tnf_version": (ctypes.c_char_p, []),
    }
    for name, (result, arguments) in signatures.items():
        function = getattr(api, name)
        function.restype, function.argtypes = result, arguments
    return api


def reference_params(library: Path | None = None) -> Params:
    """What is compiled into the image for the Arduino."""
    params = Params()
    load_library(library or find_library()).tnf_reference(ctypes.byref(params))
    return params


def firmware_version(library: Path | None = None) -> str:
    """The firmware's version, as in its VERSION line."""
    version: bytes = load_library(library or find_library()).tnf_version()
    return version.decode("ascii")
