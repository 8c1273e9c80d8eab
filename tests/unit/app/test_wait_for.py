"""A command that waits for a file."""

from __future__ import annotations

import subprocess
import sys
import time
from pathlib import Path

from target_nav.app import wait_for


def start(file: Path, timeout_s: float, *command: str) -> subprocess.Popen[str]:
    argv = [sys.executable, "-I", "-S", wait_for.__file__, str(file), str(timeout_s), *command]
    return subprocess.Popen(argv, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)


def test_the_command_begins_when_the_file_is_there(tmp_path: Path) -> None:
    ready = tmp_path / "ready"
    waiting = start(ready, 30.0, "sh", "-c", "echo $$")
    time.sleep(0.3)
    assert waiting.poll() is None
    ready.touch()
    out, _ = waiting.communicate(timeout=30.0)
    # It became the command: same process, as its parent expects.
    assert out.strip() == str(waiting.pid)
    assert waiting.returncode == 0


def test_a_file_that_does_not_come_is_a_failure(tmp_path: Path) -> None:
    waiting = start(tmp_path / "never", 0.1, "echo", "no")
    out, errors = waiting.communicate(timeout=30.0)
    assert (waiting.returncode, out) == (1, "")
    assert "did not appear within 0.1 s" in errors


def test_a_command_that_is_none_cannot_be_run(tmp_path: Path) -> None:
    (tmp_path / "ready").touch()
    waiting = start(tmp_path / "ready", 1.0, "/no/such/program")
    _, errors = waiting.communicate(timeout=30.0)
    assert waiting.returncode == 2
    assert "/no/such/program cannot be run" in errors
