"""`python -m benchmarks [NAME...] [--json OUT]`: runs `bench_*.py`, prints a table, ratios to the peers of the run."""

from __future__ import annotations

import importlib
import json
import os
import pkgutil
import platform
from collections.abc import Sequence
from dataclasses import asdict
from pathlib import Path

import click
from rich.console import Console
from rich.table import Table

import benchmarks
from benchmarks import OURS, Row


def available() -> list[str]:
    names = [module.name for module in pkgutil.iter_modules(benchmarks.__path__)]
    return sorted(name.removeprefix("bench_") for name in names if name.startswith("bench_"))


def ratio(row: Row, rows: Sequence[Row]) -> float | None:
    """How many times worse than ours a peer is; under 1 it is better. None for our own row, or without one."""
    ours = [each for each in rows if each.task == row.task and each.name == OURS]
    if row.name == OURS or not ours:
        return None
    worse, better = (row.value, ours[0].value) if row.lower_is_better else (ours[0].value, row.value)
    return worse / better if better else None


def table(name: str, rows: Sequence[Row]) -> Table:
    shown = Table(title=f"{name} ({machine()})", title_justify="left")
    for header in ("task", "who", "value", "unit", "ratio", "note"):
        shown.add_column(header, justify="right" if header in ("value", "ratio") else "left")
    task = ""
    for row in rows:
        times = ratio(row, rows)
        if row.task != task and task:
            shown.add_section()
        style = "bold" if row.name == OURS else ""
        shown.add_row(
            *(row.task if row.task != task else "", row.name, f"{row.value:,.4g}", row.unit),
            *("" if times is None else f"x{times:.2f}", row.note),
            style=style,
        )
        task = row.task
    return shown


def machine() -> str:
    return f"{platform.machine()}, {os.cpu_count()} cores, Python {platform.python_version()}"


@click.command()
@click.argument("names", nargs=-1, metavar="[NAME...]")
@click.option(
    "--json", "out", type=click.Path(dir_okay=False, path_type=Path), help="write the rows there too"
)
def main(names: tuple[str, ...], out: Path | None) -> None:
    """Run the benchmarks of these names, or all."""
    known = available()
    unknown = [name for name in names if name not in known]
    if unknown:
        raise click.BadParameter(f"{', '.join(unknown)}; there are: {', '.join(known)}", param_hint="NAME")
    console = Console()
    results = []
    odd = []
    for name in names or known:
        rows = importlib.import_module(f"benchmarks.bench_{name}").run()
        if not isinstance(rows, list) or not all(isinstance(row, Row) for row in rows):
            odd.append(f"bench_{name}.run() gives {type(rows).__name__}; it must give list[Row]")
            continue
        console.print(table(name, rows))
        results += [{"benchmark": name, **asdict(row), "ratio": ratio(row, rows)} for row in rows]
    if out is not None:
        out.write_text(json.dumps({"machine": machine(), "rows": results}, indent=1) + "\n", encoding="utf-8")
    if odd:
        raise click.ClickException("; ".join(odd))


if __name__ == "__main__":
    main()
