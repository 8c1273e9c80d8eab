"""Real processes of this project for integration tests: started with a log, always ended."""

from __future__ import annotations

import os
import random
import signal
import subprocess
import sys
import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path

PATIENCE_S = 30.0


def ros_environment() -> dict[str, str]:
    """A domain of this run's own, on this machine only. Set in this process as well, for its own nodes."""
    os.environ.setdefault("ROS_DOMAIN_ID", str(random.randint(1, 100)))
    os.environ["ROS_AUTOMATIC_DISCOVERY_RANGE"] = "LOCALHOST"
    return dict(os.environ)


def wait_until(condition: Callable[[], bool], what: str, patience_s: float = PATIENCE_S) -> None:
    """Wait for something that must come to pass."""
    deadline_s = time.monotonic() + patience_s
    while not condition():
        assert time.monotonic() < deadline_s, f"waited {patience_s:g} s in vain: {what}"
        time.sleep(0.01)


class Managed:
    """One process; `log()` is what it has written so far."""

    def __init__(self, module: str, arguments: Sequence[str], folder: Path) -> None:
        name = module.rsplit(".", 1)[-1]
        self.log_path = folder / f"{name}.log"
        self.ready_path = folder / f"{name}.ready"
        environment = {**ros_environment(), "TARGET_NAV_READY_FILE": str(self.ready_path)}
        with self.log_path.open("wb") as out:
            self.process = subprocess.Popen(
                [sys.executable, "-m", module, *arguments],
                stdout=out,
                stderr=subprocess.STDOUT,
                env=environment,
            )

    def log(self) -> str:
        return self.log_path.read_text(encoding="utf-8", errors="replace")

    def wait_ready(self) -> None:
        wait_until(lambda: self.ready_path.exists() or self.process.poll() is not None, "readiness")
        assert self.process.poll() is None, self.log()

    def end(self) -> int:
        """Ask it to end as Ctrl-C does; its exit code."""
        if self.process.poll() is None:
            self.process.send_signal(signal.SIGINT)
        return self.wait()

    def wait(self) -> int:
        try:
            return self.process.wait(PATIENCE_S)
        except subprocess.TimeoutExpired:
            self.process.kill()
            self.process.wait()
            raise AssertionError(f"did not end by itself; its log:\n{self.log()}") from None


@contextmanager
def running(module: str, *arguments: str, folder: Path) -> Iterator[Managed]:
    """A process that is ready when the block begins and gone when it ends."""
    managed = Managed(module, arguments, folder)
    try:
        managed.wait_ready()
        yield managed
    finally:
        # Asked, not killed: a killed one leaves its DDS segments in /dev/shm.
        managed.end()


def is_alive(pid: int) -> bool:
    """Whether a process runs; one that only waits to be reaped does not."""
    try:
        stat = Path(f"/proc/{pid}/stat").read_text(encoding="ascii", errors="replace")
    except FileNotFoundError:
        return False
    return stat[stat.rindex(")") + 2] not in "ZX"
