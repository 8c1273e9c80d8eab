"""`target-nav campaign` and `barn` at the command line: what they refuse, write, tell of a failure and leave behind."""

from __future__ import annotations

import gzip
import json
from pathlib import Path

import pytest
from click.testing import CliRunner, Result

from target_nav.app.cli import cli
from target_nav.app.run_picture import draw_run
from target_nav.config import Config
from target_nav.sim.arena import load_arena
from target_nav.sim.generator import GeneratedName, generate_arena

SHORT = """
bounds: [-2.0, -2.0, 2.0, 2.0]
robot: {x: -1.0, y: 0.0, yaw: 0.0}
target: {class: bowling_pin, x: 1.0, y: 0.0}
time_limit_s: 1
"""


def called(*arguments: object) -> Result:
    return CliRunner().invoke(cli, [str(argument) for argument in arguments])


def test_generated_arenas_can_be_written_as_files(tmp_path: Path) -> None:
    done = called("campaign", "--generate", 3, "--seed", 8, "--write", tmp_path / "arenas")
    assert done.exit_code == 0, done.output
    files = sorted((tmp_path / "arenas").iterdir())
    assert [file.name for file in files] == [f"generated_8_{n}.yaml" for n in range(3)]
    assert load_arena(files[1]) == generate_arena(GeneratedName(8, 1), Config())


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["--generate", "2", "--arenas", "open_floor"], "exclude each other"),
        (["--write", "somewhere"], "--write needs --generate N"),
        (["--generate", "0"], "not in the range"),
        (["--generate", "2", "--seed", "-1"], "not in the range"),
    ],
)
def test_what_makes_no_sense_is_refused(arguments: list[str], words: str) -> None:
    done = called("campaign", *arguments)
    assert done.exit_code == 2
    assert words in done.output


def test_a_failure_leaves_its_seed_its_picture_and_the_command_that_replays_it(tmp_path: Path) -> None:
    arena = tmp_path / "short.yaml"
    arena.write_text(SHORT)
    out, pictures = tmp_path / "out.json", tmp_path / "pictures"
    done = called(
        "campaign", "--arenas", arena, "--seed", 4, "--jobs", 1, "--json", out, "--pictures", pictures
    )
    assert done.exit_code == 1
    assert "short, seed 4: timeout" in done.output
    assert f"target-nav run --sim {arena} --virtual --seed 4 --mission bowling_pin" in done.output
    assert (pictures / "short-4.png").read_bytes().startswith(b"\x89PNG")
    assert "times real time on one core" in done.output
    (line,) = out.read_text().splitlines()
    row = json.loads(line)
    assert (row["arena"], row["seed"], row["timeout"], row["success"]) == ("short", 4, True, False)
    assert "trace" not in row


def test_the_picture_of_a_generated_arena_needs_no_run(tmp_path: Path) -> None:
    arena = load_arena("generated_8_9")
    draw_run(tmp_path / "a.png", arena, (), (), "nothing was driven")
    assert (tmp_path / "a.png").stat().st_size > 5_000


@pytest.mark.slow
def test_barn_prints_the_sets_score_and_writes_a_line_a_run(tmp_path: Path) -> None:
    cylinders = "".join(f"5,{x},{y}\n" for x, y in [(-2.25, 6.0), (-3.0, 8.0), (-1.4, 8.1)])
    (tmp_path / "barn_cylinders.csv.gz").write_bytes(gzip.compress(cylinders.encode()))
    (tmp_path / "barn_summary.csv").write_text("world,ref_path_len_m\n5,10.3\n")
    out = tmp_path / "barn.json"
    done = called("barn", tmp_path, "--jobs", 1, "--json", out)
    assert done.exit_code == 0, done.output
    assert "0.5000" in done.output
    row = json.loads(out.read_text())
    assert (row["world"], row["success"], row["score"]) == (5, True, 0.5)
    assert row["reached_s"] < 2.0 * row["best_s"]
