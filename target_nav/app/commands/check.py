"""`target-nav check`: everything wrong with mission files, all of it at once."""

from __future__ import annotations

from pathlib import Path

import click

from target_nav.mission.check import check_file


@click.command(name="check")
@click.argument("files", nargs=-1, required=True, type=click.Path(path_type=Path))
@click.pass_context
def command(ctx: click.Context, files: tuple[Path, ...]) -> None:
    """Check mission files. Exit 1 when anything is wrong."""
    problems = [problem for file in files for problem in check_file(file)]
    for problem in problems:
        click.echo(str(problem))
    if not problems:
        click.echo(f"{len(files)} mission file{'s' if len(files) != 1 else ''}: nothing wrong")
    ctx.exit(1 if problems else 0)
