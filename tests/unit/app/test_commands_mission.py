"""`target-nav check`, `convert`, `nodes` and `render`: what they print, what they write, and their exit codes."""

from __future__ import annotations

import importlib.util
import json
import os
import sys
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from xml.etree import ElementTree

import pytest

from target_nav.app import cli
from target_nav.app.output_file import OutputError, write_output
from target_nav.config import Config
from target_nav.mission import load_mission
from target_nav.mission.tree_paths import paths_of
from target_nav.state.types import STOP, Inputs, NavState, TickRecord

GOOD = """\
<root BTCPP_format="4">
  <!-- looks round -->
  <BehaviorTree ID="Main">
    <Sequence>
      <TargetTracked/>
      <TurnSearch time_limit_s="30"/>
    </Sequence>
  </BehaviorTree>
</root>
"""
WARNED = GOOD.replace(' time_limit_s="30"', "")
BROKEN = GOOD.replace("<TargetTracked/>", "<TargetTraked/>")


@dataclass
class Said:
    code: int
    out: str
    err: str


Say = Callable[..., Said]


@pytest.fixture
def say(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str], tmp_path: Path) -> Say:
    """Runs a command line in a folder of its own."""
    monkeypatch.chdir(tmp_path)

    def run(*arguments: str) -> Said:
        monkeypatch.setattr(sys, "argv", ["target-nav", *arguments])
        with pytest.raises(SystemExit) as ended:
            cli.main()
        captured = capsys.readouterr()
        code = ended.value.code
        return Said(code if isinstance(code, int) else 0, captured.out, captured.err)

    return run


@pytest.fixture
def mission(tmp_path: Path) -> Path:
    path = tmp_path / "mission.xml"
    path.write_text(GOOD, encoding="utf-8")
    return path


# -- check -------------------------------------------------------------------------------------------------------------


def test_check_tells_errors_from_warnings(say: Say, tmp_path: Path) -> None:
    for name, text in (("good.xml", GOOD), ("warned.xml", WARNED), ("broken.xml", BROKEN)):
        (tmp_path / name).write_text(text, encoding="utf-8")
    good, warned = say("check", "good.xml"), say("check", "warned.xml")
    assert (good.code, good.out) == (0, "1 mission file: nothing wrong\n")
    assert warned.code == 0
    assert warned.out.startswith("warned.xml:6:7: warning: TurnSearch has no time limit")
    assert warned.out.endswith("1 mission file: 1 warning\n")
    assert say("check", "--strict", "warned.xml").code == 1
    assert say("check", "--strict", "good.xml").code == 0

    broken = say("check", "broken.xml", "warned.xml", "nowhere.xml")
    assert broken.code == 1
    assert 'broken.xml:5:7: error: unknown node TargetTraked; did you mean "TargetTracked"?' in broken.out
    assert "nowhere.xml:1:1: error: there is no such file\n" in broken.out
    assert broken.out.endswith("3 mission files: 2 errors, 1 warning\n")


def test_check_for_programs(say: Say, tmp_path: Path) -> None:
    (tmp_path / "m.xml").write_text(WARNED, encoding="utf-8")
    said = json.loads(say("check", "--json", "m.xml").out)
    assert (said["files"], said["errors"], said["warnings"]) == (["m.xml"], 0, 1)
    (problem,) = said["problems"]
    assert (problem["file"], problem["line"], problem["column"], problem["severity"]) == (
        "m.xml",
        6,
        7,
        "warning",
    )


def test_check_takes_the_name_of_a_shipped_mission(say: Say) -> None:
    assert say("check", "--strict", "bowling_pin").code == 0


def test_check_writes_a_schema(say: Say, tmp_path: Path) -> None:
    assert say("check", "--xsd", "mission.xsd").code == 0
    root = ElementTree.parse(tmp_path / "mission.xsd").getroot()
    assert root.tag == "{http://www.w3.org/2001/XMLSchema}schema"


def test_check_without_a_file_cannot_be_run(say: Say) -> None:
    said = say("check")
    assert (said.code, "no mission file is named" in said.err) == (2, True)


# -- convert -----------------------------------------------------------------------------------------------------------


