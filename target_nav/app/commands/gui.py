"""`target-nav gui`: the operator's panel, beside a stack that runs or will run."""

from __future__ import annotations

from pathlib import Path

import click

from target_nav.app import gui_launch
from target_nav.config import Config
from target_nav.errors import DeviceError


@click.command(name="gui")
@click.option(
    "--prefix", default=Config().ipc.prefix, show_default=True, help="Of the shared-memory channels."
)
@click.option(
    "--config",
    type=click.Path(path_type=Path),
    help="YAML file of dotted keys that the stack was started with.",
)
@click.option(
    "--settings", type=click.Path(path_type=Path), help="YAML file that changed settings are saved to."
)
@click.option("--windowed", is_flag=True, help="A window of 800x480 instead of the whole screen.")
def command(prefix: str, config: Path | None, settings: Path | None, windowed: bool) -> None:
    """Open the operator's panel: what the robot sees and does, GO and STOP, driving by hand, settings."""
    problem = gui_launch.problem()
    if problem:
        raise DeviceError(problem)
    options = gui_launch.options_of(prefix, config, settings)
    gui_launch.main((*options, *(("--windowed",) if windowed else ())))
