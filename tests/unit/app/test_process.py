"""Exit codes, signals and readiness: what a process and its supervisor say to each other."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import threading
from pathlib import Path

import pytest

from target_nav.app.process import (
    EXIT_CANNOT_RUN,
    EXIT_FAILED,
    EXIT_OK,
    READY_FILE_VARIABLE,
    StopSignal,
    report_ready,
    run_process,
)
from target_nav.errors import ConfigError, DeviceError


def raiser(error: BaseException) -> int:
    raise error


@pytest.mark.parametrize(
    ("error", "code"),
    [
        (ConfigError("wrong"), EXIT_CANNOT_RUN),
        (DeviceError("missing"), EXIT_CANNOT_RUN),
        (RuntimeError("a defect"), EXIT_FAILED),
        (KeyboardInterrupt(), EXIT_OK),
    ],
)
def test_an_error_becomes_an_exit_code(error: BaseException, code: int) -> None:
    assert run_process("test", lambda: raiser(error)) == code


def test_a_body_may_choose_its_code() -> None:
    assert run_process("test", lambda: None) == EXIT_OK
    assert run_process("test", lambda: 1) == 1


def test_an_expected_error_is_one_line_and_a_defect_has_its_traceback(
    capsys: pytest.CaptureFixture[str],
) -> None:
    run_process("test", lambda: raiser(ConfigError("speed is 9; it must lie in 0 ... 5")))
    (line,) = capsys.readouterr().err.splitlines()
    assert line.endswith("ERROR   test: speed is 9; it must lie in 0 ... 5")
    run_process("test", lambda: raiser(RuntimeError("a defect")))
    assert "Traceback" in capsys.readouterr().err


def test_readiness_is_a_file(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.delenv(READY_FILE_VARIABLE, raising=False)
    report_ready()
    monkeypatch.setenv(READY_FILE_VARIABLE, str(tmp_path / "ready"))
    report_ready()
    assert (tmp_path / "ready").exists()


@pytest.mark.parametrize("number", StopSignal.SIGNALS)
def test_a_signal_ends_the_wait(number: signal.Signals) -> None:
    with StopSignal() as stop:
        assert not stop.wait(0.0)
        os.kill(os.getpid(), number)
        assert stop.wait(60.0)
        assert stop.requested


def test_the_handlers_from_before_come_back() -> None:
    before = [signal.getsignal(number) for number in StopSignal.SIGNALS]
    with StopSignal():
        assert [signal.getsignal(number) for number in StopSignal.SIGNALS] != before
    assert [signal.getsignal(number) for number in StopSignal.SIGNALS] == before


def test_another_thread_may_ask_for_the_end() -> None:
    with StopSignal() as stop:
        threading.Timer(0.01, stop.request).start()
        assert stop.wait(60.0)
        stop.request()


def test_a_second_signal_ends_a_process_that_does_not_come_to_its_end() -> None:
    code = (
        "import os, signal, time\n"
        "from target_nav.app.process import StopSignal\n"
        "with StopSignal() as stop:\n"
        "    os.kill(os.getpid(), signal.SIGTERM)\n"
        "    assert stop.wait(60)\n"
        "    os.kill(os.getpid(), signal.SIGTERM)\n"
        "    time.sleep(60)\n"
    )
    assert subprocess.run([sys.executable, "-c", code], timeout=60, check=False).returncode == -signal.SIGTERM
