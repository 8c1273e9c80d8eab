"""How the panel's process is started, and why it is not where it cannot be."""

from __future__ import annotations

import stat
import subprocess
import sys
from pathlib import Path

import pytest

from target_nav.app import gui_boot, gui_launch
from target_nav.app.process_table import StackOptions, robot_stack, simulation_stack


def test_the_command_is_isolated_from_this_environment() -> None:
    env, *dropped = gui_launch.command("--prefix", "x")
    assert env == "/usr/bin/env"
    assert dropped[:4] == ["-u", "LD_LIBRARY_PATH", "-u", "_ROS_WHEELS_BOOTSTRAP_COMPLETE"]
    assert dropped[4:] == [gui_launch.python_of(), "-I", gui_boot.__file__, "--prefix", "x"]


def test_another_python_can_be_named() -> None:
    assert gui_launch.python_of({gui_launch.PYTHON_VARIABLE: "/opt/python"}) == "/opt/python"
    assert gui_launch.python_of({}) == "/usr/bin/python3"


def test_without_a_display_there_is_no_panel_and_the_reason_names_what_does_its_work() -> None:
    problem = gui_launch.problem({})
    assert "no display" in problem
    assert "target-nav say" in problem


@pytest.mark.parametrize("script", ["exit 1", "echo 'ModuleNotFoundError: gi' >&2; exit 1"])
def test_a_python_without_gtk_is_told_with_the_packages_to_install(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, script: str
) -> None:
    python = tmp_path / "python3"
    python.write_text(f"#!/bin/sh\n{script}\n")
    python.chmod(python.stat().st_mode | stat.S_IXUSR)
    monkeypatch.setenv(gui_launch.PYTHON_VARIABLE, str(python))
    assert "gir1.2-gtk-3.0" in gui_launch.problem({"DISPLAY": ":0"})


def test_a_python_that_is_not_there_is_told(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv(gui_launch.PYTHON_VARIABLE, "/nowhere/python3")
    assert "/nowhere/python3 is not there" in gui_launch.missing_packages()


def test_what_ros_adds_to_the_command_line_is_left_out() -> None:
    assert gui_launch.without_ros(["--prefix", "a", "--ros-args", "-r", "x:=y", "--", "--windowed"]) == [
        *("--prefix", "a", "--windowed")
    ]


def test_the_package_can_be_imported_by_its_place_alone(tmp_path: Path) -> None:
    done = subprocess.run(
        [sys.executable, "-I", gui_boot.__file__, "--help"],
        cwd=tmp_path, capture_output=True, text=True, check=False,
    )  # fmt: skip
    assert done.returncode == 0, done.stderr
    assert "panel" in done.stdout


def test_view_models_and_their_reader_import_without_gtk_ros_and_trees() -> None:
    code = (
        "import sys\nfor m in ('gi', 'rclpy', 'py_trees', 'cv2'): sys.modules[m] = None\n"
        "import target_nav.gui.model, target_nav.gui.operator, target_nav.gui.settings, target_nav.gui.calibration"
    )
    subprocess.run([sys.executable, "-c", code], check=True)


def test_the_panel_is_the_last_row_of_the_table_on_core_0_and_the_robot_does_without_it(
    tmp_path: Path,
) -> None:
    options = StackOptions(
        tmp_path, "bowling_pin", "t1", cores=4, gui=True, settings_file=tmp_path / "s.yaml"
    )
    for stack in (simulation_stack(options, "open_floor", 1), robot_stack(options, "/dev/a", environment={})):
        panel = stack[-1]
        assert (panel.name, panel.core, panel.critical) == ("gui", 0, False)
        assert panel.argv[panel.argv.index("--settings") + 1] == str(tmp_path / "s.yaml")
        nav = next(spec for spec in stack if spec.name == "nav")
        assert "--settings" in nav.argv
    plain = StackOptions(tmp_path, "bowling_pin", "t1", cores=4)
    assert "gui" not in [spec.name for spec in simulation_stack(plain, "open_floor", 1)]
