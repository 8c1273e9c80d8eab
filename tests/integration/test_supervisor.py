"""No orphans, however the supervisor ends: Ctrl-C, SIGTERM, SIGHUP, SIGKILL. Processes are told by their pids."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import time
from collections.abc import Iterator
from pathlib import Path

import pytest

from tests.utils.processes import PATIENCE_S, is_alive, wait_until

pytestmark = pytest.mark.linux

PROGRAM = "tests.integration.supervised_program"


class Supervised:
    """The supervisor's process and, through the file they wrote, those of its children."""

    def __init__(self, run_dir: Path, *options: str) -> None:
        self.run_dir = run_dir
        self.process = subprocess.Popen([sys.executable, "-m", PROGRAM, str(run_dir), *options])
        wait_until(lambda: (run_dir / "running").exists(), "the stack")
        self.first_pids = self.pids()
        assert len(self.first_pids) == 3
        assert all(is_alive(pid) for pid in self.first_pids)

    def pids(self) -> list[int]:
        """Of all children there ever were, in the order of their starts."""
        return [int(line) for line in (self.run_dir / "pids").read_text().split()]

    def signal(self, number: signal.Signals) -> None:
        self.process.send_signal(number)

    def assert_gone(self) -> None:
        wait_until(lambda: not any(is_alive(pid) for pid in self.pids()), "the end of all children")


@pytest.fixture
def supervised(tmp_path: Path) -> Iterator[Supervised]:
    supervised = Supervised(tmp_path)
    yield supervised
    supervised.process.kill()
    supervised.process.wait()
    supervised.assert_gone()


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM, signal.SIGHUP])
def test_a_supervisor_that_is_told_to_end_leaves_nobody(
    supervised: Supervised, number: signal.Signals
) -> None:
    supervised.signal(number)
    assert supervised.process.wait(PATIENCE_S) == 0
    assert not any(is_alive(pid) for pid in supervised.pids())
    assert (supervised.run_dir / "stopped").exists()


def test_a_supervisor_that_is_killed_leaves_nobody(supervised: Supervised) -> None:
    supervised.signal(signal.SIGKILL)
    supervised.process.wait(PATIENCE_S)
    supervised.assert_gone()


def test_a_child_that_is_killed_is_started_again_alone(supervised: Supervised) -> None:
    first, second, third = supervised.first_pids
    os.kill(second, signal.SIGKILL)
    wait_until(lambda: len(supervised.pids()) == 4, "the restart")
    assert is_alive(supervised.pids()[3])
    assert is_alive(first)
    assert is_alive(third)
    wait_until(
        lambda: "b is started again in 0.25 s" in (supervised.run_dir / "run.log").read_text(), "the log"
    )


def test_ctrl_c_in_the_terminal_reaches_the_supervisor_alone(supervised: Supervised) -> None:
    sessions = {os.getsid(pid) for pid in supervised.first_pids}
    assert len(sessions) == 3
    assert os.getsid(supervised.process.pid) not in sessions


def test_a_second_ctrl_c_makes_short_work_of_children_that_do_not_listen(tmp_path: Path) -> None:
    supervised = Supervised(tmp_path, "deaf")
    supervised.signal(signal.SIGINT)
    # Signals are hammered at it, but not once its work is done: on its way out Python itself would obey one.
    for _ in range(100):
        time.sleep(0.1)
        if not any(is_alive(pid) for pid in supervised.pids()):
            break
        supervised.signal(signal.SIGINT)
    assert supervised.process.wait(PATIENCE_S) == 0
    assert not any(is_alive(pid) for pid in supervised.pids())