def test_convert_there_and_back(say: Say, mission: Path, tmp_path: Path) -> None:
    assert say("convert", "mission.xml", "mission.yaml").code == 0
    assert (tmp_path / "mission.yaml").read_text(encoding="utf-8") == (
        "BTCPP_format: 4\n\ntrees:\n  # looks round\n  Main:\n    Sequence:\n    - TargetTracked\n"
        "    - TurnSearch: {time_limit_s: 30}\n"
    )
    assert say("check", "mission.yaml").code == 0
    assert say("convert", "mission.yaml", "back.xml").code == 0
    assert [n.name for n in load_mission(tmp_path / "back.xml").root.iterate()] == [
        n.name for n in load_mission(mission).root.iterate()
    ]


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (("mission.xml", "mission.json"), 'mission.json: has suffix ".json"; a mission file ends in .xml'),
        (("mission.xml", "mission"), "mission: has no suffix"),
        (("nowhere.xml", "m.yaml"), "nowhere.xml:1:1: error: there is no such file"),
        (("mission.xml", "nowhere/m.yaml"), "nowhere/m.yaml: there is no folder nowhere; make it first"),
        (("mission.xml", "folder.yaml"), "folder.yaml: is a folder; name a file in it"),
    ],
)  # fmt: skip
def test_what_cannot_be_converted(
    say: Say, mission: Path, tmp_path: Path, arguments: tuple[str, str], message: str
) -> None:
    (tmp_path / "folder.yaml").mkdir()
    said = say("convert", *arguments)
    assert said.code == 2
    assert message in said.err


def test_a_broken_file_leaves_its_target_as_it_was(say: Say, tmp_path: Path) -> None:
    (tmp_path / "m.xml").write_text(GOOD[:-20], encoding="utf-8")
    (tmp_path / "m.yaml").write_text("precious", encoding="utf-8")
    assert say("convert", "m.xml", "m.yaml").code == 2
    assert (tmp_path / "m.yaml").read_text(encoding="utf-8") == "precious"


# -- nodes -------------------------------------------------------------------------------------------------------------


def test_nodes_as_tables(say: Say) -> None:
    everything = say("nodes").out
    assert "TurnSearch" in everything
    assert "Sequence" in everything
    some = say("nodes", "search", "timeout").out
    assert "TurnSearch" in some
    assert "Timeout" in some
    assert "Sequence " not in some
    said = say("nodes", "qwertz")
    assert (said.code, "no node's name contains qwertz" in said.err) == (2, True)


def test_nodes_as_files(say: Say, tmp_path: Path) -> None:
    assert say("nodes", "--groot", "-o", "palette.xml").code == 0
    assert ElementTree.parse(tmp_path / "palette.xml").getroot().tag == "root"
    assert say("nodes", "--markdown").out.startswith("# The words of a mission\n")
    assert say("nodes", "--markdown", "--groot").code == 2
    assert say("nodes", "--groot", "Sequence").code == 2
    assert say("nodes", "-o", "x.txt").code == 2


# -- render ------------------------------------------------------------------------------------------------------------


def test_render_to_the_terminal_and_to_files(say: Say, mission: Path, tmp_path: Path) -> None:
    assert say("render", "mission.xml").out.splitlines() == [
        "→ Sequence", "├── TargetTracked", "└── TurnSearch  time_limit_s 30"
    ]  # fmt: skip
    assert say("render", "mission.xml", "-o", "tree.txt").code == 0
    assert (tmp_path / "tree.txt").read_text(encoding="utf-8").startswith("mission.xml\n\n→ Sequence\n")
    assert say("render", "mission.xml", "-o", "tree.svg").code == 0
    assert ElementTree.parse(tmp_path / "tree.svg").getroot().tag.endswith("svg")
    if importlib.util.find_spec("matplotlib") is not None:
        assert say("render", "mission.xml", "-o", "tree.PNG").code == 0
        assert (tmp_path / "tree.PNG").read_bytes().startswith(b"\x89PNG")


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (("mission.xml", "-o", "tree.pdf"), "tree.pdf: a picture is .svg, .png or .txt"),
        (("mission.xml", "-o", "nowhere/tree.svg"), "nowhere/tree.svg: there is no folder nowhere"),
        ((), "name a mission, or a run with --run"),
        (("mission.xml", "--at", "3"), "--at is a moment of a run"),
        (("nowhere.xml",), "there is no such file"),
        (("mission.xml", "--run", "nowhere"), "does not exist"),
    ],
)  # fmt: skip
def test_what_cannot_be_rendered(say: Say, mission: Path, arguments: tuple[str, ...], message: str) -> None:
    said = say("render", *arguments)
    assert said.code == 2
    assert message in said.err


