"""`target-nav replay`: does the tree still decide as it did?"""

from __future__ import annotations

from pathlib import Path

import click
from rich.table import Table

from target_nav.app.extras import require_extra
from target_nav.app.terminal import table_console


@click.command(name="replay")
@click.argument("run", type=click.Path(exists=True, path_type=Path))
@click.option(
    "--mission", type=click.Path(exists=True, dir_okay=False, path_type=Path), help="Another mission file."
)
@click.option("--most", default=20, show_default=True, type=click.IntRange(1), help="Differences to keep.")
@click.pass_context
def command(ctx: click.Context, run: Path, mission: Path | None, most: int) -> None:
    """Tick the tree again on a run's recording and compare. Exit 1 when a decision differs.

    RUN is a folder under runs/, or the .mcap file in it.
    """
    require_extra("mcap", "sim")
    from target_nav.app.replay import replay

    path = run / "run.mcap" if run.is_dir() else run
    report = replay(path, mission, most)
    if not report.differences:
        click.echo(f"{report.ticks} ticks replayed, every decision the same")
        ctx.exit(0)
    table = Table(title=f"{path}: first differences in {report.ticks} ticks")
    for column in ("tick", "time", "what", "then", "now"):
        table.add_column(column, overflow="fold")
    for d in report.differences:
        table.add_row(str(d.tick), f"{d.now_s:.2f} s", d.what, str(d.then), str(d.now))
    table_console().print(table)
    ctx.exit(1)
