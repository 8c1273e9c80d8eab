"""Small parts of the app: run folders, tick statistics, the outcome's line, the campaign's table."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest
from rich.console import Console

from target_nav.app import paths
from target_nav.app.campaign import generated_orders, orders
from target_nav.app.campaign_table import campaign_table
from target_nav.app.paths import mission_path
from target_nav.app.run_folder import make_run_folder
from target_nav.app.run_report import outcome_line
from target_nav.app.tick_statistics import TickMeter
from target_nav.app.virtual import RunResult


def result(**changes: Any) -> RunResult:
    fields: dict[str, Any] = {
        "arena": "a", "seed": 1, "mission": "m", "success": True, "collided": False, "timeout": False, "time_s": 31.44,
        "path_m": 3.0, "stop_error_m": 0.0042, "bearing_error_rad": 0.014, "min_clearance_m": 0.0961,
        "states": ("IDLE",), "outcome": "succeeded", "reason": "", "as_expected": True,
    }  # fmt: skip
    return RunResult(**{**fields, **changes})


@pytest.mark.parametrize(
    ("changes", "line"),
    [
        ({}, "ARRIVED after 31.4 s: stop error +4 mm, bearing +0.8 deg, least clearance 96 mm"),
        (
            {"collided": True},
            "ARRIVED after 31.4 s: stop error +4 mm, bearing +0.8 deg, least clearance 96 mm - COLLIDED",
        ),
        ({"outcome": "failed", "reason": "not found"}, "FAILED after 31.4 s: not found"),
        ({"outcome": "timeout", "success": False}, "TIMED OUT after 31.4 s: no reason given"),
        (
            {"success": False, "stop_error_m": 1.0},
            "ARRIVED after 31.4 s: stop error +1000 mm, bearing +0.8 deg, least clearance 96 mm"
            " - but not where the target is",
        ),
    ],
)
def test_the_outcome_is_one_line_for_a_person(changes: dict[str, Any], line: str) -> None:
    assert outcome_line(result(**changes).as_json()) == line


def test_two_runs_in_one_second_get_two_folders_and_latest_is_the_last(tmp_path: Path) -> None:
    first, second = make_run_folder(tmp_path), make_run_folder(tmp_path)
    assert first.path != second.path
    assert (tmp_path / "latest").resolve() == second.path.resolve()


def test_tick_statistics_are_of_the_last_ten_ticks() -> None:
    meter = TickMeter()
    for n in range(30):
        meter.note(n * 0.05, n * 0.05 + (0.040 if n < 20 else 0.002))
    told = meter.statistics()
    assert told.count == 30
    assert told.duration_average_s == pytest.approx(0.002)
    assert told.interval_average_s == pytest.approx(0.05)
    assert told.interval_variance_s2 == pytest.approx(0.0, abs=1e-12)


def test_a_campaign_runs_every_arena_with_every_seed() -> None:
    todo = orders(["a", "b"], 3, 7, Path("m.xml"))
    assert {(o.arena, o.seed) for o in todo} == {(a, s) for a in "ab" for s in (7, 8, 9)}


def test_no_two_runs_of_a_generated_campaign_share_their_noise() -> None:
    todo = generated_orders(10, 5, 3, Path("m.xml"))
    assert len({order.seed for order in todo}) == 30
    assert {order.arena for order in todo} == {f"generated_5_{number}" for number in range(10)}


def test_the_campaigns_table_counts_what_was_expected_and_measures_what_arrived() -> None:
    runs = [
        result(),
        result(seed=2, success=False, as_expected=False, outcome="failed", stop_error_m=2.0),
        result(arena="b", collided=True, as_expected=False, stop_error_m=-0.02),
    ]
    console = Console(width=200, record=True, file=open("/dev/null", "w"))  # noqa: SIM115
    console.print(campaign_table([run.as_json() for run in runs]))
    text = console.export_text()
    assert "1 (50.0 %)" in text
    assert "0 (0.0 %)" in text
    assert "1 (33.3 %)" in text
    assert "12 / 19" in text


def test_a_mission_is_found_by_path_or_by_name_in_either_notation(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(paths, "files", lambda package: tmp_path)
    for name in ("both.xml", "both.yaml", "other.yaml"):
        (tmp_path / name).touch()
    assert mission_path("both") == tmp_path / "both.xml"
    assert mission_path("other") == tmp_path / "other.yaml"
    assert mission_path("some/where.yml") == Path("some/where.yml")
    assert mission_path("gone") == tmp_path / "gone.xml", "the loader says that there is none"
