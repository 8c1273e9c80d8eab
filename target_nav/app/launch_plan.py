"""What `ros2 launch` shall do, as plain data out of the process table: commands, environments, restarts.

The launch files turn it into launch's own actions (`launch_actions`). Nothing here needs ROS, so that it can be tested
where launch is not installed.
"""

from __future__ import annotations

import os
import sys
from collections import deque
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from enum import Enum
from pathlib import Path

from target_nav.app import gui_launch, launcher, wait_for
from target_nav.app.paths import REFERENCE_MISSION
from target_nav.app.process import EXIT_CANNOT_RUN, READY_FILE_VARIABLE
from target_nav.app.process_spec import ProcessSpec, ReadyWhen
from target_nav.app.process_table import StackOptions, recorder, robot_stack, simulation_stack
from target_nav.app.robot_ports import arduino_port, lidar_port
from target_nav.app.run_folder import make_run_folder
from target_nav.app.settings import default_settings_file, load_config, write_config
from target_nav.app.supervised import exit_text
from target_nav.app.supervisor import process_environment
from target_nav.config import Config
from target_nav.errors import ConfigError
from target_nav.sim.arena import load_arena

BRINGUP_ARGUMENTS = {
    "mission": (REFERENCE_MISSION, "mission file, or a name in trees/"),
    "sim": ("", "arena file or name: simulate. Empty: the robot"),
    "seed": ("1", "of all that is random in the simulator"),
    "go": ("false", "begin the mission without waiting for an operator's GO"),
    "gui": ("false", "open the operator's panel, where there is a display"),
    "record": ("false", "record the stack's topics into a bag in the run's folder"),
    "own_lidar_driver": ("false", "drive the LiDAR with lidar_node even where rplidar_ros is installed"),
    "config": ("", "YAML file of dotted keys, as in lidar.rate_hz: 10.0"),
    "settings": ("", "YAML file of the operator's saved changes. Empty: the robot's own, none in simulation"),
    "prefix": (Config().ipc.prefix, "of the channels in /dev/shm"),
    "out": ("runs", "parent of the run's folder"),
}
"""Name to default and description."""

RECORD_ARGUMENTS = {
    "output": ("", "folder of the bag; empty: bag in a new run's folder"),
    "topics": ("", "instead of those of this stack, separated by blanks"),
    "out": ("runs", "parent of the run's folder"),
}


@dataclass(frozen=True)
class PlannedProcess:
    """One process for launch to start: the row of the table, the whole command, and what its environment gets."""

    spec: ProcessSpec
    command: tuple[str, ...]
    environment: Mapping[str, str]


@dataclass(frozen=True)
class Plan:
    run_dir: Path
    processes: tuple[PlannedProcess, ...]
    notes: tuple[str, ...] = ()


def plan_bringup(values: Mapping[str, str]) -> Plan:
    """The whole stack, for the values of BRINGUP_ARGUMENTS. Makes the run's folder.

    Raises:
        ConfigError: a value that cannot be used.
    """
    config = load_config(Path(values["config"])) if values["config"] else Config()
    config = config.override({"ipc.prefix": values["prefix"]}, source="prefix:=")
    if values["sim"]:
        config = load_arena(values["sim"], config).config
    record, seed = _switch(values, "record"), _whole(values, "seed")
    go, panel, own_driver = (_switch(values, name) for name in ("go", "gui", "own_lidar_driver"))
    run_dir = make_run_folder(Path(values["out"])).path.resolve()
    config_file = run_dir / "config.yaml"
    write_config(config, config_file)
    no_panel = gui_launch.problem() if panel else ""
    if not values["settings"]:
        settings_file = run_dir / "settings.yaml" if values["sim"] else default_settings_file()
    else:
        settings_file = Path(values["settings"])
    options = StackOptions(
        run_dir,
        values["mission"],
        values["prefix"],
        config_file,
        go=go,
        bag=run_dir / "bag" if record else None,
        own_lidar_driver=own_driver,
        gui=panel and not no_panel,
        settings_file=settings_file.absolute(),
    )
    if values["sim"]:
        specs = simulation_stack(options, values["sim"], seed)
    else:
        saved = load_config(settings_file, config) if settings_file.exists() else config
        specs = robot_stack(options, arduino_port(saved), lidar_port(saved))
    return _plan(specs, run_dir, (f"gui:=true: {no_panel}",) if no_panel else ())


