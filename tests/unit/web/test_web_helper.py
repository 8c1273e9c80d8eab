"""What the helper process does: a mission checked before it is saved, a recording as frames."""

from __future__ import annotations

import json
import shutil
from pathlib import Path

import numpy as np
import pytest

from target_nav.app.web_helper import Recordings, check
from target_nav.config import Config
from target_nav.errors import TargetNavError
from target_nav.gui.missions import mission_folder
from target_nav.mission import load_mission
from target_nav.state.types import (
    Inputs,
    NavState,
    Odometry,
    Outcome,
    OutcomeKind,
    Pose2D,
    Scan,
    TickRecord,
    Twist2D,
)


@pytest.fixture
def trees(tmp_path: Path) -> Path:
    return Path(shutil.copytree(mission_folder(), tmp_path / "trees"))


def test_a_shipped_mission_is_right_and_every_part_of_it_too(trees: Path) -> None:
    for name in ("bowling_pin.xml", "subtrees/find.xml", "subtrees/approach.xml"):
        assert check(str(trees), name, (trees / name).read_text()) == [], name


def test_a_mistake_is_told_at_its_line_and_nothing_is_written(trees: Path) -> None:
    good = (trees / "bowling_pin.xml").read_text()
    bad = good.replace("<MissionRequested/>", "<MissionRequestd/>")
    line = bad.split("\n").index(next(each for each in bad.split("\n") if "MissionRequestd" in each)) + 1
    (problem,) = check(str(trees), "bowling_pin.xml", bad)
    assert (problem["file"], problem["line"], problem["severity"]) == ("bowling_pin.xml", line, "error")
    assert 'did you mean "MissionRequested"?' in problem["message"]
    assert (trees / "bowling_pin.xml").read_text() == good


def test_a_part_is_looked_at_as_the_missions_use_it(trees: Path) -> None:
    text = (trees / "subtrees" / "find.xml").read_text()
    assert "{turn_s}" in text
    problems = check(str(trees), "subtrees/find.xml", text.replace("{turn_s}", "{turn_seconds}"))
    assert any("turn_seconds" in p["message"] and p["file"] == "subtrees/find.xml" for p in problems)


def test_text_of_a_file_that_is_not_there_yet_is_checked_as_well(trees: Path) -> None:
    assert check(str(trees), "new.xml", "<root>")[0]["severity"] == "error"
    assert not (trees / "new.xml").exists()


@pytest.fixture
def recording(tmp_path: Path) -> Path:
    pytest.importorskip("mcap")
    from target_nav.app.recording import RunRecorder, header_of

    path = tmp_path / "run.mcap"
    mission = load_mission(mission_folder() / "bowling_pin.xml")
    ranges = np.full(8, 2.0)
    ranges[0] = np.inf
    with RunRecorder(path, header_of(Config(), mission)) as recorder:
        for number in range(60):
            now_s = 50.0 + 0.05 * number
            odometry = Odometry(now_s, Pose2D(0.01 * number, 0.0, 0.0), Twist2D(0.2))
            scan = Scan(now_s, 0.0, 0.785, 0.0, 0.15, 12.0, ranges) if number % 4 == 0 else None
            last = number == 59
            recorder.record(
                Inputs(now_s, scan, odometry, (odometry,)),
                TickRecord(
                    now_s, NavState.ARRIVED if last else NavState.NAVIGATING, "Arrived" if last else "Navigate",
                    Twist2D(0.2), Twist2D(0.2), "", None,
                    Outcome(OutcomeKind.SUCCEEDED, "there") if last else None, "", "RUNNING",
                    {"/Bowling pin": "RUNNING"},
                ),
            )  # fmt: skip
    return path


def test_a_recording_is_frames_of_the_same_views(recording: Path) -> None:
    recordings = Recordings()
    opened = recordings.open(str(recording))
    assert opened["mission"] == "bowling_pin"
    stamps = [mark[1] for mark in opened["marks"]]
    assert stamps[0] == 0.0
    assert stamps[-1] == pytest.approx(2.95)
    assert 28 <= len(stamps) <= 32, "about every second tick, and the one in which the state changes"
    assert opened["marks"][-1][2:4] == ["ARRIVED", "Arrived"]
    assert opened["path_m"][-2] == 118
    frame = json.loads(recordings.frame(str(recording), opened["end"] - 1))
    assert (frame["status"]["headline"], frame["status"]["outcome"]) == ("ARRIVED", "succeeded")
    assert len(frame["radar"]["points_m"]) == 14, "seven of eight beams came back"
    rows = frame["tree"]["rows"]
    assert rows[0][:5] == ["Bowling pin", "Sequence", 0, "RUNNING", 1]
    assert len(rows) > 20
    assert {row[3] for row in rows[1:]} == {"INVALID"}
    assert "not in a recording" in frame["camera"]["message"]


def test_a_file_that_is_no_recording_is_told(tmp_path: Path) -> None:
    pytest.importorskip("mcap")
    path = tmp_path / "run.mcap"
    path.write_bytes(b"nothing of the kind")
    with pytest.raises(TargetNavError, match="not a recording"):
        Recordings().open(str(path))
