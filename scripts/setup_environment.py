#!/usr/bin/env python3
"""Makes the environment `.venv/` that scripts/start.sh and scripts/test.sh run in.

Four steps, each repeatable: a virtual environment, the locked packages, the two ROS interface packages that the
wheels lack, and this checkout itself (editable). A stamp holds the hash of everything they depend on, so a second
call returns at once (the simulator's firmware and the C++ detector look after themselves); a call that was interrupted
leaves no stamp, and the next one starts over. Standard library only: it runs on whatever Python the machine has.
docs/environment.md tells why it is done this way.
"""

from __future__ import annotations

import argparse
import os
import platform
import re
import shutil
import sys
import time
from collections.abc import Sequence
from pathlib import Path

from environment import detector, firmware, interfaces
from environment.steps import LOG, ROOT, STATE, Progress, SetupError, digest, exclusive, once, output_of, run

LOCK = ROOT / "requirements.lock"
ROS_LOCK = ROOT / "requirements-ros.lock"
THIS_CODE = Path(__file__).parent / "environment"
MINORS = range(10, 14)
NETWORK_HINT = (
    "Is the network there? Behind a mirror or a proxy, pip's own settings (pip.conf, PIP_*) are honoured."
)
VENV_HINT = "On Debian and Ubuntu: `sudo apt install python3-venv`; or name another Python: PYTHON=..."


def ros_source() -> str:
    """Where rclpy comes from: 'system' (installed and sourced), 'wheels' (PyPI has them for x86_64), or 'none'."""
    if output_of(sys.executable, "import rclpy, std_msgs.msg") is not None:
        return "system"
    return "wheels" if sys.platform == "linux" and platform.machine() == "x86_64" else "none"


def make_venv(venv: Path, progress: Progress, *, system_site: bool) -> None:
    shutil.rmtree(venv, ignore_errors=True)
    python = venv / "bin" / "python"
    options = ["--system-site-packages"] if system_site else []
    if output_of(sys.executable, "import ensurepip") is not None:
        run([sys.executable, "-m", "venv", *options, venv], progress, "Making the environment", VENV_HINT)
        return
    # Debian splits ensurepip off; the system's pip can serve another environment too.
    run([sys.executable, "-m", "venv", *options, "--without-pip", venv], progress, "Making it", VENV_HINT)
    command: list[str | Path] = [
        sys.executable,
        "-m",
        "pip",
        "--python",
        python,
        "install",
        "--ignore-installed",
        "pip",
    ]
    run(command, progress, f"{sys.executable} has no ensurepip, and using its pip instead", VENV_HINT)


def install(
    venv: Path, arguments: Sequence[str | Path], progress: Progress, what: str, *, compiled: bool = False
) -> None:
    """Install with uv, which is ten times faster than pip; with pip when uv cannot be had or fails.

    pip reads the user's settings (a mirror, a proxy), which uv does not, so it may succeed where uv has failed.
    """
    python, uv = venv / "bin" / "python", venv / "bin" / "uv"
    pip: list[str | Path] = [python, "-m", "pip", "install", "--disable-pip-version-check"]
    try:
        if not uv.exists():
            pinned = re.search(r"^uv==\S+", LOCK.read_text(), re.MULTILINE)
            run([*pip, pinned.group() if pinned else "uv"], progress, "Installing uv", NETWORK_HINT)
        # The main environment's processes start from byte code: compiling SciPy anew takes each of them seconds.
        options = ["--compile-bytecode"] if compiled else []
        run([uv, "pip", "install", "--python", python, *options, *arguments], progress, what, NETWORK_HINT)
    except SetupError:
        run([*pip, *arguments], progress, what, NETWORK_HINT)


def install_packages(venv: Path, ros: str, progress: Progress) -> str:
    """Everything but the checkout; returns a note."""
    if ros != "system":
        locks: list[str | Path] = ["--require-hashes", "-r", LOCK]
        if ros == "wheels":
            locks += ["-r", ROS_LOCK]
        install(venv, locks, progress, "Installing the locked packages", compiled=True)
        return "as locked"
    # apt's messages are compiled against apt's numpy, so that has to stay and the lock cannot apply. pip counts what
    # the system has as installed (uv would not see it).
    numpy = output_of(sys.executable, "import numpy; print('numpy==' + numpy.__version__)")
    pins = STATE / "system-pins.txt"
    pins.write_text(numpy or "")
    python = venv / "bin" / "python"
    command: list[str | Path] = [python, "-m", "pip", "install", "-c", pins, "-e", f"{ROOT}[sim,dev]"]
    run(command, progress, "Installing packages", NETWORK_HINT)
    return f"beside the system's {numpy.strip() if numpy else 'packages'}"


