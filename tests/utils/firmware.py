"""Building deploy/firmware for tests: what cannot be built on this machine is skipped, with the reason."""

from __future__ import annotations

import fcntl
import os
import shutil
import subprocess
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from functools import cache
from pathlib import Path

import pytest

FIRMWARE = Path(__file__).resolve().parents[2] / "deploy" / "firmware"
BUILD = FIRMWARE / "build"
LIBRARY = BUILD / "libtarget_nav_firmware.so"

CORE = Path("/usr/share/arduino/hardware/arduino/avr/cores/arduino/Arduino.h")
SIMAVR = Path("/usr/include/simavr/sim_avr.h")

STANDING = (0, 0, 0, 0)

NO_COMPILER = 2
"""build-host.sh's exit code where there is none."""


@contextmanager
def _alone() -> Iterator[None]:
    """Test processes side by side build one after the other."""
    BUILD.mkdir(exist_ok=True)
    with (BUILD / ".lock").open("w") as lock:
        fcntl.flock(lock, fcntl.LOCK_EX)
        yield


@cache
def built_library() -> Path:
    """The firmware for this machine; skips without a C++ compiler."""
    with _alone():
        done = subprocess.run([FIRMWARE / "build-host.sh"], capture_output=True, text=True)
    if done.returncode == NO_COMPILER:
        pytest.skip(done.stderr.strip())
    assert done.returncode == 0, done.stderr
    return LIBRARY


def made(*targets: str) -> str:
    """What `make` says to these targets of deploy/firmware/Makefile; fails with its output if they fail."""
    # Under a make, this one is not its child: flags and job server stay there.
    environment = {name: value for name, value in os.environ.items() if name not in ("MAKEFLAGS", "MFLAGS")}
    with _alone():
        done = subprocess.run(
            ["make", "-C", FIRMWARE, "-j2", *targets], capture_output=True, text=True, env=environment
        )
    assert done.returncode == 0, f"make {' '.join(targets)}:\n{done.stdout[-4000:]}\n{done.stderr[-4000:]}"
    return done.stdout


def need_make() -> None:
    for tool in ("make", "c++"):
        if shutil.which(tool) is None:
            pytest.skip(f"{tool} is not installed")


def need_avr_tools() -> None:
    """Skips where the image for the ATmega2560 cannot be built."""
    need_make()
    if shutil.which("avr-g++") is None or not CORE.is_file():
        pytest.skip("avr-g++ or the Arduino core is not installed: deploy/firmware/install-tools.sh")


def need_simavr() -> None:
    """Skips where the image cannot be run."""
    need_avr_tools()
    if not SIMAVR.is_file():
        pytest.skip("simavr is not installed: deploy/firmware/install-tools.sh")


class AvrBench:
    """The image for the ATmega2560 under simavr, in real time, with motor driver, motors and encoders beside it."""

    def __init__(self) -> None:
        need_simavr()
        made("avr", "simavr")
        self._process = subprocess.Popen(
            [BUILD / "avr_bench", BUILD / "firmware.elf"],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            text=True,
            bufsize=1,
        )
        assert self._process.stdin is not None
        assert self._process.stdout is not None
        self._stdin, self._stdout = self._process.stdin, self._process.stdout
        self.port = self._stdout.readline().split()[1]
        """Of the serial line."""
        self.drives: list[tuple[float, tuple[int, ...]]] = []
        """What the motors got from when on: monotonic time, duty of each wheel (-4095 ... 4095)."""
        self.figures: dict[str, float] = {}
        """Of the whole run, after `close`."""
        self._listener = threading.Thread(target=self._listen)
        self._listener.start()

    @property
    def duty(self) -> tuple[int, ...]:
        return self.drives[-1][1] if self.drives else STANDING

    def tell(self, line: str) -> None:
        """`jam FL`, `free FL`, `driver off`, `driver on`, `hang`."""
        self._stdin.write(line + "\n")
        self._stdin.flush()

    def close(self) -> dict[str, float]:
        if self._process.poll() is None:
            self._stdin.close()
        self._process.wait(10.0)
        self._listener.join(10.0)
        self._stdout.close()
        return self.figures

    def _listen(self) -> None:
        for line in self._stdout:
            word, *rest = line.split()
            if word == "drive":
                self.drives.append((float(rest[0]), tuple(map(int, rest[1:]))))
            elif word == "end":
                self.figures = {key: float(value) for key, value in (pair.split("=") for pair in rest)}
