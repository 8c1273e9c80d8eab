"""The robot's firmware as a library of this machine: found, built when its sources have changed, loaded.

`deploy/firmware/build-host.sh` does the building; it takes a C++ compiler and nothing else, a second, and 20 ms when
there is nothing to do. So what drives the simulator is always what would be flashed.
"""

from __future__ import annotations

import ctypes
import os
import subprocess
from functools import cache
from pathlib import Path

from target_nav.errors import DeviceError

ABI = 1
"""TNF_ABI of deploy/firmware/host/c_api.h."""

LIBRARY_NAME = "libtarget_nav_firmware.so"
LIBRARY_VARIABLE = "TARGET_NAV_FIRMWARE_LIBRARY"
"""Names a library to take as it is, without building anything."""

BUILD_SCRIPT = "build-host.sh"
BUILD_LIMIT_S = 120.0

_HERE = Path(__file__).resolve()
_SOURCES = Path("deploy") / "firmware"


class Params(ctypes.Structure):
    """`tnf_params`: the base and its motors in micrometres and microseconds."""

    _fields_ = tuple(
        (name, ctypes.c_int32)
        for name in ("tick_nm", "lever_um", "top_speed_umps", "deadband_umps", "watchdog_us", "strafes")
    )

    def as_dict(self) -> dict[str, int]:
        return {field[0]: int(getattr(self, field[0])) for field in self._fields_}


def library_path() -> Path:
    """The library to load, built from the sources as they are now.

    Raises:
        DeviceError: there are no sources, no compiler, or they do not compile; or the library that the environment
            names is not there.
    """
    named = os.environ.get(LIBRARY_VARIABLE)
    if named:
        if not Path(named).is_file():
            raise DeviceError(f"{LIBRARY_VARIABLE} names {named}, which is not there")
        return Path(named)
    sources = sources_folder()
    return build(sources, _build_folder(sources) / LIBRARY_NAME)


def sources_folder() -> Path:
    """deploy/firmware of the checkout, or the copy that was installed beside the package.

    Raises:
        DeviceError: neither is there.
    """
    # An installed package is PREFIX/lib/pythonX.Y/site-packages/target_nav/sim.
    places = [_HERE.parents[2] / _SOURCES]
    if len(_HERE.parents) > 5:
        places.append(_HERE.parents[5] / "share" / "target_nav" / _SOURCES)
    for place in places:
        if (place / BUILD_SCRIPT).is_file():
            return place
    raise DeviceError(
        f"the firmware's sources are not there (looked for {', '.join(map(str, places))}); the simulator needs them, "
        f"or a library named by {LIBRARY_VARIABLE}"
    )


def build(sources: Path, library: Path) -> Path:
    """Bring `library` up to date with `sources`; returns it.

    Raises:
        DeviceError: it cannot be built, with the compiler's own words.
    """
    command = ["sh", str(sources / BUILD_SCRIPT), str(library)]
    try:
        done = subprocess.run(
            command, stdin=subprocess.DEVNULL, capture_output=True, text=True, timeout=BUILD_LIMIT_S
        )
    except (OSError, subprocess.TimeoutExpired) as error:
        raise DeviceError(f"the firmware for the simulator cannot be built: {error}") from error
    if done.returncode != 0:
        why = done.stderr.strip() or f"exit code {done.returncode}"
        raise DeviceError(f"the firmware for the simulator cannot be built ({' '.join(command)}): {why}")
    return library


def _build_folder(sources: Path) -> Path:
    """Beside the sources in a checkout; an installed copy may belong to somebody else."""
    if sources == _HERE.parents[2] / _SOURCES:
        return sources / "build"
    cache_folder = os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache"
    return Path(cache_folder) / "target_nav" / "firmware"


@cache
def load_library(path: Path | None = None) -> ctypes.CDLL:
    """The library with its functions' types declared; without `path` that of `library_path`.

    Raises:
        DeviceError: it cannot be had, cannot be loaded, or speaks another version of this interface.
    """
    path = path or library_path()
    try:
        api = ctypes.CDLL(str(path))
        found = int(api.tnf_abi())
    except (OSError, AttributeError) as error:
        raise DeviceError(
            f"{path} is not the firmware's library: {error}; build it with deploy/firmware/{BUILD_SCRIPT}"
        ) from error
    if found != ABI:
        raise DeviceError(
            f"{path} has interface {found}, this program needs {ABI}; build it anew with deploy/firmware/{BUILD_SCRIPT}"
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


def reference_params() -> Params:
    """What is compiled into the image for the Arduino."""
    params = Params()
    load_library().tnf_reference(ctypes.byref(params))
    return params


def firmware_version() -> str:
    """The firmware's version, as in its VERSION line."""
    version: bytes = load_library().tnf_version()
    return version.decode("ascii")