def install_interfaces(venv: Path, ros: str, progress: Progress) -> str:
    if ros == "none":
        return "left out: ROS has no wheels for this machine, so install ROS 2 for the full stack"
    if ros == "wheels":
        return interfaces.provide(venv, ROS_LOCK, progress)
    if missing := interfaces.missing(venv):
        distro = os.environ.get("ROS_DISTRO", "jazzy")
        names = " ".join(f"ros-{distro}-{name.replace('_', '-')}" for name in missing)
        raise SetupError(f"The installed ROS 2 lacks {', '.join(missing)}.\n  sudo apt install {names}")
    return "those of the installed ROS 2"


def fingerprint(ros: str, *inputs: Path) -> dict[str, str]:
    """What an environment depends on. `where`: it does not survive being moved."""
    python = f"{platform.python_implementation()} {platform.python_version()} {sys.base_prefix}"
    files = [ROOT / "setup.py", ROOT / "setup.cfg", LOCK, Path(__file__), THIS_CODE, *inputs]
    return {"python": python, "ros": ros, "where": str(ROOT), "inputs": digest(*files)}


def set_up() -> None:
    """The environment that everything runs in."""
    venv, ros = ROOT / ".venv", ros_source()

    def steps(fresh: bool) -> None:
        began = time.monotonic()
        progress = Progress(4)
        progress.step(f"virtual environment: Python {platform.python_version()}, ROS: {ros}")
        if fresh:
            make_venv(venv, progress, system_site=ros == "system")
        progress.done("new" if fresh else "kept")
        progress.step("packages")
        progress.done(install_packages(venv, ros, progress))
        progress.step("ROS interface packages")
        progress.done(install_interfaces(venv, ros, progress))
        progress.step("this checkout")
        install(venv, ["--no-deps", "--no-build-isolation", "-e", ROOT], progress, "Installing the checkout")
        progress.done("editable")
        print(f"[setup] ready after {time.monotonic() - began:.1f} s", flush=True)

    with exclusive("venv"):
        once(venv, fingerprint(ros, ROS_LOCK, interfaces.DEFINITIONS), steps)
        firmware.provide()
        detector.provide(venv)


def set_up_light() -> None:
    """`.venv-py3XX/` for the fast tests on this process's Python: neither ROS nor tools."""
    venv = ROOT / f".venv-py3{sys.version_info.minor}"

    def steps(fresh: bool) -> None:
        progress = Progress(1)
        progress.step(f"environment for the fast tests on Python {platform.python_version()}")
        if fresh:
            make_venv(venv, progress, system_site=False)
        install(venv, ["-c", LOCK, "-e", f"{ROOT}[test]"], progress, "Installing the packages")
        progress.done("new" if fresh else "brought up to date")

    with exclusive("light"):
        once(venv, fingerprint("none"), steps)


def find_pythons() -> dict[int, str]:
    """One runnable interpreter for each supported 3.x on this machine.

    A name on the PATH need not run (pyenv leaves a shim for every version it has, active or not), so each is asked.
    """
    home = Path(os.environ.get("HOME", "/nonexistent"))
    folders = [Path(folder) for folder in os.environ.get("PATH", os.defpath).split(os.pathsep) if folder]
    pyenvs = {
        Path(os.environ.get("PYENV_ROOT", home / ".pyenv")),
        *(f.parent for f in folders if f.name == "shims"),
    }
    found: dict[int, str] = {}
    for minor in MINORS:
        name = f"python3.{minor}"
        places = [folder / name for folder in folders]
        for root in sorted(pyenvs):
            places += sorted(root.glob(f"versions/3.{minor}.*/bin/{name}"), reverse=True)
        places += (home / ".local/share/uv/python").glob(f"cpython-3.{minor}.*/bin/{name}")
        check = f"import sys, venv; sys.exit(sys.version_info[:2] != (3, {minor}))"
        for place in places:
            if place.is_file() and output_of(place, check) is not None:
                found[minor] = str(place)
                break
    return found


def main() -> int:
    parser = argparse.ArgumentParser(description="Makes the environment of this checkout.")
    parser.add_argument("--light", action="store_true", help="make .venv-py3XX for the fast tests instead")
    parser.add_argument(
        "--list-pythons", action="store_true", help="print `minor path` for each Python found"
    )
    options = parser.parse_args()
    try:
        if options.list_pythons:
            for minor, path in find_pythons().items():
                print(minor, path)
        elif options.light:
            set_up_light()
        else:
            set_up()
    except SetupError as error:
        print(f"\n[setup] FAILED: {error}\n  Log: {LOG}", file=sys.stderr)
        return 1
    except KeyboardInterrupt:
        print("\n[setup] interrupted; the next run starts over", file=sys.stderr)
        return 130
    return 0


if __name__ == "__main__":
    sys.exit(main())
