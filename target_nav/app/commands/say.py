"""`target-nav say`: an operator's word to the running nav process."""

from __future__ import annotations

import contextlib
import time

import click

from target_nav.config import Config
from target_nav.errors import DeviceError
from target_nav.ipc import channels
from target_nav.state.types import Command, CommandKind

WORDS = [kind.name.lower() for kind in CommandKind]
LISTEN_S = 1.0


@click.command(name="say")
@click.argument("word", type=click.Choice(WORDS, case_sensitive=False))
@click.argument("argument", default="")
@click.option(
    "--prefix", default=Config().ipc.prefix, show_default=True, help="Of the shared-memory channels."
)
def command(word: str, argument: str, prefix: str) -> None:
    """Send a word to the running nav process: go, stop, pause, resume, step, reload or reset_odom.

    With an argument: `load MISSION`, `target CLASS,HEIGHT_M,WIDTH_M` (empty: the mission's), `setting KEY=VALUE`,
    `manual VX,VY,WZ` (for the time of the deadman), `firmware TMOTOR,FL,60`.
    """
    kind = CommandKind[word.upper()]
    with contextlib.closing(channels.open_command_writer(prefix)) as writer:
        # the reader's acknowledgement takes a tick to show that somebody listens
        deadline_s = time.monotonic() + LISTEN_S
        while not writer.push(Command(time.monotonic(), kind, argument)):
            if time.monotonic() > deadline_s:
                raise DeviceError(
                    f"nobody took {kind.name} within {LISTEN_S:.0f} s; does nav run with prefix {prefix!r}? "
                    "(target-nav status)"
                )
            time.sleep(0.05)
    click.echo(f"{kind.name} sent")
