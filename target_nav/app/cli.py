"""`target-nav`: the command line. Exit codes: 0 it worked, 1 it ran and failed, 2 it could not be run."""

from __future__ import annotations

import sys
from importlib import import_module

import click

from target_nav import __version__
from target_nav.errors import TargetNavError

COMMANDS = {
    "run": "target_nav.app.commands.run",
    "campaign": "target_nav.app.commands.campaign",
    "compare": "target_nav.app.commands.compare",
    "barn": "target_nav.app.commands.barn",
    "check": "target_nav.app.commands.check",
    "convert": "target_nav.app.commands.convert",
    "nodes": "target_nav.app.commands.nodes",
    "render": "target_nav.app.commands.render",
    "test": "target_nav.app.commands.test",
    "replay": "target_nav.app.commands.replay",
    "gui": "target_nav.app.commands.gui",
    "calibrate": "target_nav.app.commands.calibrate",
    "doctor": "target_nav.app.commands.doctor",
    "say": "target_nav.app.commands.say",
    "status": "target_nav.app.commands.status",
    "web": "target_nav.app.commands.web",
}


class _LazyGroup(click.Group):
    """Imports a command's module when it is used: `target-nav check` needs no simulator."""

    def list_commands(self, ctx: click.Context) -> list[str]:
        return list(COMMANDS)

    def get_command(self, ctx: click.Context, cmd_name: str) -> click.Command | None:
        if cmd_name not in COMMANDS:
            return None
        command: click.Command = import_module(COMMANDS[cmd_name]).command
        return command


@click.group(cls=_LazyGroup, context_settings={"help_option_names": ["-h", "--help"]})
@click.version_option(__version__, prog_name="target-nav")
def cli() -> None:
    """Behaviour-tree missions for small robots that find a thing, go to it and stop there."""


def main() -> None:
    try:
        sys.exit(cli.main(standalone_mode=False) or 0)
    except TargetNavError as error:
        click.echo(str(error), err=True)
        sys.exit(2)
    except click.ClickException as error:
        error.show()
        sys.exit(2)
    except (click.Abort, KeyboardInterrupt):
        click.echo("interrupted", err=True)
        sys.exit(130)


if __name__ == "__main__":
    main()
