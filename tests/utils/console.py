"""The simulated stack and the console beside it, as processes that a test starts, asks and kills."""

from __future__ import annotations

import os
import shutil
import signal
import socket
import subprocess
import sys
from pathlib import Path

from target_nav.gui.missions import mission_folder
from target_nav.ipc import channels
from target_nav.state.snapshots import NavSnapshot
from tests.utils.processes import ros_environment, wait_until

PREFIX = f"test_console_{os.getpid()}"
TOKEN = "token-of-the-tests"


class Stack:
    """The simulated robot, waiting for GO, and what shared memory says of it."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        self._out = (folder / "run.out").open("wb")
        self._process = subprocess.Popen(
            [
                *(
                    sys.executable,
                    "-m",
                    "target_nav.app.cli",
                    "run",
                    "--sim",
                    "open_floor",
                    "--headless",
                    "--wait",
                ),
                *("--prefix", PREFIX, "--out", str(folder / "runs")),
            ],
            env=ros_environment(),
            stdout=self._out,
            stderr=subprocess.STDOUT,
        )
        self._nav = channels.open_reader(channels.NAV, PREFIX)
        self._camera = channels.open_reader(channels.CAMERA, PREFIX)

    @property
    def nav(self) -> NavSnapshot:
        value = self._nav.latest()
        assert value is not None
        return value

    def wait_up(self) -> None:
        try:
            wait_until(lambda: self._nav.latest() is not None, "the nav process ticks", 60.0)
            wait_until(lambda: self._camera.latest() is not None, "the detector has a picture", 60.0)
        except AssertionError:
            raise AssertionError((self.folder / "run.out").read_text()) from None

    def stands(self) -> bool:
        twist = self.nav.twist_sent
        return twist.speed_mps == 0.0 and twist.wz_radps == 0.0

    def end(self) -> None:
        if self._process.poll() is None:
            self._process.send_signal(signal.SIGINT)
            self._process.wait(30.0)

    def close(self) -> None:
        try:
            self.end()
        finally:
            self._process.kill()
            self._out.close()
            self._nav.close()
            self._camera.close()
            channels.remove(PREFIX)


class ConsoleProcess:
    """`target-nav web`, on one port over all its lives."""

    def __init__(self, stack: Stack) -> None:
        self.log_path = stack.folder / "web.log"
        self.missions = Path(shutil.copytree(mission_folder(), stack.folder / "trees"))
        self.settings = stack.folder / "settings.yaml"
        with socket.socket() as free:
            free.bind(("127.0.0.1", 0))
            self.port = free.getsockname()[1]
        self.address = f"http://127.0.0.1:{self.port}/"
        self._argv = [
            *(
                sys.executable,
                "-m",
                "target_nav.app.cli",
                "web",
                "--prefix",
                PREFIX,
                "--port",
                str(self.port),
            ),
            *("--token", TOKEN, "--settings", str(self.settings), "--missions", str(self.missions)),
            *("--runs", str(stack.folder / "runs")),
        ]
        self.start()

    def start(self) -> None:
        with self.log_path.open("ab") as out:
            self.process = subprocess.Popen(self._argv, stdout=out, stderr=subprocess.STDOUT)
        wait_until(self._listens, "the console listens")

    def _listens(self) -> bool:
        assert self.process.poll() is None, self.log()
        with socket.socket() as knock:
            return knock.connect_ex(("127.0.0.1", self.port)) == 0

    def kill(self) -> None:
        self.process.kill()
        self.process.wait(10.0)

    def log(self) -> str:
        return self.log_path.read_text(encoding="utf-8", errors="replace")

    def close(self) -> None:
        self.process.send_signal(signal.SIGINT)
        try:
            assert self.process.wait(15.0) == 0, self.log()
        finally:
            self.process.kill()
