"""Looks at the machine as `target-nav` will meet it. Each check answers with what it found and what to do about it."""

from __future__ import annotations

import importlib
import importlib.metadata
import os
import shutil
import sys
import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from enum import Enum
from pathlib import Path

from target_nav.app import gui_launch
from target_nav.app.detector_program import detector_command
from target_nav.app.model_file import find_model, missing_model
from target_nav.app.paths import REFERENCE_MISSION, mission_path
from target_nav.config import Config
from target_nav.errors import TargetNavError
from target_nav.ipc import channels


class Verdict(Enum):
    OK = "ok"
    NOTE = "note"
    """Missing, but not needed for everything: the text says for what."""
    PROBLEM = "problem"


@dataclass(frozen=True)
class Finding:
    subject: str
    verdict: Verdict
    found: str
    advice: str = ""


WHEELS = ("numpy", "opencv-python-headless", "filterpy", "pyserial", "py_trees", "PyYAML", "click", "rich")
SHM_NEEDED_MB = 16
SLEEP_SAMPLES = 40
LATE_S = 0.005


def examine(config: Config) -> Iterator[Finding]:
    """All checks, one after the other, so that they can be shown as they come."""
    checks: tuple[Callable[[Config], Iterator[Finding]], ...] = (
        _python, _wheels, _ros, _shared_memory, _serial, _camera, _detector, _clocks, _cores, _panel, _mission,
        _firmware,
    )  # fmt: skip
    for check in checks:
        yield from check(config)


def _python(config: Config) -> Iterator[Finding]:
    version = sys.version.split()[0]
    if (3, 10) <= sys.version_info[:2] <= (3, 13):
        yield Finding("Python", Verdict.OK, f"{version} at {sys.executable}")
    else:
        yield Finding("Python", Verdict.PROBLEM, version, "use Python 3.10 to 3.13")


def _wheels(config: Config) -> Iterator[Finding]:
    found, missing = [], []
    for name in WHEELS:
        try:
            found.append(f"{name} {importlib.metadata.version(name)}")
        except importlib.metadata.PackageNotFoundError:
            missing.append(name)
    if missing:
        yield Finding(
            "packages",
            Verdict.PROBLEM,
            f"missing: {', '.join(missing)}",
            "run scripts/start.sh, or pip install .",
        )
    else:
        yield Finding("packages", Verdict.OK, ", ".join(found))


def _ros(config: Config) -> Iterator[Finding]:
    for module, need in (
        ("rclpy", "pip install '.[ros]', or source /opt/ros/jazzy/setup.bash"),
        ("tf2_msgs.msg", "scripts/start.sh builds it; on a robot: apt install ros-jazzy-tf2-msgs"),
        (
            "py_trees_ros_interfaces.srv",
            "scripts/start.sh builds it; on a robot: apt install ros-jazzy-py-trees-ros-interfaces",
        ),
    ):
        name = module.split(".")[0]
        try:
            importlib.import_module(module)
        except ImportError as error:
            yield Finding(
                f"ROS: {name}", Verdict.PROBLEM, str(error), f"{need}; virtual time works without it"
            )
        else:
            domain = f", domain {os.environ.get('ROS_DOMAIN_ID', '0')}" if name == "rclpy" else ""
            yield Finding(f"ROS: {name}", Verdict.OK, f"imports{domain}")


def _shared_memory(config: Config) -> Iterator[Finding]:
    folder = Path("/dev/shm")
    if not os.access(folder, os.W_OK):
        yield Finding("shared memory", Verdict.PROBLEM, f"{folder} is not writable", "mount a tmpfs there")
        return
    free_mb = shutil.disk_usage(folder).free // 2**20
    if free_mb < SHM_NEEDED_MB:
        advice = (
            f"the channels take up to {SHM_NEEDED_MB} MB: free some, or give the container more (--shm-size)"
        )
        yield Finding("shared memory", Verdict.PROBLEM, f"{free_mb} MB free", advice)
    else:
        yield Finding("shared memory", Verdict.OK, f"{free_mb} MB free in {folder}")
    used = [c for c in channels.describe(config.ipc.prefix) if c.exists]
    alive = [c for c in used if c.alive]
    if alive:
        who = ", ".join(f"{c.name} (pid {c.writer_pid})" for c in alive)
        yield Finding(
            "channels", Verdict.NOTE, f"in use: {who}", "another instance runs: stop it, or use --prefix"
        )
    else:
        yield Finding(
            "channels", Verdict.OK, f"prefix {config.ipc.prefix!r}: {len(used)} left over, none in use"
        )


