from __future__ import annotations

from collections.abc import Callable, Iterator
from pathlib import Path

import pytest
from py_trees.blackboard import Blackboard

from tests.unit.mission.scripted import Trace


@pytest.fixture(autouse=True)
def empty_blackboard() -> Iterator[None]:
    """py_trees has one blackboard for the whole process."""
    Blackboard.clear()
    yield
    Blackboard.clear()


@pytest.fixture
def trace(tmp_path: Path) -> Callable[..., Trace]:
    """`trace("<Sequence><A/><B/></Sequence>", A="S", B="RS")`: a mission of scripted leaves."""

    def make(*trees: str, **scripts: str) -> Trace:
        return Trace(tmp_path, scripts, *trees)

    return make


MakeTrace = Callable[..., Trace]
