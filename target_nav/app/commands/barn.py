"""`target-nav barn`: the worlds of the BARN set, and the set's score."""

from __future__ import annotations

import json
import os
from pathlib import Path
from typing import TextIO

import click
from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeRemainingColumn

from target_nav.app.barn import BarnOrder, BarnRun, barn_table, execute
from target_nav.app.paths import mission_path
from target_nav.app.spread import run_all
from target_nav.app.terminal import table_console
from target_nav.mission import load_mission
from target_nav.sim.barn import ROBOTS, BarnName, read_barn

TOLD = 20


@click.command(name="barn")
@click.argument("folder", type=click.Path(exists=True, file_okay=False, path_type=Path))
@click.option(
    "--robot",
    type=click.Choice(sorted(ROBOTS)),
    default="jackal",
    show_default=True,
    help="jackal: the set's own, at the set's scale. own: the reference robot, the worlds scaled to it.",
)
@click.option("--every", default=1, show_default=True, type=click.IntRange(1), help="Every n-th world only.")
@click.option("--seeds", default=1, show_default=True, type=click.IntRange(1), help="Runs per world.")
@click.option("--seed", default=1, show_default=True, type=click.IntRange(0), help="Of the first run.")
@click.option(
    "--mission", default="go_to_point", show_default=True, help="Mission file, or a name in trees/."
)
@click.option(
    "--jobs", default=os.cpu_count() or 1, show_default=True, type=click.IntRange(1), help="Processes."
)
@click.option("--json", "out", type=click.File("w"), help="One JSON line a run.")
@click.pass_context
def command(
    ctx: click.Context,
    folder: Path,
    robot: str,
    every: int,
    seeds: int,
    seed: int,
    mission: str,
    jobs: int,
    out: TextIO | None,
) -> None:
    """Run the worlds in FOLDER in virtual time. Exit 0 when every one was reached without a collision."""
    path = mission_path(mission)
    load_mission(path)
    worlds = read_barn(folder)[::every]
    todo = [
        BarnOrder(BarnName(robot, world.index, folder.resolve()), seed + number * seeds + k, str(path))
        for number, world in enumerate(worlds)
        for k in range(seeds)
    ]
    runs: list[BarnRun] = []
    console = table_console(stderr=True)
    columns = (TextColumn("{task.description}"), BarColumn(), MofNCompleteColumn(), TimeRemainingColumn())
    with Progress(*columns, console=console, disable=not console.is_terminal) as progress:
        task = progress.add_task("worlds", total=len(todo))
        for run in run_all(execute, todo, jobs):
            runs.append(run)
            progress.advance(task)
    runs.sort(key=lambda run: (run.name.index, run.result.seed))
    if out is not None:
        out.writelines(json.dumps(run.as_json()) + "\n" for run in runs)
        out.flush()
    table_console().print(barn_table(runs, f"BARN, {robot}"))
    run_s, busy_s = sum(run.result.time_s for run in runs), sum(run.busy_s for run in runs)
    click.echo(
        f"{run_s:.0f} s of runs in {busy_s:.1f} s of processor time: {run_s / busy_s:.1f} times real time on one core"
    )
    failed = [run for run in runs if not run.succeeded]
    for run in failed[:TOLD]:
        r = run.result
        click.echo(f"world {run.name.index} seed {r.seed}: {'COLLIDED' if r.collided else r.reason}")
        click.echo(f"  target-nav run --sim {run.name} --virtual --seed {r.seed} --mission {mission}")
    ctx.exit(1 if failed else 0)
