"""`target-nav convert`: a mission file in the other notation."""

from __future__ import annotations

from pathlib import Path

import click

from target_nav.app.output_file import write_output
from target_nav.app.paths import mission_path
from target_nav.mission.convert import convert
from target_nav.mission.notations import required_notation


@click.command(name="convert")
@click.argument("source", metavar="IN")
@click.argument("target", metavar="OUT", type=click.Path(path_type=Path))
def command(source: str, target: Path) -> None:
    """Write a mission in the other notation; the suffixes (.xml, .yaml, .yml) say which is which.

    Nothing is lost, comments neither. From a notation to itself the file is tidied. What a mission includes is not
    rewritten. IN may be a name in trees/.
    """
    write_output(target, convert(mission_path(source), required_notation(target)))
