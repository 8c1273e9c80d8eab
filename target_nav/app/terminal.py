"""The console that tables are printed to."""

from __future__ import annotations

import sys

from rich.console import Console

FILE_WIDTH = 160
"""Where there is no terminal (a log, a pipe), a table is as wide as it needs."""


def table_console(stderr: bool = False) -> Console:
    stream = sys.stderr if stderr else sys.stdout
    return Console(stderr=stderr, width=None if stream.isatty() else FILE_WIDTH)
