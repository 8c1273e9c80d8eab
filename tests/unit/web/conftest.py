"""A prefix of its own for every test, so that tests and running robots never meet in /dev/shm."""

from __future__ import annotations

import os
from collections.abc import Iterator
from itertools import count
from pathlib import Path

import pytest

_numbers = count()


@pytest.fixture
def prefix() -> Iterator[str]:
    mine = f"w{os.getpid()}-{next(_numbers)}"
    yield mine
    for path in Path("/dev/shm").glob(f"{mine}_*"):
        path.unlink()
