"""Two campaigns compared: intervals as published, pairs by arena and seed, and chance called chance."""

from __future__ import annotations

import io
import json
import math
from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner
from rich.console import Console

from target_nav.app.campaign_table import Row
from target_nav.app.cli import cli
from target_nav.app.compare import compare_table, pairs_of, read_rows
from target_nav.app.compare_statistics import (
    mcnemar_p,
    median_difference,
    paired_rate_difference,
    rate_difference,
    wilson,
)
from target_nav.errors import ConfigError


def row(seed: int, good: bool = True, time_s: float = 20.0, **values: object) -> Row:
    base: Row = {
        "arena": "a", "seed": seed, "mission": "m", "success": good, "as_expected": good, "collided": False,
        "timeout": False, "outcome": "succeeded" if good else "failed", "time_s": time_s, "path_m": 3.0,
        "stop_error_m": 0.004, "bearing_error_rad": 0.02, "min_clearance_m": 0.1,
    }  # fmt: skip
    return base | values


@pytest.mark.parametrize(
    ("good", "runs", "low", "high"),
    # Newcombe 1998, p. 861, table I, method 3
    [(81, 263, 0.2553, 0.3662), (15, 148, 0.0624, 0.1605), (0, 20, 0.0, 0.1611), (1, 29, 0.0061, 0.1718)],
)
def test_wilsons_interval_is_the_published_one(good: int, runs: int, low: float, high: float) -> None:
    found = wilson(good, runs)
    assert (found.low, found.high) == pytest.approx((low, high), abs=5e-5)


def test_newcombes_difference_is_the_published_one() -> None:
    # Newcombe 1998, p. 876, example (a): 56 of 70 against 48 of 80, method 10
    found = rate_difference(48, 80, 56, 70)
    assert (found.value, found.low, found.high) == pytest.approx((0.2, 0.0524, 0.3339), abs=5e-5)


def test_pairs_make_a_difference_surer() -> None:
    paired = paired_rate_difference(both=80, only_a=1, only_b=9, neither=10)
    unpaired = rate_difference(81, 100, 89, 100)
    assert paired.value == pytest.approx(unpaired.value)
    assert paired.high - paired.low < unpaired.high - unpaired.low
    assert paired.excludes_zero
    assert not unpaired.excludes_zero


def test_mcnemars_test_is_the_binomials_tail() -> None:
    assert mcnemar_p(0, 0) == 1.0
    assert mcnemar_p(5, 5) == 1.0
    assert mcnemar_p(0, 6) == pytest.approx(2 / 64)
    assert mcnemar_p(1, 9) == mcnemar_p(9, 1) == pytest.approx(2 * 11 / 1024)


def test_the_bootstraps_interval_holds_the_true_difference_about_95_times_in_100() -> None:
    rng = np.random.default_rng(7)
    inside = 0
    for _ in range(40):
        found = median_difference(rng.normal(0.0, 1.0, 60), rng.normal(0.5, 1.0, 60), paired=False)
        inside += found.low <= 0.5 <= found.high
    assert inside >= 33


def test_runs_are_paired_by_arena_and_seed() -> None:
    a, b = [row(1), row(2), row(3, arena="b")], [row(2, time_s=9.0), row(3), row(1)]
    assert [(x["seed"], y["time_s"]) for x, y in pairs_of(a, b)] == [(1, 20.0), (2, 9.0)]


def told(a: list[Row], b: list[Row]) -> str:
    console = Console(width=220, file=io.StringIO(), record=True)
    console.print(compare_table(a, b, ("old", "new")))
    return console.export_text()


def test_the_table_says_which_change_is_more_than_chance() -> None:
    old = [row(seed, good=seed % 3 != 0, time_s=20.0 + seed % 5) for seed in range(60)]
    new = [row(seed, time_s=15.0 + seed % 5) for seed in range(60)]
    text = told(old, new)
    assert "pairs by arena and seed" in text
    assert "0 only in A, 20 only in B, p 0.000" in text
    assert "-5.00" in text
    assert "differs" in text


def test_other_seeds_are_two_samples() -> None:
    text = told([row(seed) for seed in range(20)], [row(seed + 100) for seed in range(30)])
    assert "runs are not the same" in text
    assert "may be chance" in text


def test_the_command_reads_two_files(tmp_path: Path) -> None:
    for name, good in (("a", True), ("b", False)):
        (tmp_path / f"{name}.json").write_text("\n".join(json.dumps(row(s, good)) for s in range(4)))
    done = CliRunner().invoke(cli, ["compare", str(tmp_path / "a.json"), str(tmp_path / "b.json")])
    assert done.exit_code == 0
    assert "as expected only in A: a seed 0, a seed 1" in done.output


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("", "no run in it"),
        ("{}\n", ":1: not a campaign's line; missing: arena"),
        ("nonsense", "cannot be read"),
    ],
)
def test_what_is_no_campaign_is_refused(tmp_path: Path, text: str, words: str) -> None:
    path = tmp_path / "x.json"
    path.write_text(text)
    with pytest.raises(ConfigError, match=words):
        read_rows(path)


def test_without_runs_there_is_no_rate() -> None:
    assert math.isnan(wilson(0, 0).value)
