"""`target-nav render`: a mission as a picture or as a tree of text."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import click
from rich.console import Console

from target_nav.app.output_file import write_output
from target_nav.app.paths import mission_path
from target_nav.mission.draw import draw_png, draw_svg, tree_of
from target_nav.mission.draw_nodes import DrawNode
from target_nav.mission.draw_text import plain_text_of, text_of

if TYPE_CHECKING:
    from target_nav.app.run_statuses import RecordedTick

SUFFIXES = (".svg", ".png", ".txt")


@click.command(name="render")
@click.argument("mission", required=False)
@click.option(
    "-o",
    "--output",
    type=click.Path(path_type=Path),
    help="A file .svg, .png or .txt; default: the terminal.",
)
@click.option(
    "--run",
    type=click.Path(exists=True, path_type=Path),
    help="A recorded run (its folder or .mcap file): nodes are coloured by their status. MISSION may be left out.",
)
@click.option(
    "--at", "at_s", type=click.FloatRange(0.0), metavar="SECONDS", help="Of the run; default: its end."
)
def command(mission: str | None, output: Path | None, run: Path | None, at_s: float | None) -> None:
    """Draw a mission's tree, its subtrees written out. MISSION is a file, XML or YAML, or a name in trees/."""
    if output is not None and output.suffix.lower() not in SUFFIXES:
        raise click.UsageError(f"{output}: a picture is {', '.join(SUFFIXES[:-1])} or {SUFFIXES[-1]}")
    if mission is None and run is None:
        raise click.UsageError("name a mission, or a run with --run")
    if at_s is not None and run is None:
        raise click.UsageError("--at is a moment of a run; name it with --run")
    tree, caption = _recorded(mission, run, at_s) if run is not None else _written(mission_path(str(mission)))
    if output is None:
        Console(highlight=False).print(text_of(tree), soft_wrap=True)
    elif output.suffix.lower() == ".txt":
        write_output(output, f"{caption}\n\n{plain_text_of(tree)}")
    elif output.suffix.lower() == ".svg":
        write_output(output, draw_svg(tree, caption))
    else:
        write_output(output, draw_png(tree, caption))


def _written(path: Path) -> tuple[DrawNode, str]:
    return tree_of(path), path.name


def _recorded(mission: str | None, run: Path, at_s: float | None) -> tuple[DrawNode, str]:
    try:
        from target_nav.app.run_statuses import mission_of, recording_in, tick_at
    except ImportError:
        raise click.ClickException("reading a recording needs mcap (pip install 'target_nav[sim]')") from None

    header, tick = tick_at(recording_in(run), at_s)
    if mission is not None:
        tree = tree_of(mission_path(mission), tick.statuses)
    else:
        with mission_of(header) as path:
            tree = tree_of(path, tick.statuses)
    return tree, _caption(header.mission, tick)


def _caption(mission: str, tick: RecordedTick) -> str:
    words = f"{mission} at {tick.at_s:.2f} s: {tick.state}"
    if tick.leaf:
        words += f", {tick.leaf}"
    return f"{words}: {tick.reason}" if tick.reason else words
