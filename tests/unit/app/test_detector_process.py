"""The camera process's child: started again when it dies, given up when that is no use, told in words."""

from __future__ import annotations

import logging
import os
import signal
import time
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest

from target_nav.app.detector_process import FAILED_STARTS_MAX, DetectorProcess, DetectorState
from target_nav.app.detector_program import DetectorCommand
from target_nav.errors import DeviceError

pytestmark = pytest.mark.linux

PATIENCE_S = 30.0
READY = 'touch "$TARGET_NAV_READY_FILE"; '

Start = Callable[[str], DetectorProcess]


@pytest.fixture
def start(tmp_path: Path) -> Iterator[Start]:
    """A detector that is a shell script."""
    started: list[DetectorProcess] = []

    def make(script: str) -> DetectorProcess:
        command = DetectorCommand(("/bin/sh", "-c", script), "a script", cpp=False)
        started.append(DetectorProcess(lambda _: command, tmp_path))
        return started[-1]

    yield make
    for process in started:
        process.close()


def until(process: DetectorProcess, condition: Callable[[], bool]) -> None:
    deadline_s = time.monotonic() + PATIENCE_S
    while not condition():
        assert time.monotonic() < deadline_s, process.state
        process.advance(time.monotonic())
        time.sleep(0.005)


def test_it_runs_when_it_says_so(start: Start) -> None:
    process = start(READY + "exec sleep 100")
    assert process.state is DetectorState.STARTING
    until(process, lambda: process.state is DetectorState.RUNNING)
    assert process.restarts == 0


def test_killed_again_and_again_it_always_comes_back(start: Start) -> None:
    process = start(READY + "exec sleep 100")
    for kills in range(1, FAILED_STARTS_MAX + 3):
        until(process, lambda: process.state is DetectorState.RUNNING)
        pid = process.pid
        assert pid is not None
        os.kill(pid, signal.SIGKILL)
        until(process, lambda wanted=kills: process.restarts == wanted)
        assert process.state is DetectorState.RESTARTING


def test_what_dies_before_it_is_ready_is_given_up_with_its_last_words(start: Start) -> None:
    process = start("echo the reason >&2; exit 1")
    with pytest.raises(
        DeviceError, match=rf"exit code 1, {FAILED_STARTS_MAX} times in a row(.|\n)*the reason"
    ):
        until(process, lambda: False)


def test_what_cannot_be_run_is_told_at_once(start: Start) -> None:
    process = start("echo no such camera >&2; exit 2")
    with pytest.raises(DeviceError, match=r"cannot be run(.|\n)*no such camera"):
        until(process, lambda: False)
    assert process.restarts == 0


def test_a_camera_that_worked_is_waited_for(
    start: Start, tmp_path: Path, caplog: pytest.LogCaptureFixture
) -> None:
    plug = tmp_path / "plugged_in"
    plug.touch()
    wait = f"while [ -e {plug} ]; do sleep 0.02; done; exit 1"
    process = start(f"[ -e {plug} ] || {{ echo camera is not there >&2; exit 2; }}; {READY}{wait}")
    until(process, lambda: process.state is DetectorState.RUNNING)
    plug.unlink()
    with caplog.at_level(logging.WARNING):
        until(process, lambda: "camera is not there" in caplog.text)
    assert process.state is DetectorState.RESTARTING
    plug.touch()
    until(process, lambda: process.state is DetectorState.RUNNING)


def test_a_video_that_ends_is_no_failure(start: Start, caplog: pytest.LogCaptureFixture) -> None:
    process = start(READY + "sleep 0.2; echo end of v.avi after 10 pictures >&2")
    with caplog.at_level(logging.WARNING):
        until(process, lambda: process.state is DetectorState.ENDED)
        for _ in range(5):
            process.advance(time.monotonic())
    assert process.restarts == 0
    assert caplog.text.count("end of v.avi after 10 pictures") == 1


def test_an_operator_may_ask_for_a_new_one(start: Start) -> None:
    process = start(READY + "exec sleep 100")
    until(process, lambda: process.state is DetectorState.RUNNING)
    before = process.pid
    process.restart("a new model")
    until(process, lambda: process.state is DetectorState.RUNNING)
    assert process.pid not in (None, before)
    assert process.restarts == 1


def test_another_target_may_need_another_detector(tmp_path: Path) -> None:
    def choose(class_name: str) -> DetectorCommand:
        name = "python" if class_name.startswith("colour:") else "network"
        script = f"echo {name} >> {tmp_path}/started; {READY}exec sleep 100"
        return DetectorCommand(("/bin/sh", "-c", script), name, cpp=name == "network")

    process = DetectorProcess(choose, tmp_path)
    try:
        until(process, lambda: process.state is DetectorState.RUNNING)
        first = process.pid
        process.look_for("bowling_pin")
        assert process.pid == first
        process.look_for("colour:green")
        until(process, lambda: process.state is DetectorState.RUNNING)
        second = process.pid
        assert second != first
        process.look_for("colour:red")
        assert process.pid == second
    finally:
        process.close()
    assert (tmp_path / "started").read_text().split() == ["network", "python"]


def test_closing_leaves_nothing_behind(start: Start) -> None:
    process = start(READY + "trap '' INT; while :; do sleep 0.05; done")
    until(process, lambda: process.state is DetectorState.RUNNING)
    pid = process.pid
    process.close()
    assert not os.path.exists(f"/proc/{pid}")
