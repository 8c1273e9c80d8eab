"""`python -m benchmarks`: which benchmarks there are, what a ratio says, what is written."""

from __future__ import annotations

import json
import sys
from pathlib import Path
from types import ModuleType

import pytest
from click.testing import CliRunner

import benchmarks.__main__ as registry
from benchmarks import OURS, Row, time_call

ROWS = [
    Row("copy", OURS, 10.0, "us"),
    Row("copy", "pipe", 25.0, "us"),
    Row("rate", OURS, 200.0, "Hz", lower_is_better=False),
    Row("rate", "queue", 50.0, "Hz", lower_is_better=False),
    Row("alone", OURS, 1.0, "us"),
]


@pytest.fixture
def toy(monkeypatch: pytest.MonkeyPatch) -> ModuleType:
    module = ModuleType("benchmarks.bench_toy")
    module.run = lambda: ROWS
    monkeypatch.setitem(sys.modules, "benchmarks.bench_toy", module)
    monkeypatch.setattr(registry, "available", lambda: ["toy"])
    return module


def test_every_bench_module_is_found() -> None:
    here = {path.stem.removeprefix("bench_") for path in Path(registry.__file__).parent.glob("bench_*.py")}
    assert set(registry.available()) == here
    assert "ipc" in here


def test_a_ratio_says_how_many_times_worse_the_peer_is() -> None:
    assert [registry.ratio(row, ROWS) for row in ROWS] == [None, 2.5, None, 4.0, None]


def test_a_peer_of_nothing_or_of_zero_has_no_ratio() -> None:
    assert registry.ratio(ROWS[1], ROWS[1:2]) is None
    assert registry.ratio(ROWS[1], [Row("copy", OURS, 0.0, "us"), ROWS[1]]) is None


def test_the_table_and_the_json_have_every_row(toy: ModuleType, tmp_path: Path) -> None:
    out = tmp_path / "out.json"
    result = CliRunner().invoke(registry.main, ["toy", "--json", str(out)])
    assert result.exit_code == 0, result.output
    assert "pipe" in result.output
    assert "x2.50" in result.output
    written = json.loads(out.read_text())
    assert [(row["name"], row["ratio"]) for row in written["rows"]] == [
        *((OURS, None), ("pipe", 2.5), (OURS, None), ("queue", 4.0), (OURS, None))
    ]
    assert "cores" in written["machine"]


def test_an_unknown_name_is_refused_with_those_there_are(toy: ModuleType) -> None:
    result = CliRunner().invoke(registry.main, ["toys"])
    assert result.exit_code == 2
    assert "toys; there are: toy" in result.output


def test_a_module_that_gives_no_rows_is_named(toy: ModuleType) -> None:
    toy.run = dict
    result = CliRunner().invoke(registry.main, [])
    assert result.exit_code == 1
    assert "bench_toy.run() gives dict; it must give list[Row]" in result.output


def test_a_call_is_timed_in_seconds() -> None:
    import time

    assert 1e-3 <= time_call(lambda: time.sleep(1e-3), budget_s=0.02, batches=3) < 1.0
