"""Two campaigns side by side: what changed, and whether it is more than chance."""

from __future__ import annotations

import json
from collections.abc import Callable, Sequence
from pathlib import Path

import numpy as np
from rich.table import Table

from target_nav.app.campaign_table import Row, is_false_arrival
from target_nav.app.compare_statistics import (
    Interval,
    mcnemar_p,
    median_difference,
    paired_rate_difference,
    rate_difference,
    wilson,
)
from target_nav.errors import ConfigError

RATES: tuple[tuple[str, Callable[[Row], bool]], ...] = (
    ("as expected", lambda row: bool(row["as_expected"])),
    ("collided", lambda row: bool(row["collided"])),
    ("time-out", lambda row: bool(row["timeout"])),
    ("false arrival", is_false_arrival),
)
MEDIANS = (
    ("stop error [mm]", "stop_error_m", 1e3),
    ("bearing error [deg]", "bearing_error_rad", 180.0 / np.pi),
    ("time [s]", "time_s", 1.0),
    ("path [m]", "path_m", 1.0),
    ("clearance [mm]", "min_clearance_m", 1e3),
)
NEEDED = {"arena", "seed", "as_expected", "collided", "timeout", "success", "outcome"} | {
    name for _, name, _ in MEDIANS
}


def read_rows(path: Path) -> list[Row]:
    """A campaign's JSON lines.

    Raises:
        ConfigError: it cannot be read, or is something else.
    """
    rows: list[Row] = []
    try:
        for number, line in enumerate(path.read_text(encoding="utf-8").splitlines(), start=1):
            if not line.strip():
                continue
            row = json.loads(line)
            missing = sorted(NEEDED - set(row)) if isinstance(row, dict) else ["an object"]
            if missing:
                raise ConfigError(f"{path}:{number}: not a campaign's line; missing: {', '.join(missing)}")
            rows.append(row)
    except (OSError, UnicodeDecodeError, json.JSONDecodeError) as error:
        raise ConfigError(f"{path}: cannot be read as a campaign's JSON lines: {error}") from error
    if not rows:
        raise ConfigError(f"{path}: no run in it")
    return rows


def pairs_of(a: Sequence[Row], b: Sequence[Row]) -> list[tuple[Row, Row]]:
    """Runs of the same arena with the same seed, in A's order; missions may differ."""
    there = {_key(row): row for row in b}
    return [(row, there[_key(row)]) for row in a if _key(row) in there]


def _key(row: Row) -> tuple[str, int]:
    return str(row["arena"]), int(row["seed"])


def compare_table(a: Sequence[Row], b: Sequence[Row], names: tuple[str, str]) -> Table:
    """Paired where every run of one has its like in the other, else as two independent samples."""
    pairs = pairs_of(a, b)
    paired = len(pairs) == len(a) == len(b)
    how = (
        "pairs by arena and seed; rates: Wilson, difference Newcombe (paired), McNemar's exact p; medians: bootstrap"
        if paired
        else "runs are not the same; rates: Wilson, difference Newcombe; medians: bootstrap"
    )
    table = Table(
        title=f"{names[0]} ({len(a)} runs) and {names[1]} ({len(b)} runs)", caption=f"95 % intervals. {how}"
    )
    table.add_column("")
    for heading in (*names, "difference", ""):
        table.add_column(heading, justify="right")
    for name, holds in RATES:
        table.add_row(name, *_rate_cells(a, b, pairs if paired else None, holds))
    table.add_section()
    for name, field, scale in MEDIANS:
        table.add_row(f"median {name}", *_median_cells(a, b, pairs if paired else None, field, scale))
    return table


def _rate_cells(
    a: Sequence[Row],
    b: Sequence[Row],
    pairs: Sequence[tuple[Row, Row]] | None,
    holds: Callable[[Row], bool],
) -> list[str]:
    good_a, good_b = sum(map(holds, a)), sum(map(holds, b))
    cells = [_percent(wilson(good_a, len(a))), _percent(wilson(good_b, len(b)))]
    if pairs is None:
        change = rate_difference(good_a, len(a), good_b, len(b))
        return [*cells, _percent(change, signed=True), _verdict(change)]
    counts = {(x, y): 0 for x in (True, False) for y in (True, False)}
    for one, other in pairs:
        counts[holds(one), holds(other)] += 1
    only_a, only_b = counts[True, False], counts[False, True]
    change = paired_rate_difference(counts[True, True], only_a, only_b, counts[False, False])
    words = f"{only_a} only in A, {only_b} only in B, p {mcnemar_p(only_a, only_b):.3f}"
    return [*cells, _percent(change, signed=True), words]


def _median_cells(
    a: Sequence[Row], b: Sequence[Row], pairs: Sequence[tuple[Row, Row]] | None, field: str, scale: float
) -> list[str]:
    """Of runs that went as expected; in pairs, of those where both did."""
    if pairs is not None:
        both = [(x, y) for x, y in pairs if _counts(x, field) and _counts(y, field)]
        one = np.array([abs(x[field]) for x, _ in both]) * scale
        other = np.array([abs(y[field]) for _, y in both]) * scale
    else:
        one = np.array([abs(x[field]) for x in a if _counts(x, field)]) * scale
        other = np.array([abs(y[field]) for y in b if _counts(y, field)]) * scale
    if not len(one) or not len(other):
        return ["-", "-", "-", ""]
    change = median_difference(one, other, paired=pairs is not None)
    shown = f"{change.value:+.2f} ({change.low:+.2f} ... {change.high:+.2f})"
    return [f"{np.median(one):.2f}", f"{np.median(other):.2f}", shown, _verdict(change)]


def _counts(row: Row, field: str) -> bool:
    return bool(row["as_expected"]) and row[field] is not None


def _percent(interval: Interval, signed: bool = False) -> str:
    sign = "+" if signed else ""
    value, low, high = (f"{100.0 * x:{sign}.1f}" for x in (interval.value, interval.low, interval.high))
    return f"{value} % ({low} ... {high})"


def _verdict(change: Interval) -> str:
    return "differs" if change.excludes_zero else "may be chance"
