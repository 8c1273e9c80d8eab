"""The camera process's one child: the detector, started, watched, and started again when it dies.

Killed, it is back after at most 100 ms and its own start. What dies again and again before it was ever ready is given
up, and what cannot be run at all is told at once; but a camera that worked and was pulled out may be plugged in again,
so that is tried until it works, while the robot stands still for want of pictures.
"""

from __future__ import annotations

import logging
import os
import time
from collections.abc import Callable
from dataclasses import replace
from enum import Enum
from pathlib import Path

from target_nav.app.detector_program import MODEL_CLASS, DetectorCommand
from target_nav.app.log_merge import last_lines
from target_nav.app.logs import CountedWarnings
from target_nav.app.process_spec import ProcessSpec, ReadyWhen, RestartPolicy
from target_nav.app.supervised import Child, ProcessState
from target_nav.errors import DeviceError

RESTARTS = RestartPolicy(
    after_success=False, first_delay_s=0.02, max_delay_s=0.1, max_failures=1_000_000, window_s=5.0
)
FAILED_STARTS_MAX = 5
"""So many ends in a row without having been ready, and it is given up."""
RETRY_S = 1.0
"""A detector that worked once and now cannot be run is tried this often."""
TAIL_LINES = 6
STOP_S = 0.5

log = logging.getLogger(__name__)


ROS_WHEELS = ("_ROS_WHEELS_BOOTSTRAP_COMPLETE", "LD_LIBRARY_PATH")
"""What the environment of ROS from wheels leaves in its processes: its libraries are not for the system's OpenCV."""


class DetectorState(Enum):
    STARTING = "starting"
    RUNNING = "running"
    RESTARTING = "restarting"
    ENDED = "ended"
    """Its video or folder came to an end, which is no failure."""


class DetectorProcess:
    """`advance` as often as the camera process looks for boxes; `close` ends the detector."""

    def __init__(
        self,
        choose: Callable[[str], DetectorCommand],
        logs: Path,
        core: int | None = None,
        class_name: str = MODEL_CLASS,
    ) -> None:
        """`choose` tells how to start the detector of a class; `logs` gets `detector.log`."""
        logs.mkdir(parents=True, exist_ok=True)
        self._choose = choose
        self._command = choose(class_name)
        self.restarts = 0
        self._logs = logs
        self._spec = ProcessSpec(
            "detector",
            self._command.argv,
            core=core,
            ready=ReadyWhen.REPORTED,
            restart=RESTARTS,
            stop_timeout_s=STOP_S,
        )
        self._environment = _environment()
        self._child = Child(self._spec, logs, self._environment)
        self._warnings = CountedWarnings(log)
        self._was_running = False
        self._failed_starts = 0
        self._known_restarts = 0
        self._retry_at_s: float | None = None
        self._ended_told = False
        log.info("detector: %s", self._command.description)

    @property
    def state(self) -> DetectorState:
        if self._child.state is ProcessState.RUNNING:
            return DetectorState.RUNNING
        if self._child.state is ProcessState.EXITED:
            return DetectorState.ENDED
        return DetectorState.RESTARTING if self._was_running or self.restarts else DetectorState.STARTING

    @property
    def pid(self) -> int | None:
        return self._child.status(0.0).pid

    @property
    def log_path(self) -> Path:
        return self._child.log_path

    def advance(self, now_s: float) -> None:
        """Start what is to be started, notice what has ended.

        Raises:
            DeviceError: the detector cannot be run, or died again and again before it was ready; with the last lines of
                its log.
        """
        if self._retry_at_s is not None:
            if now_s < self._retry_at_s:
                return
            self._retry_at_s = None
            self._child = Child(self._spec, self._logs, self._environment)
            self._known_restarts = 0
        failure = self._child.advance(now_s)
        if failure:
            self._cannot_run(failure, now_s)
        elif self._child.state is ProcessState.RUNNING:
            self._was_running = True
            self._failed_starts = 0
        elif self._child.restarts > self._known_restarts:
            self._note_death()
        elif self._child.state is ProcessState.EXITED and not self._ended_told:
            self._ended_told = True
            log.warning("the detector's pictures came to an end: %s", self._last_words())

    def look_for(self, class_name: str) -> None:
        """Change to the detector of another class, if it is another one.

        Raises:
            ConfigError: it cannot be had.
        """
        command = self._choose(class_name)
        if command.argv == self._command.argv:
            return
        self._command = command
        self._spec = replace(self._spec, argv=command.argv)
        self._was_running = False
        self.restart(command.description)

    def restart(self, reason: str) -> None:
        """End the detector and start it anew, as an operator may ask."""
        log.info("the detector is started anew: %s", reason)
        self._end_child()
        self._child = Child(self._spec, self._logs, self._environment)
        self._known_restarts = 0
        self._retry_at_s = None
        self._ended_told = False
        self.restarts += 1

    def close(self) -> None:
        self._end_child()

    def _note_death(self) -> None:
        self._known_restarts = self._child.restarts
        self.restarts += 1
        self._failed_starts += 1
        how = self._child.status(0.0).exit_text
        if self._failed_starts >= FAILED_STARTS_MAX:
            raise DeviceError(self._told(f"{how}, {self._failed_starts} times in a row before it was ready"))
        self._warnings.warn("died", f"the detector {how} and is started again")

    def _cannot_run(self, failure: str, now_s: float) -> None:
        if not self._was_running:
            raise DeviceError(self._told(failure))
        self._retry_at_s = now_s + RETRY_S
        self.restarts += 1
        self._warnings.warn(
            "gone",
            f"the detector worked and now {failure}; tried again every {RETRY_S:g} s: {self._last_words()}",
        )

    def _told(self, failure: str) -> str:
        tail = "\n".join(f"    {line}" for line in last_lines(self._child.log_path, TAIL_LINES))
        return f"the detector {failure}. The end of {self._child.log_path}:\n{tail}"

    def _last_words(self) -> str:
        return (last_lines(self._child.log_path, 1) or ["(no words)"])[-1]

    def _end_child(self) -> None:
        deadline_s = time.monotonic() + 4 * STOP_S
        while not self._child.stop(time.monotonic(), kill=time.monotonic() > deadline_s):
            time.sleep(0.005)


def _environment() -> dict[str, str]:
    drop = ROS_WHEELS if ROS_WHEELS[0] in os.environ else ()
    kept = {name: value for name, value in os.environ.items() if name not in drop}
    return {**kept, "OMP_NUM_THREADS": "1", "OPENBLAS_NUM_THREADS": "1"}
