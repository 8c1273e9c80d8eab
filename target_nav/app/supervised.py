"""One supervised process: its states, when it is started again, how it is ended."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import time
from collections import deque
from collections.abc import Mapping
from dataclasses import dataclass
from enum import Enum
from pathlib import Path

from target_nav.app import launcher
from target_nav.app.process import EXIT_CANNOT_RUN, EXIT_OK, READY_FILE_VARIABLE
from target_nav.app.process_spec import ProcessSpec, ReadyWhen

TERMINATE_AFTER_S = 1.0
"""From SIGTERM to SIGKILL."""

GROUP_TIMEOUT_S = 2.0
"""How long a killed process's own children may take to vanish."""


class ProcessState(Enum):
    WAITING = "waiting"
    """Not started yet: one before it is not ready."""
    STARTING = "starting"
    RUNNING = "running"
    BACKOFF = "restarting"
    """Died; is started again in a moment."""
    EXITED = "exited"
    """Ended by itself, which it may."""
    FAILED = "failed"
    """Cannot be run, or was given up."""
    STOPPED = "stopped"


@dataclass(frozen=True)
class ProcessStatus:
    """A row for a view. `pid` is None while there is no process; `exit_text` tells how the last one ended."""

    name: str
    pid: int | None
    state: ProcessState
    restarts: int
    cpu_s: float
    memory_mb: float
    uptime_s: float
    exit_code: int | None
    exit_text: str


class Child:
    """Runs one spec, again and again if need be. Everything happens in `advance` and `stop`; neither blocks."""

    def __init__(self, spec: ProcessSpec, logs: Path, environment: Mapping[str, str]) -> None:
        self.spec = spec
        self.log_path = logs / f"{spec.name}.log"
        self._ready_path = logs / f".{spec.name}.ready"
        self._environment = {**environment, READY_FILE_VARIABLE: str(self._ready_path)}
        self._process: subprocess.Popen[bytes] | None = None
        self._started_s = self._restart_at_s = 0.0
        self._asked_s: float | None = None
        self._told_s: float | None = None
        self._failed_s: deque[float] = deque()
        self._exit_code: int | None = None
        self._was_ready = False
        self.state = ProcessState.WAITING
        self.restarts = 0

    @property
    def lets_next_start(self) -> bool:
        """The processes after this one in the table may run: it is or once was ready, or need not be."""
        if self._was_ready or self.state in (ProcessState.EXITED, ProcessState.FAILED):
            return True
        return self.state is not ProcessState.WAITING and not self.spec.holds_next

    def advance(self, now_s: float) -> str | None:
        """Go on to the next state. Text: the process is given up, and why."""
        if self.state is ProcessState.WAITING or (
            self.state is ProcessState.BACKOFF and now_s >= self._restart_at_s
        ):
            self._start(now_s)
        if self.state not in (ProcessState.STARTING, ProcessState.RUNNING):
            return None
        assert self._process is not None
        code = self._process.poll()
        if code is not None:
            return self._ended(now_s, code)
        if self.state is ProcessState.STARTING:
            if self.spec.ready is ReadyWhen.STARTED or self._ready_path.exists():
                self.state = ProcessState.RUNNING
                self._was_ready = True
            elif now_s - self._started_s > self.spec.ready_timeout_s:
                _kill_group(self._process.pid)
                self._process.wait()
                return self._died(now_s, f"was not ready after {self.spec.ready_timeout_s:g} s")
        return None

    def stop(self, now_s: float, kill: bool = False) -> bool:
        """Take the next step towards the end of the process; True when it and all it started are gone."""
        process = self._process
        if process is None:
            if self.state not in (ProcessState.EXITED, ProcessState.FAILED):
                self.state = ProcessState.STOPPED
            return True
        if process.poll() is None:
            self._urge(process, now_s, kill)
            return False
        self._exit_code = process.returncode
        self._clear_group()
        self._ready_path.unlink(missing_ok=True)
        self.state = ProcessState.STOPPED
        return True

    def status(self, now_s: float) -> ProcessStatus:
        pid = self._process.pid if self._process is not None and self._process.returncode is None else None
        cpu_s, memory_mb = _usage(pid) if pid is not None else (0.0, 0.0)
        return ProcessStatus(
            name=self.spec.name,
            pid=pid,
            state=self.state,
            restarts=self.restarts,
            cpu_s=cpu_s,
            memory_mb=memory_mb,
            uptime_s=now_s - self._started_s if pid is not None else 0.0,
            exit_code=self._exit_code,
            exit_text=exit_text(self._exit_code),
        )

    def _start(self, now_s: float) -> None:
        self._ready_path.unlink(missing_ok=True)
        spec = self.spec
        command = [
            sys.executable, "-I", "-S", launcher.__file__, str(os.getpid()),
            launcher.NONE if spec.core is None else str(spec.core),
            launcher.NONE if spec.nice is None else str(spec.nice),
            *spec.argv,
        ]  # fmt: skip
        with self.log_path.open("ab") as out:
            self._process = subprocess.Popen(
                command,
                stdin=subprocess.DEVNULL,
                stdout=out,
                stderr=subprocess.STDOUT,
                env=self._environment,
                start_new_session=True,
            )
        self._started_s = now_s
        self._asked_s = self._told_s = None
        self.state = ProcessState.STARTING

    def _ended(self, now_s: float, code: int) -> str | None:
        self._exit_code = code
        self._clear_group()
        if code == EXIT_CANNOT_RUN:
            self.state = ProcessState.FAILED
            return "cannot be run as it was asked to (exit code 2)"
        if not self.spec.restart.restart or (code == EXIT_OK and not self.spec.restart.after_success):
            self.state = ProcessState.EXITED
            return None
        return self._died(now_s, exit_text(code))

    def _died(self, now_s: float, how: str) -> str | None:
        self._process = None
        policy = self.spec.restart
        self._failed_s.append(now_s)
        while now_s - self._failed_s[0] > policy.window_s:
            self._failed_s.popleft()
        failures = len(self._failed_s)
        self._note(f"{self.spec.name} {how}")
        if failures >= policy.max_failures or not policy.restart:
            self.state = ProcessState.FAILED
            return how if failures == 1 else f"{how}, {failures} times within {policy.window_s:g} s"
        delay_s = policy.delay_s(failures)
        self._note(f"{self.spec.name} is started again in {delay_s:g} s")
        self._restart_at_s = now_s + delay_s
        self.restarts += 1
        self.state = ProcessState.BACKOFF
        return None

    def _urge(self, process: subprocess.Popen[bytes], now_s: float, kill: bool) -> None:
        if kill:
            _kill_group(process.pid)
        elif self._asked_s is None:
            self._asked_s = now_s
            process.send_signal(signal.SIGINT)
        elif self._told_s is None:
            if now_s - self._asked_s > self.spec.stop_timeout_s:
                self._told_s = now_s
                process.terminate()
        elif now_s - self._told_s > TERMINATE_AFTER_S:
            self._note(f"{self.spec.name} did not end by itself and was killed")
            _kill_group(process.pid)

    def _clear_group(self) -> None:
        """End what the process started itself and left behind."""
        assert self._process is not None
        pgid = self._process.pid
        self._process = None
        deadline_s = time.monotonic() + GROUP_TIMEOUT_S
        while _kill_group(pgid) and _group_lives(pgid) and time.monotonic() < deadline_s:
            time.sleep(0.005)

    def _note(self, text: str) -> None:
        """A line of the supervisor's own in the process's log."""
        stamp_s = time.time()
        when = time.strftime("%H:%M:%S", time.localtime(stamp_s)) + f".{int(stamp_s * 1000) % 1000:03d}"
        with self.log_path.open("a", encoding="utf-8") as out:
            out.write(f"{when} WARNING supervisor: {text}\n")


