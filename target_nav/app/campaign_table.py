"""A campaign's figures, from its JSON lines: success, collisions, stop errors and the like, by kind and by level."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from rich.table import Table

from target_nav.state.types import FloatArray

Row = dict[str, Any]
"""One line of a campaign's JSON: the fields of `RunResult`."""


@dataclass(frozen=True)
class Figures:
    """Counts are of runs. Stop error, bearing and time are of those that arrived as they should; not a number: none."""

    runs: int
    good: int
    collided: int
    timeouts: int
    false_arrivals: int
    stop_p50_m: float
    stop_p95_m: float
    bearing_p95_rad: float
    time_p50_s: float
    time_p95_s: float
    clearance_p5_m: float

    @classmethod
    def of(cls, rows: Sequence[Row]) -> Figures:
        arrived = [row for row in rows if row["success"] and row["outcome"] == "succeeded"]
        stops = _absolute(row["stop_error_m"] for row in arrived)
        bearings = _absolute(row["bearing_error_rad"] for row in arrived)
        times = _absolute(row["time_s"] for row in rows if row["as_expected"])
        clearances = _absolute(row["min_clearance_m"] for row in rows)
        return cls(
            runs=len(rows),
            good=sum(row["as_expected"] for row in rows),
            collided=sum(row["collided"] for row in rows),
            timeouts=sum(row["timeout"] for row in rows),
            false_arrivals=sum(is_false_arrival(row) for row in rows),
            stop_p50_m=_percentile(stops, 50.0),
            stop_p95_m=_percentile(stops, 95.0),
            bearing_p95_rad=_percentile(bearings, 95.0),
            time_p50_s=_percentile(times, 50.0),
            time_p95_s=_percentile(times, 95.0),
            clearance_p5_m=_percentile(clearances, 5.0),
        )

    def cells(self) -> list[str]:
        return [
            str(self.runs),
            f"{self.good} ({100.0 * self.good / max(self.runs, 1):.1f} %)",
            str(self.collided),
            str(self.timeouts),
            str(self.false_arrivals),
            f"{_number(1e3 * self.stop_p50_m)} / {_number(1e3 * self.stop_p95_m)}",
            _number(float(np.degrees(self.bearing_p95_rad)), 1),
            f"{_number(self.time_p50_s)} / {_number(self.time_p95_s)}",
            _number(1e3 * self.clearance_p5_m),
        ]


HEADINGS = (
    "runs",
    "as expected",
    "collided",
    "time-outs",
    "false arrivals",
    "stop p50 / p95 [mm]",
    "bearing p95 [deg]",
    "time p50 / p95 [s]",
    "clearance p5 [mm]",
)


def is_false_arrival(row: Row) -> bool:
    """Arrival was reported, and it is not so."""
    return row["outcome"] == "succeeded" and not row["success"]


def group_name(row: Row) -> str:
    return str(row.get("kind") or row["arena"])


def campaign_table(rows: Sequence[Row], title: str = "campaign") -> Table:
    """One row a kind (or arena), one a level where there are levels, one for all of it."""
    table = Table(title=title, caption="as expected: the right ending, and nothing touched")
    table.add_column("")
    for heading in HEADINGS:
        table.add_column(heading, justify="right")
    kinds = sorted({group_name(row) for row in rows})
    for name in kinds:
        table.add_row(name, *Figures.of([row for row in rows if group_name(row) == name]).cells())
    levels = sorted({int(row.get("level") or 0) for row in rows} - {0})
    if levels:
        table.add_section()
        for level in levels:
            of_level = [row for row in rows if row.get("level") == level]
            table.add_row(f"level {level}", *Figures.of(of_level).cells())
    table.add_section()
    table.add_row("all", *Figures.of(rows).cells(), style="bold")
    return table


def _absolute(values: Iterable[float | None]) -> FloatArray:
    return np.abs(np.array([value for value in values if value is not None], dtype=np.float64))


def _percentile(values: FloatArray, share: float) -> float:
    return float(np.percentile(values, share)) if len(values) else float("nan")


def _number(value: float, digits: int = 0) -> str:
    return "-" if np.isnan(value) else f"{value:.{digits}f}"
