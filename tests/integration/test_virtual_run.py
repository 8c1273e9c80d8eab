"""A whole mission in virtual time: it ends as it should, twice the same, and its recording replays the same."""

from __future__ import annotations

import json
import shutil
from dataclasses import replace
from pathlib import Path

import pytest

pytest.importorskip("mcap")
pytest.importorskip("matplotlib")

from target_nav.app.campaign import LinesInOrder, execute, orders
from target_nav.app.paths import mission_path
from target_nav.app.recording import RecordingError, RunRecorder, header_of, read_run
from target_nav.app.replay import replay
from target_nav.app.run_picture import draw_run
from target_nav.app.spread import run_all
from target_nav.app.virtual import RunResult, run_virtual
from target_nav.mission import load_mission
from target_nav.sim.arena import load_arena
from target_nav.state.types import Facing

MISSION = mission_path("bowling_pin")


@pytest.fixture(scope="module")
def recorded(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, RunResult]:
    path = tmp_path_factory.mktemp("run") / "run.mcap"
    arena = load_arena("open_floor")
    with RunRecorder(path, header_of(arena.config, load_mission(MISSION))) as recorder:
        result = run_virtual(arena, MISSION, 3, recorder)
    return path, result


def test_the_reference_mission_arrives_on_the_open_floor(recorded: tuple[Path, RunResult]) -> None:
    _, result = recorded
    assert result.as_expected, result
    assert result.states[-2:] == ("BLIND_APPROACH", "ARRIVED")
    assert result.stop_error_m == pytest.approx(0.0, abs=0.05)


def test_the_same_seed_gives_the_same_bytes(recorded: tuple[Path, RunResult]) -> None:
    _, first = recorded
    second = run_virtual(load_arena("open_floor"), MISSION, 3)
    assert json.dumps(first.as_json(with_trace=True)) == json.dumps(second.as_json(with_trace=True))


def test_another_seed_gives_another_path(recorded: tuple[Path, RunResult]) -> None:
    _, first = recorded
    assert run_virtual(load_arena("open_floor"), MISSION, 4).trace != first.trace


def test_without_a_pin_the_mission_ends_by_itself_and_says_not_found() -> None:
    result = run_virtual(load_arena("no_pin"), MISSION, 1)
    assert (result.outcome, result.as_expected, result.timeout) == ("failed", True, False)
    assert "not found" in result.reason


def test_a_replay_decides_the_same_to_the_last_bit(recorded: tuple[Path, RunResult]) -> None:
    path, _ = recorded
    report = replay(path)
    assert report.ticks > 200
    assert report.differences == ()


def test_a_replay_has_both_poses_of_a_tag_too(tmp_path: Path) -> None:
    arena, mission = replace(load_arena("tag_on_wall"), time_limit_s=6.0), mission_path("apriltag")
    path = tmp_path / "tag.mcap"
    with RunRecorder(path, header_of(arena.config, load_mission(mission))) as recorder:
        run_virtual(arena, mission, 3, recorder)
    _, ticks = read_run(path)
    frames = [inputs.detections for inputs, _ in ticks if inputs.detections is not None]
    facings = [(d.facing, d.other_facing) for frame in frames for d in frame.detections]
    assert facings
    assert all(isinstance(first, Facing) and isinstance(other, Facing) for first, other in facings)
    report = replay(path)
    assert report.differences == ()
    assert report.ticks > 100


def test_a_replay_of_another_mission_shows_where_they_part(
    recorded: tuple[Path, RunResult], tmp_path: Path
) -> None:
    path, _ = recorded
    trees = Path(shutil.copytree(MISSION.parent, tmp_path / "trees"))
    approach = trees / "subtrees" / "approach.xml"
    text = approach.read_text(encoding="utf-8")
    approach.write_text(
        text.replace("<NavigateToTarget ", '<NavigateToTarget speed_mps="0.08" '), encoding="utf-8"
    )
    report = replay(path, trees / MISSION.name, most=1)
    assert len(report.differences) == 1
    assert report.differences[0].what in {"sent", "requested"}


def test_a_recording_that_was_cut_off_replays_up_to_the_cut(
    recorded: tuple[Path, RunResult], tmp_path: Path
) -> None:
    path, _ = recorded
    whole = path.read_bytes()
    cut = tmp_path / "cut.mcap"
    cut.write_bytes(whole[: len(whole) * 2 // 3])
    report = replay(cut)
    assert 0 < report.ticks < replay(path).ticks
    assert report.differences == ()


@pytest.mark.parametrize("content", [b"", b"not an mcap file", b"\x89MCAP0\r\n"])
def test_what_is_no_recording_is_refused_with_its_name(tmp_path: Path, content: bytes) -> None:
    path = tmp_path / "odd.mcap"
    path.write_bytes(content)
    with pytest.raises(RecordingError, match=r"odd\.mcap: not a recording"):
        read_run(path)


def test_the_picture_of_a_run_is_drawn(recorded: tuple[Path, RunResult], tmp_path: Path) -> None:
    _, result = recorded
    path = tmp_path / "run.png"
    draw_run(path, load_arena("open_floor"), result.trace, result.state_changes, "a title " * 20)
    assert path.read_bytes().startswith(b"\x89PNG")
    assert path.stat().st_size > 10_000


@pytest.mark.slow
def test_a_campaign_gives_the_same_lines_however_many_processes_run_it(tmp_path: Path) -> None:
    todo = orders(["open_floor", "generated_4_6"], 2, 10, MISSION, with_trace=True)
    for jobs in (1, 2):
        with (tmp_path / f"{jobs}.jsonl").open("w") as out:
            lines = LinesInOrder(todo, out, traces=True)
            for timed in run_all(execute, todo, jobs):
                lines.add(timed)
    assert (tmp_path / "1.jsonl").read_bytes() == (tmp_path / "2.jsonl").read_bytes()
    line = json.loads((tmp_path / "1.jsonl").read_text().splitlines()[0])
    fields = "arena seed mission success collided timeout time_s path_m stop_error_m bearing_error_rad"
    assert set(f"{fields} min_clearance_m states trace".split()) <= set(line)
    assert line == json.loads(json.dumps(execute(todo[0]).result.as_json(with_trace=True)))
