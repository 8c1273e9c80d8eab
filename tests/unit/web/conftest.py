"""The console's tests need its packages; where they are not installed (the fast environments) they are left out."""

from __future__ import annotations

import os
from collections.abc import Iterator
from itertools import count
from pathlib import Path

import pytest

for package in ("starlette", "uvicorn", "websockets"):
    pytest.importorskip(package, reason=f"the extra `web` is not installed here ({package})")

_numbers = count()


@pytest.fixture
def prefix() -> Iterator[str]:
    """A prefix of its own for every test, so that tests and running robots never meet in /dev/shm."""
    mine = f"w{os.getpid()}-{next(_numbers)}"
    yield mine
    for path in Path("/dev/shm").glob(f"{mine}_*"):
        path.unlink()
