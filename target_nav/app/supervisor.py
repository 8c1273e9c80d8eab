"""Starts the processes of a stack in order, restarts what dies, and leaves nothing behind.

Nothing here blocks but `stop`: the command line calls `poll` a few times a second and shows `statuses` in between.
Every process has its own session, so Ctrl-C reaches the supervisor alone, which then ends them in reverse order; the
kernel kills them should the supervisor itself be killed (`launcher`).
"""

from __future__ import annotations

import logging
import os
import signal
import threading
import time
from collections.abc import Mapping, Sequence
from enum import Enum
from pathlib import Path
from types import FrameType, TracebackType
from typing import Any

from target_nav.app.log_merge import LogMerger, last_lines
from target_nav.app.process_spec import ProcessSpec
from target_nav.app.supervised import Child, ProcessState, ProcessStatus
from target_nav.errors import DeviceError

STOP_ALL_TIMEOUT_S = 10.0
"""All processes together get so long to end by themselves; then what is left is killed."""

POLL_S = 0.01
TAIL_LINES = 12

log = logging.getLogger(__name__)


class StackState(Enum):
    STARTING = "starting"
    RUNNING = "running"
    STOPPED = "stopped"


class Supervisor:
    """Owner of a stack's processes, as a `with` block; leaving it stops them all.

    `poll` must be called from the thread that entered the block, and that thread must live as long as the block: the
    kernel ties the processes to it.

    Args:
        specs: in the order in which they are started.
        run_dir: gets `logs/<name>.log` and, merged, `run.log`.
        env: added to the environment of every process.
    """

    def __init__(
        self, specs: Sequence[ProcessSpec], run_dir: Path, env: Mapping[str, str] | None = None
    ) -> None:
        names = [spec.name for spec in specs]
        if len(set(names)) != len(names):
            raise ValueError(f"two processes of one name in {names}")
        self.run_dir = run_dir
        self._logs = run_dir / "logs"
        self._logs.mkdir(parents=True, exist_ok=True)
        environment = {**os.environ, **process_environment(run_dir), **(env or {})}
        self._children = [Child(spec, self._logs, environment) for spec in specs]
        logged = names + [child for spec in specs for child in spec.children]
        self._merger = LogMerger({name: self._logs / f"{name}.log" for name in logged}, run_dir / "run.log")
        self._previous: dict[signal.Signals, Any] = {}
        self._hurry = False
        self._stopped = False

    def __enter__(self) -> Supervisor:
        if threading.current_thread() is threading.main_thread():
            # SIGINT as well: a shell starts background jobs with it ignored, and this program must hear it.
            for number in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP):
                self._previous[number] = signal.signal(number, _interrupt)
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.stop()
        for number, handler in self._previous.items():
            signal.signal(number, handler)
        self._previous.clear()

    @property
    def state(self) -> StackState:
        if self._stopped:
            return StackState.STOPPED
        settled = (ProcessState.RUNNING, ProcessState.EXITED, ProcessState.FAILED)
        return StackState.RUNNING if all(c.state in settled for c in self._children) else StackState.STARTING

    def statuses(self) -> tuple[ProcessStatus, ...]:
        """One row a process, in the order of the table."""
        now_s = time.monotonic()
        return tuple(child.status(now_s) for child in self._children)

    def recent_log(self, count: int) -> list[str]:
        """The newest lines of the merged log."""
        return list(self._merger.recent)[-count:]

    def poll(self) -> StackState:
        """Start what is due, restart what died, read on in the logs. Never blocks for longer than a start takes.

        Raises:
            DeviceError: a critical process cannot be run or kept dying. Everything has been stopped by then; the
                message ends with the last lines of that process's log.
        """
        if self._stopped:
            return self.state
        now_s = time.monotonic()
        for child in self._children:
            failure = child.advance(now_s)
            if failure and child.spec.critical:
                tail = last_lines(child.log_path, TAIL_LINES)
                self.stop()
                raise DeviceError(_tell(child, failure, tail))
            if failure:
                log.error("%s", _tell(child, failure, []))
            if not child.lets_next_start:
                break
        self._merger.pump()
        return self.state

    def stop(self) -> None:
        """Stop all processes in reverse order and wait until they are gone. A second Ctrl-C meanwhile kills them.

        Each is asked (SIGINT), then told (SIGTERM), then killed, with everything it started itself.
        """
        if self._stopped:
            return
        self._stopped = True
        previous = self._take_signals()
        deadline_s = time.monotonic() + STOP_ALL_TIMEOUT_S
        try:
            for child in reversed(self._children):
                while not child.stop(time.monotonic(), kill=self._hurry or time.monotonic() > deadline_s):
                    time.sleep(POLL_S)
            self._merger.pump(final=True)
        finally:
            for number, handler in previous.items():
                signal.signal(number, handler)

    def _take_signals(self) -> dict[signal.Signals, Any]:
        """While stopping, a signal does not interrupt: it makes haste."""
        if threading.current_thread() is not threading.main_thread():
            return {}

        def hurry(number: int, frame: FrameType | None) -> None:
            self._hurry = True

        return {n: signal.signal(n, hurry) for n in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP)}


def process_environment(run_dir: Path) -> dict[str, str]:
    """What every process of a stack gets on top of the environment that it is started in."""
    return {
        # One thread a process: the machine's cores are shared out among processes, not within them.
        "OMP_NUM_THREADS": "1",
        "OPENBLAS_NUM_THREADS": "1",
        "PYTHONUNBUFFERED": "1",
        "ROS_LOG_DIR": str(run_dir / "logs" / "ros"),
    }


def _interrupt(number: int, frame: FrameType | None) -> None:
    raise KeyboardInterrupt


def _tell(child: Child, failure: str, tail: list[str]) -> str:
    text = f"process {child.spec.name} {failure}"
    if child.spec.critical:
        text += "; all others were stopped"
    if tail:
        text += f". The end of {child.log_path}:\n" + "\n".join(f"    {line}" for line in tail)
    return text
