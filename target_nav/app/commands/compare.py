"""`target-nav compare`: two campaigns side by side."""

from __future__ import annotations

from pathlib import Path

import click

from target_nav.app.compare import compare_table, pairs_of, read_rows
from target_nav.app.terminal import table_console

TOLD = 20


@click.command(name="compare")
@click.argument("first", metavar="A.json", type=click.Path(exists=True, dir_okay=False, path_type=Path))
@click.argument("second", metavar="B.json", type=click.Path(exists=True, dir_okay=False, path_type=Path))
def command(first: Path, second: Path) -> None:
    """Compare two campaigns' JSON lines: rates and medians with 95 % intervals, in pairs where runs agree."""
    a, b = read_rows(first), read_rows(second)
    names = (first.stem, second.stem) if first.stem != second.stem else (str(first), str(second))
    table_console().print(compare_table(a, b, names))
    pairs = pairs_of(a, b)
    for words, kept in (("only in A", (True, False)), ("only in B", (False, True))):
        changed = [x for x, y in pairs if (x["as_expected"], y["as_expected"]) == kept]
        if changed:
            shown = ", ".join(f"{row['arena']} seed {row['seed']}" for row in changed[:TOLD])
            click.echo(f"as expected {words}: {shown}{' ...' if len(changed) > TOLD else ''}")