def exit_text(code: int | None) -> str:
    """How a process ended, in words."""
    if code is None:
        return ""
    if code >= 0:
        return f"ended with exit code {code}"
    try:
        return f"was ended by {signal.Signals(-code).name}"
    except ValueError:
        return f"was ended by signal {-code}"


def _kill_group(pgid: int) -> bool:
    """Kill a process and all it started; False when there was none left."""
    try:
        os.killpg(pgid, signal.SIGKILL)
    except (ProcessLookupError, PermissionError):
        return False
    return True


def _group_lives(pgid: int) -> bool:
    """Whether a process of the group still runs; one that only waits to be reaped does not."""
    for entry in os.listdir("/proc"):
        if entry.isdigit():
            fields = _stat_fields(int(entry))
            if fields and int(fields[2]) == pgid and fields[0] not in ("Z", "X"):
                return True
    return False


def _usage(pid: int) -> tuple[float, float]:
    """(CPU time in s, resident memory in MB) of a process; zeros when it is gone."""
    fields = _stat_fields(pid)
    if not fields:
        return 0.0, 0.0
    ticks = int(fields[11]) + int(fields[12])
    pages = int(fields[21])
    return ticks / os.sysconf("SC_CLK_TCK"), pages * os.sysconf("SC_PAGE_SIZE") / 1e6


def _stat_fields(pid: int) -> list[str]:
    """The fields of /proc/<pid>/stat from the third (state) on; proc(5)."""
    try:
        text = Path(f"/proc/{pid}/stat").read_text(encoding="ascii", errors="replace")
    except OSError:
        return []
    return text[text.rindex(")") + 2 :].split()
