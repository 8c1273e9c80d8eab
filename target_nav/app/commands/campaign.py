"""`target-nav campaign`: many arenas, many seeds, one table."""

from __future__ import annotations

import os
from collections.abc import Sequence
from pathlib import Path
from typing import TextIO

import click
from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeRemainingColumn

from target_nav.app.campaign import (
    LinesInOrder,
    RunOrder,
    TimedResult,
    execute,
    generated_orders,
    in_order,
    orders,
    replay_command,
)
from target_nav.app.campaign_table import campaign_table
from target_nav.app.paths import REFERENCE_MISSION, mission_path
from target_nav.app.spread import run_all
from target_nav.app.terminal import table_console
from target_nav.app.virtual import RunResult
from target_nav.config import Config
from target_nav.mission import load_mission
from target_nav.sim.arena import GROUPS, list_arenas, load_arena
from target_nav.sim.arena_writer import write_arena
from target_nav.sim.generator import GeneratedName

TOLD = 20
"""Failures told in full; the JSON has all of them."""


@click.command(name="campaign")
@click.option("--generate", type=click.IntRange(1), metavar="N", help="N generated arenas of --seed.")
@click.option(
    "--arenas",
    "first_arena",
    metavar="PATH...",
    help="Arena files, folders or names, `complaints`, `goals` or `tags`; default: all that are shipped.",
)
@click.argument("more_arenas", nargs=-1, metavar="")
@click.option("--seeds", default=1, show_default=True, type=click.IntRange(1), help="Runs per arena.")
@click.option(
    "--seed",
    default=1,
    show_default=True,
    type=click.IntRange(0),
    help="The generator's, and the first run's.",
)
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
@click.option(
    "--pictures",
    default="runs/campaign",
    show_default=True,
    type=click.Path(file_okay=False, path_type=Path),
    help="Folder for the pictures of runs that failed.",
)
@click.option(
    "--write",
    "write_to",
    type=click.Path(file_okay=False, path_type=Path),
    metavar="FOLDER",
    help="Write the generated arenas as files, and run nothing.",
)
@click.pass_context
def command(
    ctx: click.Context,
    generate: int | None,
    first_arena: str | None,
    more_arenas: tuple[str, ...],
    seeds: int,
    seed: int,
    mission: str,
    jobs: int,
    out: TextIO | None,
    pixels: bool,
    traces: bool,
    pictures: Path,
    write_to: Path | None,
) -> None:
    """Run a mission in virtual time in many arenas. Exit 0 when every run ended as its arena expects."""
    given = [first_arena, *more_arenas] if first_arena else list(more_arenas)
    if generate is not None and given:
        raise click.UsageError("--generate and --arenas exclude each other; give one of them")
    if write_to is not None:
        if generate is None:
            raise click.UsageError("--write needs --generate N")
        _write(generate, seed, write_to)
        return
    path = mission_path(mission)
    # what cannot be loaded is told before the first run
    load_mission(path)
    if generate is not None:
        todo = generated_orders(generate, seed, seeds, path, traces, pixels)
    else:
        named = _expand(given)
        for arena in named:
            load_arena(arena)
        todo = orders(named, seeds, seed, path, traces, pixels)
    lines = LinesInOrder(todo, out, traces) if out is not None else None
    results = in_order(_run_with_bar(todo, jobs, lines), todo)
    rows = [timed.result.as_json() for timed in results]
    table_console().print(campaign_table(rows, f"campaign: {path.stem}"))
    click.echo(_speed_line(results))
    failed = [timed for timed in results if not timed.result.as_expected]
    _tell_failures(failed, pictures)
    ctx.exit(1 if failed else 0)


def _run_with_bar(todo: Sequence[RunOrder], jobs: int, lines: LinesInOrder | None) -> list[TimedResult]:
    console = table_console(stderr=True)
    columns = (TextColumn("{task.description}"), BarColumn(), MofNCompleteColumn(), TimeRemainingColumn())
    results: list[TimedResult] = []
    failed = 0
    with Progress(*columns, console=console, disable=not console.is_terminal) as progress:
        task = progress.add_task("runs", total=len(todo))
        for timed in run_all(execute, todo, jobs):
            results.append(timed)
            if lines is not None:
                lines.add(timed)
            failed += not timed.result.as_expected
            progress.update(task, advance=1, description=f"runs, {failed} failed")
    return results


def _speed_line(results: Sequence[TimedResult]) -> str:
    run_s = sum(timed.result.time_s for timed in results)
    busy_s = sum(timed.busy_s for timed in results)
    share = run_s / busy_s if busy_s > 0.0 else float("inf")
    return f"{run_s:.0f} s of missions in {busy_s:.1f} s of processor time: {share:.0f} times real time on one core"


def _tell_failures(failed: Sequence[TimedResult], pictures: Path) -> None:
    for timed in failed[:TOLD]:
        r = timed.result
        touched = ", COLLIDED" if r.collided else ""
        click.echo(f"{_what(r)}, seed {r.seed}: {r.outcome}, {r.reason or 'no reason'}{touched}")
        click.echo(f"  {replay_command(timed.order)}")
        click.echo(f"  {_picture(timed, pictures)}")
    if len(failed) > TOLD:
        click.echo(f"and {len(failed) - TOLD} more: see --json")


def _what(result: RunResult) -> str:
    """As `generated_3_46 (no_pin, level 4)`."""
    return f"{result.arena} ({result.kind}, level {result.level})" if result.level else result.arena


def _picture(timed: TimedResult, folder: Path) -> Path | str:
    try:
        from target_nav.app.run_picture import draw_run
    except ImportError:
        return "no picture: matplotlib is missing, pip install 'target_nav[sim]'"
    from target_nav.app.run_report import outcome_line

    r = timed.result
    folder.mkdir(parents=True, exist_ok=True)
    path = folder / f"{r.arena}-{r.seed}.png"
    arena = load_arena(timed.order.arena)
    title = f"{_what(r)}, seed {r.seed}: {outcome_line(r.as_json())}"
    draw_run(path, arena, r.trace, r.state_changes, title)
    return path


def _write(count: int, seed: int, folder: Path) -> None:
    folder.mkdir(parents=True, exist_ok=True)
    for number in range(count):
        write_arena(load_arena(str(GeneratedName(seed, number))), folder, Config())
    click.echo(f"{count} arenas in {folder}/")


def _expand(given: list[str]) -> list[str]:
    if not given:
        return list_arenas()
    found: list[str] = []
    for item in given:
        if item in GROUPS and not Path(item).exists():
            found.extend(list_arenas(item))
            continue
        path = Path(item)
        found.extend(str(p) for p in sorted(path.glob("*.yaml"))) if path.is_dir() else found.append(item)
    return found