@pytest.fixture
def run(mission: Path, tmp_path: Path) -> Path:
    """A recording of 4 ticks, 0.05 s from each other: the track is lost, and the search begins."""
    pytest.importorskip("mcap")
    from target_nav.app.recording import RunRecorder, header_of

    loaded = load_mission(mission)
    root, tracked, search = ("/Sequence", "/Sequence/TargetTracked", "/Sequence/TurnSearch")
    assert {root, tracked, search} == set(paths_of(loaded.root).values())
    ticks = [{root: "FAILURE", tracked: "FAILURE"}] * 2 + [
        {root: "RUNNING", tracked: "SUCCESS", search: "RUNNING"}
    ] * 2
    folder = tmp_path / "run"
    folder.mkdir()
    with RunRecorder(folder / "run.mcap", header_of(Config(), loaded)) as recorder:
        for number, statuses in enumerate(ticks):
            now_s = 100.0 + 0.05 * number
            leaf = "TurnSearch" if search in statuses else ""
            record = TickRecord(
                now_s, NavState.SEARCHING, leaf, STOP, STOP, "", None, None, "turns", statuses[root], statuses
            )
            recorder.record(Inputs(now_s), record)
    mission.unlink()
    return folder


def test_render_a_recorded_tick(say: Say, run: Path, tmp_path: Path) -> None:
    """The recording has its mission in it; the file is gone."""
    assert say("render", "--run", "run", "--at", "0.05").out.splitlines() == [
        "✘ → Sequence", "├── ✘ TargetTracked", "└── · TurnSearch  time_limit_s 30"
    ]  # fmt: skip
    assert say("render", "--run", "run/run.mcap", "-o", "end.txt").code == 0
    assert (tmp_path / "end.txt").read_text(encoding="utf-8").splitlines() == [
        "mission.xml at 0.15 s: SEARCHING, TurnSearch: turns",
        "",
        "▶ → Sequence", "├── ✔ TargetTracked", "└── ▶ TurnSearch  time_limit_s 30",
    ]  # fmt: skip
    assert say("render", "--run", "run", "-o", "end.svg").code == 0
    assert "running" in (tmp_path / "end.svg").read_text(encoding="utf-8")


def test_a_moment_outside_of_the_run(say: Say, run: Path) -> None:
    said = say("render", "--run", "run", "--at", "5")
    assert (said.code, "5 s is after its end; it lasts 0.15 s" in said.err) == (2, True)


def test_a_run_of_another_mission(say: Say, run: Path, tmp_path: Path) -> None:
    (tmp_path / "other.xml").write_text(GOOD.replace("TurnSearch", "SpiralSearch"), encoding="utf-8")
    said = say("render", "other.xml", "--run", "run")
    assert said.code == 2
    assert "the mission has no node /Sequence/TurnSearch; the recording is of another mission" in said.err


def test_a_recording_without_ticks(say: Say, mission: Path, tmp_path: Path) -> None:
    pytest.importorskip("mcap")
    from target_nav.app.recording import RunRecorder, header_of

    with RunRecorder(tmp_path / "empty.mcap", header_of(Config(), load_mission(mission))):
        pass
    said = say("render", "--run", "empty.mcap")
    assert (said.code, "empty.mcap: holds no ticks" in said.err) == (2, True)


# -- files -------------------------------------------------------------------------------------------------------------


def test_an_output_replaces_a_file_and_keeps_its_mode_and_a_link_to_it(tmp_path: Path) -> None:
    path, link = tmp_path / "a", tmp_path / "link"
    path.write_text("old")
    path.chmod(0o640)
    link.symlink_to(path)
    write_output(link, "né")
    assert (path.read_bytes(), path.stat().st_mode & 0o777, link.is_symlink()) == ("né".encode(), 0o640, True)
    assert sorted(each.name for each in tmp_path.iterdir()) == ["a", "link"]


def test_an_output_that_cannot_be_written(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def full(*_: object) -> None:
        raise OSError(28, "No space left on device")

    path = tmp_path / "a"
    path.write_text("old")
    monkeypatch.setattr(os, "replace", full)
    with pytest.raises(OutputError, match="cannot be written: No space left on device"):
        write_output(path, "new")
    assert [(each.name, each.read_text()) for each in tmp_path.iterdir()] == [("a", "old")]


def test_an_output_may_be_a_device() -> None:
    write_output(Path(os.devnull), "new")
    assert not Path(os.devnull).is_file()