def _serial(config: Config) -> Iterator[Finding]:
    from serial.tools import list_ports

    port = Path(config.serial.port)
    others = ", ".join(sorted(p.device for p in list_ports.comports())) or "none"
    if not port.exists():
        advice = (
            f"needed on the robot only; connect the Arduino, or set serial.port (serial ports here: {others})"
        )
        yield Finding("serial port", Verdict.NOTE, f"{port} is not there", advice)
    elif not os.access(port, os.R_OK | os.W_OK):
        yield Finding(
            "serial port",
            Verdict.PROBLEM,
            f"{port}: no permission",
            "sudo usermod -aG dialout $USER, then log in again",
        )
    else:
        yield Finding("serial port", Verdict.OK, str(port))


def _camera(config: Config) -> Iterator[Finding]:
    devices = sorted(str(p) for p in Path("/dev").glob("video*"))
    if not devices:
        yield Finding(
            "camera", Verdict.NOTE, "no /dev/video*", "needed on the robot only; connect the USB camera"
        )
    elif not os.access(devices[0], os.R_OK | os.W_OK):
        yield Finding(
            "camera",
            Verdict.PROBLEM,
            f"{devices[0]}: no permission",
            "sudo usermod -aG video $USER, then log in again",
        )
    else:
        yield Finding("camera", Verdict.OK, ", ".join(devices))


def _detector(config: Config) -> Iterator[Finding]:
    try:
        chosen = detector_command(config, "sim", ())
    except TargetNavError as error:
        yield Finding("detector", Verdict.PROBLEM, str(error), "see detector.program and detector.model")
        return
    if not chosen.cpp and find_model(config, "cpu") is None:
        advice = "a pin's outline is looked for: good for the simulator, not for a real floor"
        yield Finding("detector", Verdict.NOTE, f"{chosen.description}; {missing_model(config)}", advice)
    elif chosen.cpp or config.detector.program == "python":
        yield Finding("detector", Verdict.OK, chosen.description)
    else:
        yield Finding("detector", Verdict.NOTE, chosen.description, "the same network, by a slower program")


def _clocks(config: Config) -> Iterator[Finding]:
    lateness = []
    deadline_s = time.monotonic()
    for _ in range(SLEEP_SAMPLES):
        deadline_s += 0.005
        time.sleep(max(deadline_s - time.monotonic(), 0.0))
        lateness.append(time.monotonic() - deadline_s)
    worst_ms = 1e3 * max(lateness)
    text = f"a sleep ends {1e3 * sorted(lateness)[SLEEP_SAMPLES // 2]:.2f} ms late (median), {worst_ms:.2f} ms at worst"
    if max(lateness) > LATE_S:
        yield Finding(
            "clocks", Verdict.NOTE, text, "the machine is busy: 20 Hz will hold, its jitter will not be small"
        )
    else:
        yield Finding("clocks", Verdict.OK, text)


def _cores(config: Config) -> Iterator[Finding]:
    cores = len(os.sched_getaffinity(0))
    if cores >= 4:
        yield Finding("cores", Verdict.OK, f"{cores}: each process gets its own")
    else:
        yield Finding(
            "cores",
            Verdict.NOTE,
            f"{cores}",
            "processes are pinned from 4 cores on; here the kernel places them",
        )


def _panel(config: Config) -> Iterator[Finding]:
    lacks = gui_launch.missing_packages()
    if lacks:
        yield Finding(
            "panel", Verdict.NOTE, lacks.split(":")[0], "scripts/install-panel.sh, for target-nav gui"
        )
    elif not (os.environ.get("DISPLAY") or os.environ.get("WAYLAND_DISPLAY")):
        yield Finding("panel", Verdict.OK, "GTK 3 is there; no display in this session")
    else:
        yield Finding("panel", Verdict.OK, f"GTK 3 and a display: {gui_launch.python_of()}")


def _firmware(config: Config) -> Iterator[Finding]:
    from target_nav.sim.firmware_library import firmware_version

    try:
        version = firmware_version()
    except TargetNavError as error:
        yield Finding("simulator's firmware", Verdict.NOTE, str(error), "needed to simulate only")
    else:
        yield Finding("simulator's firmware", Verdict.OK, f"version {version}, built for this machine")


def _mission(config: Config) -> Iterator[Finding]:
    from target_nav.mission import load_mission

    path = mission_path(REFERENCE_MISSION)
    try:
        load_mission(path)
    except TargetNavError as error:
        yield Finding(
            "reference mission", Verdict.PROBLEM, str(error).splitlines()[0], f"target-nav check {path}"
        )
    else:
        yield Finding("reference mission", Verdict.OK, str(path))
