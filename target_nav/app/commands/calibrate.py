"""`target-nav calibrate`: measures what differs from robot to robot and writes it into the configuration."""

from __future__ import annotations

from importlib import import_module

import click

PROCEDURES = {
    "odometry": "target_nav.app.commands.calibrate_odometry",
    "camera": "target_nav.app.commands.calibrate_camera",
}


class _LazyProcedures(click.Group):
    """Imports a procedure's module when it is used."""

    def list_commands(self, ctx: click.Context) -> list[str]:
        return list(PROCEDURES)

    def get_command(self, ctx: click.Context, cmd_name: str) -> click.Command | None:
        if cmd_name not in PROCEDURES:
            return None
        procedure: click.Command = import_module(PROCEDURES[cmd_name]).command
        return procedure


@click.group(name="calibrate", cls=_LazyProcedures)
def command() -> None:
    """Measure what differs from robot to robot, and write it into a configuration file."""
