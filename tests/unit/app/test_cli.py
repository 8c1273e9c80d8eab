"""The command line: its exit codes are 0 it worked, 1 it ran and failed, 2 it could not be run; and it says why."""

from __future__ import annotations

import json
import sys
from pathlib import Path

import pytest

from target_nav.app import cli

BROKEN = '<root BTCPP_format="4">\n  <BehaviorTree ID="A">\n    <Sequenze/>\n  </BehaviorTree>\n</root>\n'
IN_A_WALL = """\
name: in_a_wall
bounds: [-3.0, -3.0, 3.0, 3.0]
robot: {x: 0.0, y: 0.0, yaw: 0.0}
target: {class: bowling_pin, x: 2.0, y: 0.0}
obstacles:
  - {wall: [0.1, -1.0, 0.1, 1.0]}
"""


def called(monkeypatch: pytest.MonkeyPatch, *arguments: str) -> int:
    monkeypatch.setattr(sys, "argv", ["target-nav", *arguments])
    with pytest.raises(SystemExit) as ended:
        cli.main()
    code = ended.value.code
    return code if isinstance(code, int) else 0


@pytest.mark.parametrize("command", cli.COMMANDS)
def test_every_command_explains_itself(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str], command: str
) -> None:
    assert called(monkeypatch, command, "--help") == 0
    assert "Usage:" in capsys.readouterr().out


def test_an_unknown_command_cannot_be_run(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    assert called(monkeypatch, "fly") == 2
    assert "fly" in capsys.readouterr().err


def test_check_tells_good_from_bad(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    bad = tmp_path / "bad.xml"
    bad.write_text(BROKEN)
    assert called(monkeypatch, "check", "trees/bowling_pin.xml") == 0
    assert called(monkeypatch, "check", str(bad)) == 1
    assert "bad.xml:3:5: error:" in capsys.readouterr().out


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["run", "--virtual"], "--virtual needs --sim ARENA"),
        (["run", "--sim", "no_such_arena", "--virtual"], "no_such_arena"),
        (["run", "--sim", "open_floor", "--virtual", "--mission", "no_such_mission"], "no_such_mission"),
        (["campaign", "--arenas", "no_such_arena"], "no_such_arena"),
    ],
)
def test_what_cannot_be_run_ends_with_2_and_the_name_of_what_is_missing(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str], arguments: list[str], words: str
) -> None:
    assert called(monkeypatch, *arguments) == 2
    assert words in capsys.readouterr().err


def test_an_arena_with_the_robot_inside_a_wall_is_refused_with_its_line(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    arena = tmp_path / "in_a_wall.yaml"
    arena.write_text(IN_A_WALL)
    assert called(monkeypatch, "run", "--sim", str(arena), "--virtual", "--out", str(tmp_path / "runs")) == 2
    assert "in_a_wall.yaml:3: error:" in capsys.readouterr().err
    assert not (tmp_path / "runs").exists(), "nothing was started"


@pytest.mark.slow
@pytest.mark.parametrize(
    ("arena", "code", "outcome"), [("open_floor", 0, "succeeded"), ("no_pin", 1, "failed")]
)
def test_run_in_virtual_time_leaves_a_folder_and_a_result(
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
    tmp_path: Path,
    arena: str,
    code: int,
    outcome: str,
) -> None:
    pytest.importorskip("mcap")
    pytest.importorskip("matplotlib")
    result = tmp_path / "result.json"
    options = ["--virtual", "--seed", "3", "--out", str(tmp_path / "runs"), "--json", str(result)]
    assert called(monkeypatch, "run", "--sim", arena, *options) == code
    assert json.loads(result.read_text())["outcome"] == outcome
    folder = tmp_path / "runs" / "latest"
    assert {p.name for p in folder.iterdir()} == {"result.json", "run.log", "run.mcap", "run.png"}
    assert called(monkeypatch, "replay", str(folder)) == 0
    assert "every decision the same" in capsys.readouterr().out


def test_say_without_anybody_listening_says_so(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    assert called(monkeypatch, "say", "go", "--prefix", "test_nobody") == 2
    assert "nobody took GO" in capsys.readouterr().err


def test_status_without_a_nav_process_is_1(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    assert called(monkeypatch, "status", "--prefix", "test_nobody") == 1
    assert "no nav process runs" in capsys.readouterr().out


def test_doctor_examines_every_part(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    called(monkeypatch, "doctor")
    said = capsys.readouterr().out
    subjects = (
        "Python packages rclpy tf2_msgs py_trees_ros_interfaces memory channels serial camera clocks cores"
    )
    assert [subject for subject in subjects.split() if subject not in said] == []
