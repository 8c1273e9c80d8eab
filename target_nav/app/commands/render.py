"""`target-nav render`: a mission as a tree of text."""

from __future__ import annotations

from pathlib import Path

import click

from target_nav.app.paths import mission_path
from target_nav.mission import load_mission
from target_nav.mission.render import render_text


@click.command(name="render")
@click.argument("mission")
@click.option(
    "-o",
    "--output",
    type=click.Path(dir_okay=False, path_type=Path),
    help="A .txt file; default: the terminal.",
)
def command(mission: str, output: Path | None) -> None:
    """Draw a mission's tree."""
    if output is not None and output.suffix not in ("", ".txt"):
        raise click.UsageError(f"{output}: only text can be drawn so far (.txt)")
    text = render_text(load_mission(mission_path(mission)).root, None)
    if output is None:
        click.echo(text)
    else:
        output.write_text(text + "\n", encoding="utf-8")
