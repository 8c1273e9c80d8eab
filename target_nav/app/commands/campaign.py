"""`target-nav campaign`: many arenas, many seeds, one table."""

from __future__ import annotations

import os
from pathlib import Path
from typing import TextIO

import click
from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeRemainingColumn

from target_nav.app.campaign import orders, run_all, table_of, write_json_lines
from target_nav.app.paths import REFERENCE_MISSION, mission_path
from target_nav.app.terminal import table_console
from target_nav.mission import load_mission
from target_nav.sim.arena import list_arenas, load_arena


@click.command(name="campaign")
@click.option(
    "--arenas",
    "first_arena",
    metavar="PATH...",
    help="Arena files, folders or names; default: all that are shipped.",
)
@click.argument("more_arenas", nargs=-1, metavar="")
@click.option("--seeds", default=1, show_default=True, type=click.IntRange(1), help="Runs per arena.")
@click.option("--seed", default=1, show_default=True, help="First seed.")
@click.option(
    "--mission", default=REFERENCE_MISSION, show_default=True, help="Mission file, or a name in trees/."
)
@click.option(
    "--jobs", default=os.cpu_count() or 1, show_default=True, type=click.IntRange(1), help="Processes."
)
@click.option("--json", "out", type=click.File("w"), help="One JSON line a run.")
@click.option(
    "--pixels",
    is_flag=True,
    help="Render every camera frame and let the trained network look for the target.",
)
@click.option("--traces", is_flag=True, help="With the true poses at 20 Hz in each line.")
@click.pass_context
def command(
    ctx: click.Context,
    first_arena: str | None,
    more_arenas: tuple[str, ...],
    seeds: int,
    seed: int,
    mission: str,
    jobs: int,
    out: TextIO | None,
    pixels: bool,
    traces: bool,
) -> None:
    """Run a mission in virtual time in many arenas. Exit 0 when every run ended as its arena expects."""
    console = table_console(stderr=True)
    named = _expand([first_arena, *more_arenas] if first_arena else list(more_arenas))
    path = mission_path(mission)
    # what cannot be loaded is told before the first run
    load_mission(path)
    for arena in named:
        load_arena(arena)
    todo = orders(named, seeds, seed, path, pixels)
    results = []
    columns = (TextColumn("{task.description}"), BarColumn(), MofNCompleteColumn(), TimeRemainingColumn())
    with Progress(*columns, console=console, disable=not console.is_terminal) as progress:
        task = progress.add_task("runs", total=len(todo))
        for result in run_all(todo, jobs):
            results.append(result)
            progress.advance(task)
    if out is not None:
        write_json_lines(results, out, traces)
    table_console().print(table_of(results))
    failed = sorted((r for r in results if not r.as_expected), key=lambda r: (r.arena, r.seed))
    for r in failed[:20]:
        click.echo(
            f"{r.arena} seed {r.seed}: {r.outcome}, {r.reason or 'no reason'}{', COLLIDED' if r.collided else ''}"
        )
        flag = " --pixels" if pixels else ""
        click.echo(
            f"  target-nav run --sim {_argument(named, r.arena)} --virtual{flag} --seed {r.seed} --mission {mission}"
        )
    ctx.exit(1 if failed else 0)


def _expand(given: list[str]) -> list[str]:
    if not given:
        return list_arenas()
    found: list[str] = []
    for item in given:
        path = Path(item)
        found.extend(str(p) for p in sorted(path.glob("*.yaml"))) if path.is_dir() else found.append(item)
    return found


def _argument(named: list[str], arena: str) -> str:
    """What was given on the command line for the arena of that name."""
    return next((n for n in named if n == arena or Path(n).stem == arena), arena)
