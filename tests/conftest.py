"""Fixtures for all tests."""

from __future__ import annotations

from collections.abc import Iterator

import py_trees
import pytest

from tests.utils.board import ScriptedBoard


@pytest.fixture
def board() -> Iterator[ScriptedBoard]:
    """A scripted blackboard; py_trees keeps one per process, so it is emptied before and after."""
    py_trees.blackboard.Blackboard.clear()
    scripted = ScriptedBoard()
    yield scripted
    scripted.close()
