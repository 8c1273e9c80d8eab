"""The watcher commands stand back where py_trees_ros has its own, and know its options."""

from __future__ import annotations

import argparse
import os
import subprocess
import sys
from pathlib import Path

import pytest

from target_nav.app import blackboard_watcher, tree_watcher

ROOT = Path(__file__).parents[3]


@pytest.mark.parametrize("program", ["tree_watcher", "blackboard_watcher"])
def test_where_py_trees_ros_is_installed_its_own_watcher_runs(tmp_path: Path, program: str) -> None:
    package = tmp_path / "py_trees_ros" / "programs"
    package.mkdir(parents=True)
    for folder in (package, package.parent):
        (folder / "__init__.py").touch()
    real = f"import sys\ndef main():\n    print('the real {program}', sys.argv[1:])\n    return 3\n"
    (package / f"{program}.py").write_text(real, encoding="utf-8")
    process = subprocess.run(
        [sys.executable, "-m", f"target_nav.app.{program}", "-n", "robot"],
        env={**os.environ, "PYTHONPATH": f"{tmp_path}{os.pathsep}{ROOT}"},
        capture_output=True,
        text=True,
        timeout=60.0,
        check=False,
    )
    assert (process.returncode, process.stdout) == (3, f"the real {program} ['-n', 'robot']\n")


@pytest.mark.parametrize(
    ("arguments", "expected"),
    [
        ([], {"topic_name": None, "mode": "snapshots", "namespace_hint": None}),
        (["-a", "-b", "-s"], {"blackboard_activity": True, "blackboard_data": True, "statistics": True}),
        (["--blackboard-data", "--blackboard-activity", "--statistics"], {"statistics": True}),
        (["-n", "robot", "/tree/snapshots"], {"namespace_hint": "robot", "topic_name": "/tree/snapshots"}),
        (["--namespace-hint", "robot", "--dot-graph"], {"mode": "dot"}),
        (["--snapshots"], {"mode": "snapshots"}),
    ],
)
def test_the_tree_watcher_has_the_options_of_the_real_one(
    arguments: list[str], expected: dict[str, object]
) -> None:
    parsed = vars(tree_watcher.parser().parse_args(arguments))
    assert {name: parsed[name] for name in expected} == expected


@pytest.mark.parametrize(
    ("arguments", "expected"),
    [
        ([], {"list": False, "variables": [], "namespace": None}),
        (["-l"], {"list": True}),
        (["--list"], {"list": True}),
        (["-v", "-a", "-n", "robot"], {"visited": True, "activity": True, "namespace": "robot"}),
        (["--visited", "--activity", "odom/pose", "track.x_m"], {"variables": ["odom/pose", "track.x_m"]}),
    ],
)
def test_the_blackboard_watcher_has_the_options_of_the_real_one(
    arguments: list[str], expected: dict[str, object]
) -> None:
    parsed = vars(blackboard_watcher.parser().parse_args(arguments))
    assert {name: parsed[name] for name in expected} == expected


def test_text_and_graph_exclude_each_other(capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit):
        tree_watcher.parser().parse_args(["--snapshots", "--dot-graph"])
    assert "not allowed with" in capsys.readouterr().err
    assert isinstance(tree_watcher.parser(), argparse.ArgumentParser)


def test_names_are_shown_below_what_they_are_of() -> None:
    text = blackboard_watcher.names_text(["/track", "/track.x_m"])
    assert [line.strip() for line in text.splitlines()[1:]] == ["/track", ".x_m"]