def plan_record(values: Mapping[str, str]) -> Plan:
    """The recorder alone, for the values of RECORD_ARGUMENTS, beside a stack that runs already."""
    run_dir = make_run_folder(Path(values["out"])).path.resolve()
    bag = Path(values["output"]) if values["output"] else run_dir / "bag"
    options = StackOptions(run_dir, REFERENCE_MISSION, Config().ipc.prefix)
    return _plan((recorder(options, bag, values["topics"].split()),), run_dir, ())


def _plan(specs: Iterable[ProcessSpec], run_dir: Path, notes: tuple[str, ...]) -> Plan:
    logs = run_dir / "logs"
    logs.mkdir(exist_ok=True)
    processes: list[PlannedProcess] = []
    waits_for: tuple[str, ...] = ()
    for spec in specs:
        ready = logs / f".{spec.name}.ready"
        environment = {**process_environment(run_dir), READY_FILE_VARIABLE: str(ready)}
        processes.append(PlannedProcess(spec, (*waits_for, *_launched(spec)), environment))
        if spec.holds_next and spec.ready is ReadyWhen.REPORTED:
            waiter = (interpreter(), "-I", "-S", wait_for.__file__, str(ready), f"{spec.ready_timeout_s:g}")
            waits_for = (*waits_for, *waiter)
    return Plan(run_dir, tuple(processes), notes)


def _launched(spec: ProcessSpec) -> tuple[str, ...]:
    """The command behind `launcher`, which gives it core and niceness and lets it die with this process."""
    program, *rest = spec.argv
    placing = (launcher.NONE if wanted is None else str(wanted) for wanted in (spec.core, spec.nice))
    chosen = interpreter() if program == sys.executable else program
    return (interpreter(), "-I", "-S", launcher.__file__, str(os.getpid()), *placing, chosen, *rest)


def interpreter(environment: Mapping[str, str] | None = None) -> str:
    """The Python for the processes: `ros2 launch` itself runs on the system's, also where an environment is active."""
    active = (os.environ if environment is None else environment).get("VIRTUAL_ENV")
    if active and sys.prefix == sys.base_prefix:
        python = Path(active) / "bin" / "python"
        if python.exists():
            return str(python)
    return sys.executable


class Answer(Enum):
    """To the end of a process."""

    RESTART = "restart"
    STOP_ALL = "stop all"
    NOTHING = "nothing"


@dataclass
class ExitRule:
    """What to do when one process ends by itself: the table's restart policy, as the supervisor reads it."""

    spec: ProcessSpec
    _failed_s: deque[float] = field(default_factory=deque)

    def answer(self, now_s: float, code: int) -> tuple[Answer, float, str]:
        """The answer, the delay of a restart in seconds, and what to tell."""
        policy, name = self.spec.restart, self.spec.name
        given_up = Answer.STOP_ALL if self.spec.critical else Answer.NOTHING
        if code == EXIT_CANNOT_RUN:
            return given_up, 0.0, f"process {name} cannot be run as it was asked to (exit code 2)"
        if not policy.restart:
            return Answer.NOTHING, 0.0, f"process {name} {exit_text(code)}"
        self._failed_s.append(now_s)
        while now_s - self._failed_s[0] > policy.window_s:
            self._failed_s.popleft()
        failures = len(self._failed_s)
        if failures >= policy.max_failures:
            text = f"process {name} {exit_text(code)}, {failures} times within {policy.window_s:g} s"
            return given_up, 0.0, text
        delay_s = policy.delay_s(failures)
        return (
            Answer.RESTART,
            delay_s,
            f"process {name} {exit_text(code)}; it is started again in {delay_s:g} s",
        )


def _switch(values: Mapping[str, str], name: str) -> bool:
    words = {
        "true": True,
        "1": True,
        "yes": True,
        "on": True,
        "false": False,
        "0": False,
        "no": False,
        "off": False,
    }
    word = values[name].strip().lower()
    if word not in words:
        raise ConfigError(f"{name}:={values[name]}: it must be true or false")
    return words[word]


def _whole(values: Mapping[str, str], name: str) -> int:
    try:
        return int(values[name])
    except ValueError as error:
        raise ConfigError(f"{name}:={values[name]}: it must be a whole number") from error
