"""The launch files: what they would start is the process table, and it starts.

Where ROS 2's `launch` is installed, it starts them itself; elsewhere a stub of the few classes they use gives the
commands, which are then run.
"""

from __future__ import annotations

import ast
import importlib.util
import os
import shutil
import signal
import subprocess
import sys
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

from target_nav.app import launcher, wait_for
from target_nav.app.launch_plan import BRINGUP_ARGUMENTS, RECORD_ARGUMENTS, interpreter
from target_nav.app.process_table import StackOptions, recorder, robot_stack, simulation_stack
from target_nav.errors import ConfigError
from tests.utils import launch_stub
from tests.utils.processes import ros_environment, wait_until

ROOT = Path(__file__).resolve().parents[2]
BRINGUP, RECORD = ROOT / "launch" / "bringup.launch.py", ROOT / "launch" / "record.launch.py"


def load(path: Path) -> Any:
    """A launch file as a module, as launch itself imports it."""
    spec = importlib.util.spec_from_file_location("launch_file", path)
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


@pytest.fixture(autouse=True)
def stub() -> Iterator[None]:
    with launch_stub.stubbed():
        yield


def actions_of(path: Path, **given: str) -> tuple[list[Any], launch_stub.LaunchContext]:
    return launch_stub.perform(load(path).generate_launch_description(), given)


def processes_of(actions: list[Any]) -> dict[str, launch_stub.ExecuteProcess]:
    return {a.name: a for a in actions if isinstance(a, launch_stub.ExecuteProcess)}


def own_command(process: launch_stub.ExecuteProcess) -> tuple[str, ...]:
    """What is started behind launcher.py, its core and niceness."""
    return tuple(process.cmd[process.cmd.index(launcher.__file__) + 4 :])


@pytest.mark.parametrize("path", [BRINGUP, RECORD])
def test_a_launch_file_needs_launch_and_this_package_only(path: Path) -> None:
    tree = ast.parse(path.read_text(encoding="utf-8"))
    imported = {
        (node.module or "").split(".")[0] for node in ast.walk(tree) if isinstance(node, ast.ImportFrom)
    }
    assert imported == {"launch", "target_nav"}
    assert [f.name for f in tree.body if isinstance(f, ast.FunctionDef)] == ["generate_launch_description"]


@pytest.mark.parametrize(("path", "arguments"), [(BRINGUP, BRINGUP_ARGUMENTS), (RECORD, RECORD_ARGUMENTS)])
def test_arguments_are_declared_with_default_and_description(
    path: Path, arguments: dict[str, tuple[str, str]]
) -> None:
    declared = [
        entity
        for entity in load(path).generate_launch_description().entities
        if isinstance(entity, launch_stub.DeclareLaunchArgument)
    ]
    assert {d.name: (d.default_value, d.description) for d in declared} == arguments
    if path == BRINGUP:
        assert {"mission", "sim", "gui", "record"} < {d.name for d in declared}


def test_bringup_in_simulation_is_the_table(tmp_path: Path) -> None:
    actions, _ = actions_of(
        BRINGUP, sim="open_floor", seed="7", out=str(tmp_path), go="true", record="true", prefix="t9"
    )
    run_dir = (tmp_path / "latest").resolve()
    options = StackOptions(
        run_dir,
        "bowling_pin",
        "t9",
        run_dir / "config.yaml",
        go=True,
        bag=run_dir / "bag",
        settings_file=run_dir / "settings.yaml",
    )
    table = simulation_stack(options, "open_floor", 7)
    processes = processes_of(actions)
    assert list(processes) == [spec.name for spec in table]
    for spec in table:
        process = processes[spec.name]
        assert own_command(process) == spec.argv
        core, nice = process.cmd[process.cmd.index(launcher.__file__) + 2 :][:2]
        assert (core, nice) == tuple("-" if v is None else str(v) for v in (spec.core, spec.nice))
        assert process.additional_env is not None
        ready = run_dir / "logs" / f".{spec.name}.ready"
        assert process.additional_env["TARGET_NAV_READY_FILE"] == str(ready)
        assert process.additional_env["OMP_NUM_THREADS"] == "1"
        assert process.output == "both"
    assert (run_dir / "config.yaml").read_text() == "ipc.prefix: t9\n"


