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


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """With `-n 2 --dist loadgroup` whole stacks run one after the other on one core, all else beside them."""
    for item in items:
        if item.get_closest_marker("slow") or item.get_closest_marker("ros"):
            item.add_marker(pytest.mark.xdist_group("stacks"))


@pytest.fixture
def board() -> Iterator[ScriptedBoard]:
    """A scripted blackboard; py_trees keeps one per process, so it is emptied before and after."""
    py_trees.blackboard.Blackboard.clear()
    scripted = ScriptedBoard()
    yield scripted
    scripted.close()
