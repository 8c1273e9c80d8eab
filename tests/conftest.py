"""Fixtures for all tests."""

from __future__ import annotations

import os
from collections.abc import Iterator

import py_trees
import pytest
from hypothesis import settings

from tests.utils.board import ScriptedBoard

# The same examples each time, so that a green run stays green; TARGET_NAV_HYPOTHESIS=random looks for new ones.
settings.register_profile("repeatable", derandomize=True, deadline=None)
settings.register_profile("random", deadline=None)
settings.load_profile(os.environ.get("TARGET_NAV_HYPOTHESIS", "repeatable"))


@pytest.fixture
def board() -> Iterator[ScriptedBoard]:
    """A scripted blackboard; py_trees keeps one per process, so it is emptied before and after."""
    py_trees.blackboard.Blackboard.clear()
    scripted = ScriptedBoard()
    yield scripted
    scripted.close()