def test_bringup_on_the_robot_is_the_table(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.delenv("AMENT_PREFIX_PATH", raising=False)
    monkeypatch.setenv("XDG_CONFIG_HOME", str(tmp_path))
    actions, _ = actions_of(BRINGUP, out=str(tmp_path), mission="go_to_point")
    run_dir = (tmp_path / "latest").resolve()
    saved = tmp_path / "target_nav" / "settings.yaml"
    options = StackOptions(run_dir, "go_to_point", "v2n", run_dir / "config.yaml", settings_file=saved)
    table = robot_stack(options, "/dev/ttyACM0", "/dev/ttyUSB0")
    assert [own_command(p) for p in processes_of(actions).values()] == [spec.argv for spec in table]


def test_only_what_needs_the_simulators_port_waits_for_it(tmp_path: Path) -> None:
    actions, _ = actions_of(BRINGUP, sim="open_floor", out=str(tmp_path))
    processes = processes_of(actions)
    assert wait_for.__file__ not in processes["sim"].cmd
    ready = (processes["sim"].additional_env or {})["TARGET_NAV_READY_FILE"]
    for name, process in processes.items():
        if name != "sim":
            at = process.cmd.index(wait_for.__file__)
            assert process.cmd[at + 1 : at + 3] == [ready, "30"]
    robot, _ = actions_of(BRINGUP, out=str(tmp_path))
    assert not [p for p in processes_of(robot).values() if wait_for.__file__ in p.cmd]


def test_a_missing_panel_is_told(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.delenv("DISPLAY", raising=False)
    monkeypatch.delenv("WAYLAND_DISPLAY", raising=False)
    told = [a.msg for a in actions_of(BRINGUP, gui="true", out=str(tmp_path))[0] if hasattr(a, "msg")]
    assert any("no panel: there is no display" in text for text in told)
    told = [a.msg for a in actions_of(BRINGUP, out=str(tmp_path))[0] if hasattr(a, "msg")]
    assert not any("no panel" in text for text in told)


@pytest.mark.parametrize(
    ("given", "message"),
    [
        ({"record": "maybe"}, "record:=maybe: it must be true or false"),
        ({"seed": "one"}, "seed:=one: it must be a whole number"),
        ({"sim": "nowhere"}, "nowhere"),
        ({"config": "/nowhere.yaml"}, "configuration /nowhere.yaml cannot be read"),
    ],
)
def test_wrong_values_are_told_before_anything_starts(
    given: dict[str, str], message: str, tmp_path: Path
) -> None:
    with pytest.raises(ConfigError, match=message):
        actions_of(BRINGUP, out=str(tmp_path / "runs"), **given)
    assert not (tmp_path / "runs").exists()


def test_record_is_the_tables_recorder(tmp_path: Path) -> None:
    actions, _ = actions_of(RECORD, output=str(tmp_path / "bag"), topics="/scan /tf", out=str(tmp_path))
    (process,) = processes_of(actions).values()
    options = StackOptions(tmp_path, "bowling_pin", "v2n")
    assert own_command(process) == recorder(options, tmp_path / "bag", ("/scan", "/tf")).argv


def test_ends_are_answered_as_by_the_supervisor(tmp_path: Path) -> None:
    actions, context = actions_of(BRINGUP, sim="open_floor", out=str(tmp_path), record="true")
    processes = processes_of(actions)

    def end(name: str, code: int) -> list[Any]:
        on_exit = processes[name].on_exit
        assert on_exit is not None
        return on_exit(launch_stub.ProcessExited(code), context) or []

    told, timer = end("arduino", 1)
    assert "arduino ended with exit code 1; it is started again in 0.25 s" in told.msg
    assert timer.period == 0.25
    (again,) = timer.actions
    assert again.cmd == processes["arduino"].cmd
    told, timer = end("arduino", -9)
    assert timer.period == 0.5
    for _ in range(2):
        end("arduino", 1)
    told, stop = end("arduino", 1)
    assert "5 times within 30 s" in stop.event.reason

    assert isinstance(end("nav", 2)[1], launch_stub.EmitEvent)
    assert isinstance(end("sim", 1)[1], launch_stub.EmitEvent)
    assert [type(a) for a in end("recorder", 2)] == [launch_stub.LogInfo]
    context.is_shutdown = True
    assert end("camera", 0) == []


def test_processes_run_on_the_active_environments_python(tmp_path: Path) -> None:
    python = tmp_path / "bin" / "python"
    python.parent.mkdir()
    python.write_text("")
    in_environment = sys.prefix != sys.base_prefix
    assert interpreter({"VIRTUAL_ENV": str(tmp_path)}) == (sys.executable if in_environment else str(python))
    assert interpreter({}) == sys.executable


@pytest.mark.ros
@pytest.mark.linux
@pytest.mark.slow
def test_the_planned_commands_run_and_end(tmp_path: Path) -> None:
    actions, _ = actions_of(
        BRINGUP, sim="open_floor", out=str(tmp_path), prefix="test_launch", go="true", record="true"
    )
    run_dir = (tmp_path / "latest").resolve()
    running: dict[str, subprocess.Popen[bytes]] = {}
    try:
        for name, process in processes_of(actions).items():
            with (tmp_path / f"{name}.log").open("wb") as log:
                environment = {**ros_environment(), **(process.additional_env or {})}
                running[name] = subprocess.Popen(process.cmd, env=environment, stdout=log, stderr=log)
        for name, started in running.items():
            ready = run_dir / "logs" / f".{name}.ready"
            wait_until(lambda r=ready, p=started: r.exists() or p.poll() is not None, name, 60.0)
            assert started.poll() is None, (tmp_path / f"{name}.log").read_text()
        state = tmp_path / "recorder.log"
        wait_until(
            lambda: "recording /nav_state" in state.read_text(), "the recorder hearing the nav process"
        )
        time.sleep(1.0)
    finally:
        for started in reversed(running.values()):
            if started.poll() is None:
                started.send_signal(signal.SIGINT)
        codes = {name: started.wait(30.0) for name, started in running.items()}
        for path in Path("/dev/shm").glob("test_launch_*"):
            path.unlink()
    assert codes == dict.fromkeys(running, 0)
    assert (run_dir / "bag" / "metadata.yaml").is_file()


@pytest.mark.ros
@pytest.mark.slow
@pytest.mark.skipif(shutil.which("ros2") is None, reason="ros2 (with launch) is not installed")
def test_ros2_launch_starts_the_stack_and_ends_it(tmp_path: Path) -> None:
    command = [
        "ros2",
        "launch",
        str(BRINGUP),
        "sim:=open_floor",
        f"out:={tmp_path}",
        "prefix:=test_ros2_launch",
    ]
    with (tmp_path / "launch.log").open("wb") as log:
        launched = subprocess.Popen(command, env=ros_environment(), stdout=log, stderr=log)
    try:
        ready = tmp_path / "latest" / "logs" / ".nav.ready"
        wait_until(lambda: ready.exists() or launched.poll() is not None, "the nav process", 60.0)
        assert launched.poll() is None, (tmp_path / "launch.log").read_text()
    finally:
        launched.send_signal(signal.SIGINT)
        code = launched.wait(30.0)
        for path in Path("/dev/shm").glob("test_ros2_launch_*"):
            path.unlink()
    assert code in (0, 128 + signal.SIGINT, -signal.SIGINT)
    assert os.path.isdir(tmp_path / "latest" / "logs")
