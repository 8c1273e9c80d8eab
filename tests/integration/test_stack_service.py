"""The stack as systemd runs it: says when it is ready, feeds the watchdog only while it works, ends as it should."""

from __future__ import annotations

import os
import signal
import socket
import subprocess
import sys
import threading
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import pytest

from target_nav.app.stack_service import NAV_QUIET_S, Health
from tests.utils.processes import is_alive, ros_environment, wait_until

PREFIX = "test_service"


class Systemd:
    """The other end of $NOTIFY_SOCKET."""

    def __init__(self, path: Path) -> None:
        self.words: list[tuple[float, str]] = []
        self._socket = socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM)
        self._socket.bind(str(path))
        self._socket.settimeout(0.1)
        self._ended = threading.Event()
        self._thread = threading.Thread(target=self._listen, daemon=True)
        self._thread.start()

    def heard(self, word: str) -> bool:
        return any(word in text for _, text in self.words)

    def silent_s(self) -> float:
        """Time since the watchdog was fed last."""
        return time.monotonic() - max(at_s for at_s, text in self.words if text == "WATCHDOG=1")

    def close(self) -> None:
        self._ended.set()
        self._thread.join()
        self._socket.close()

    def _listen(self) -> None:
        while not self._ended.is_set():
            try:
                text = self._socket.recv(4096).decode()
            except TimeoutError:
                continue
            self.words.append((time.monotonic(), text))


@contextmanager
def service(folder: Path, *options: str) -> Iterator[tuple[subprocess.Popen[bytes], Systemd, Path]]:
    """The service's process, what it tells, and its log."""
    systemd = Systemd(folder / "notify")
    log = folder / "service.log"
    command = [sys.executable, "-m", "target_nav.app.stack_service", "--out", str(folder / "runs")]
    environment = {**ros_environment(), "NOTIFY_SOCKET": str(folder / "notify")}
    with log.open("wb") as out:
        process = subprocess.Popen(
            [*command, "--prefix", PREFIX, *options], env=environment, stdout=out, stderr=subprocess.STDOUT
        )
    try:
        yield process, systemd, log
    finally:
        if process.poll() is None:
            process.terminate()
        process.wait(30.0)
        systemd.close()
        for path in Path("/dev/shm").glob(f"{PREFIX}_*"):
            path.unlink()


def pid_of(module: str, supervisor: int) -> int:
    """The process of a module among those that a supervisor has started."""
    for entry in Path("/proc").iterdir():
        try:
            argv = (entry / "cmdline").read_text().split("\0")
            parent = int((entry / "stat").read_text().rsplit(")", 1)[1].split()[1])
        except (OSError, IndexError, ValueError):
            continue
        if f"target_nav.app.{module}" in argv and parent == supervisor:
            return int(entry.name)
    raise AssertionError(f"no process runs {module}")


@pytest.mark.ros
@pytest.mark.linux
@pytest.mark.slow
def test_the_watchdog_is_fed_while_the_nav_process_ticks(tmp_path: Path) -> None:
    with service(tmp_path, "--sim", "open_floor") as (process, systemd, log):
        wait_until(
            lambda: systemd.heard("READY=1") or process.poll() is not None, "readiness", patience_s=60.0
        )
        assert process.poll() is None, log.read_text()
        wait_until(lambda: systemd.heard(" Hz, 0 restarts"), "a status")
        assert systemd.silent_s() < 1.0

        nav = pid_of("tree_executor", process.pid)
        os.kill(nav, signal.SIGSTOP)
        try:
            wait_until(lambda: systemd.silent_s() > 1.0, "the watchdog to be left alone")
        finally:
            os.kill(nav, signal.SIGCONT)
        assert "has not ticked for 2 s" in log.read_text()
        wait_until(lambda: systemd.silent_s() < 0.5, "the watchdog to be fed again")

        # One that dies is the supervisor's business, not systemd's.
        os.kill(nav, signal.SIGKILL)
        wait_until(lambda: systemd.heard("1 restarts"), "the nav process to be started again")
        wait_until(lambda: systemd.heard("IDLE, ") and systemd.silent_s() < 0.5, "the stack to work again")
        nav = pid_of("tree_executor", process.pid)

        process.terminate()
        assert process.wait(30.0) == 0
        assert systemd.heard("STOPPING=1")
        assert not is_alive(nav)


@pytest.mark.ros
@pytest.mark.linux
@pytest.mark.slow
def test_a_robot_without_its_parts_cannot_be_run(tmp_path: Path) -> None:
    absent = ("--set", "serial.port=/dev/no_arduino", "--set", "lidar.port=/dev/no_lidar")
    with service(tmp_path, *absent) as (process, systemd, log):
        assert process.wait(60.0) == 2
    assert "cannot be run as it was asked to" in log.read_text()
    assert not systemd.heard("READY=1")


@pytest.mark.linux
@pytest.mark.parametrize("options", [("--mission", "no_such_mission"), ("--set", "loop.rate_hz=0")])
def test_wrong_orders_are_refused(options: tuple[str, ...], tmp_path: Path) -> None:
    with service(tmp_path, *options) as (process, _, log):
        assert process.wait(30.0) == 2
    assert "Traceback" not in log.read_text()
    assert not (tmp_path / "runs").exists()


def test_health_is_lost_when_nav_is_quiet_and_nobody_is_starting_it() -> None:
    health = Health(0.0)
    assert health.see(None, settled=False, now_s=60.0)
    assert health.see(None, settled=True, now_s=60.0 + 0.9 * NAV_QUIET_S)
    assert not health.see(None, settled=True, now_s=60.1 + NAV_QUIET_S)
    assert health.see(None, settled=False, now_s=70.0)
    assert str(health) == "starting"
