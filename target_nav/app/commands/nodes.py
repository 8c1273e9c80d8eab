"""`target-nav nodes`: the words a mission may use."""

from __future__ import annotations

from pathlib import Path

import click
from rich.markup import escape
from rich.table import Table

from target_nav.app.output_file import write_output
from target_nav.app.terminal import table_console
from target_nav.mission import default_registry
from target_nav.mission.vocabulary import Group, NodeEntry, PortEntry, groot_model, markdown, vocabulary


@click.command(name="nodes")
@click.argument("names", nargs=-1, metavar="[NAME...]")
@click.option("--markdown", "as_markdown", is_flag=True, help="As a page of Markdown (docs/nodes.md).")
@click.option("--groot", is_flag=True, help="As Groot2's TreeNodesModel: load it there as a palette.")
@click.option(
    "-o",
    "--output",
    type=click.Path(path_type=Path),
    help="A file for --markdown or --groot; default: the terminal.",
)
def command(names: tuple[str, ...], as_markdown: bool, groot: bool, output: Path | None) -> None:
    """Show the nodes that missions are written with, or those whose names contain one of the NAMEs."""
    if as_markdown and groot:
        raise click.UsageError("--markdown or --groot, not both")
    if (as_markdown or groot) and names:
        raise click.UsageError("--markdown and --groot are of all nodes; leave the names out")
    registry = default_registry()
    entries = vocabulary(registry)
    if as_markdown or groot:
        text = groot_model(registry) if groot else markdown(entries)
        if output is None:
            click.echo(text, nl=False)
        else:
            write_output(output, text)
        return
    if output is not None:
        raise click.UsageError("-o goes with --markdown or --groot")
    shown = [
        entry for entry in entries if not names or any(n.casefold() in entry.name.casefold() for n in names)
    ]
    if not shown:
        raise click.UsageError(f"no node's name contains {' or '.join(names)}")
    console = table_console()
    for group in Group:
        of_group = [entry for entry in shown if entry.group is group]
        if of_group:
            console.print(_table(group, of_group))


def _table(group: Group, entries: list[NodeEntry]) -> Table:
    table = Table(title=group.value, title_justify="left", show_lines=True)
    table.add_column("node", no_wrap=True, style="bold")
    table.add_column("what it does", ratio=2)
    table.add_column("ports", ratio=3)
    for entry in entries:
        children = f"\n[dim]children: {entry.children}[/dim]" if entry.children else ""
        table.add_row(entry.name, f"{escape(entry.summary)}{children}", "\n".join(map(_port, entry.ports)))
    return table


def _port(port: PortEntry) -> str:
    what = " ".join(filter(None, [port.type, port.limits, port.unit]))
    default = f"; {port.default}" if port.default else ""
    arrow = "[magenta]out[/magenta] " if port.is_output else ""
    return f"{arrow}[cyan]{port.name}[/cyan] {escape(port.doc)} [dim]({escape(what + default)})[/dim]"
