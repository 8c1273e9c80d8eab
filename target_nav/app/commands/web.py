"""`target-nav web`: the operator's console in a browser."""

from __future__ import annotations

import asyncio
import ipaddress
import logging
import os
import sys
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING

import click

from target_nav.app.extras import require_extra
from target_nav.app.settings import load_config
from target_nav.config import Config
from target_nav.errors import ConfigError
from target_nav.gui.missions import mission_folder
from target_nav.gui.settings import Settings

if TYPE_CHECKING:
    from target_nav.web.access import Access
    from target_nav.web.console import Console

PORT = 8642
CHECK_PATIENCE_S, RECORDING_PATIENCE_S = 15.0, 120.0
TOKEN_VARIABLE = "TARGET_NAV_TOKEN"


@click.command(name="web")
@click.option(
    "--host", default="127.0.0.1", show_default=True, help="Address to listen on; 0.0.0.0 is all of them."
)
@click.option(
    "--port", default=PORT, show_default=True, type=click.IntRange(0, 65535), help="0: any free one."
)
@click.option(
    "--token",
    envvar=TOKEN_VARIABLE,
    show_envvar=True,
    help="What an operator has to show, 8 characters or more. Without it: a random one.",
)
@click.option("--name", "names", multiple=True, help="A further host name by which this console is reached.")
@click.option("--prefix", help="Of the shared-memory channels.  [default: that of the configuration]")
@click.option(
    "--config",
    "config_file",
    type=click.Path(exists=True, dir_okay=False, path_type=Path),
    help="What the stack was started with, as in RUN/config.yaml.",
)
@click.option(
    "--settings",
    "settings_file",
    type=click.Path(dir_okay=False, path_type=Path),
    help="YAML file to which changes of settings are saved.  [default: nowhere, they last as long as the stack]",
)
@click.option(
    "--missions",
    "missions_folder",
    type=click.Path(exists=True, file_okay=False, path_type=Path),
    help="Folder whose missions may be read, changed and loaded.  [default: trees/]",
)
@click.option(
    "--runs",
    default="runs",
    show_default=True,
    type=click.Path(file_okay=False, path_type=Path),
    help="Recordings.",
)
def command(
    host: str,
    port: int,
    token: str | None,
    names: tuple[str, ...],
    prefix: str | None,
    config_file: Path | None,
    settings_file: Path | None,
    missions_folder: Path | None,
    runs: Path,
) -> None:
    """The console in a browser: what the robot sees and does, GO and STOP, missions, settings, recordings.

    Prints two addresses: one to watch, and one, with a token, to operate. Ctrl-C ends it; a robot that is being
    driven by hand stops then, a mission goes on.
    """
    for package in ("starlette", "uvicorn", "websockets"):
        require_extra(package, "web")
    from target_nav.web.access import Access
    from target_nav.web.server import Site, bind, keep_small, serve

    logging.basicConfig(
        level=logging.INFO, format="%(asctime)s %(levelname)s %(name)s: %(message)s", datefmt="%H:%M:%S"
    )
    base = load_config(config_file) if config_file is not None else Config()
    config = base
    if settings_file is not None and settings_file.exists():
        config = load_config(settings_file, base)
    if prefix is not None:
        base, config = (c.override({"ipc.prefix": prefix}) for c in (base, config))
    settings = Settings(config, settings_file, base)
    access = Access(token, names)

    def make(wake: Callable[[], None]) -> Console:
        return console_of(settings, access, missions_folder or mission_folder(), runs, wake)

    keep_small()
    with bind(host, port) as listener:
        say_addresses(host, listener.getsockname()[1], access, shown=token is None)
        asyncio.run(serve(Site(make), listener))


def console_of(
    settings: Settings, access: Access, missions_folder: Path, runs: Path, wake: Callable[[], None]
) -> Console:
    """A console with its helper processes, which are not started before they are asked."""
    from target_nav.web.console import Console
    from target_nav.web.helper import Helper

    argv = (sys.executable, "-m", "target_nav.app.web_helper")
    return Console(
        settings.config.ipc.prefix,
        access,
        settings,
        missions_folder,
        runs,
        checker=Helper(argv, CHECK_PATIENCE_S),
        recordings=Helper(argv, RECORDING_PATIENCE_S),
        wake=wake,
    )


def say_addresses(host: str, port: int, access: Access, shown: bool) -> None:
    """`shown`: the token is a random one, which nobody knows unless it is printed."""
    address = f"http://{f'[{host}]' if ':' in host else host}:{port}/"
    click.echo(f"watch    {address}")
    click.echo(f"operate  {address}#token={access.token if shown else '...'}")
    if not is_loopback(host):
        click.echo(
            "warning: this is plain HTTP, so whoever listens on the network reads the token. Where that may be, stay "
            f"on 127.0.0.1 and use `ssh -L {port}:127.0.0.1:{port} {os.uname().nodename}`.",
            err=True,
        )


def is_loopback(host: str) -> bool:
    """
    Raises:
        ConfigError: neither an address nor `localhost`.
    """
    if host == "localhost":
        return True
    try:
        return ipaddress.ip_address(host).is_loopback
    except ValueError:
        raise ConfigError(
            f"--host {host!r} is no address; 127.0.0.1 is this machine alone, 0.0.0.0 all"
        ) from None
