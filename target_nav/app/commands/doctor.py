"""`target-nav doctor`: what this machine has, what it lacks, and what to do about it."""

from __future__ import annotations

import click
from rich.table import Table

from target_nav.app.doctor import Verdict, examine
from target_nav.app.terminal import table_console
from target_nav.config import Config

STYLE = {Verdict.OK: "green", Verdict.NOTE: "yellow", Verdict.PROBLEM: "bold red"}


@click.command(name="doctor")
@click.option(
    "--prefix", default=Config().ipc.prefix, show_default=True, help="Of the shared-memory channels."
)
@click.pass_context
def command(ctx: click.Context, prefix: str) -> None:
    """Check Python, ROS, packages, shared memory, serial port, camera, clocks and cores. Exit 1 on a problem."""
    findings = list(examine(Config().override({"ipc.prefix": prefix})))
    table = Table(title="target-nav doctor", expand=False)
    table.add_column("what", no_wrap=True)
    table.add_column("", no_wrap=True)
    table.add_column("found", overflow="fold")
    table.add_column("what to do", overflow="fold")
    for f in findings:
        table.add_row(f.subject, f"[{STYLE[f.verdict]}]{f.verdict.value}[/]", f.found, f.advice)
    table_console().print(table)
    problems = sum(f.verdict is Verdict.PROBLEM for f in findings)
    click.echo(f"{problems} problem{'s' if problems != 1 else ''}")
    ctx.exit(1 if problems else 0)
