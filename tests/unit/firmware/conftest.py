"""The firmware's library, built for this machine before the first test that needs it."""

from __future__ import annotations

from pathlib import Path

import pytest

from tests.utils.firmware import built_library


@pytest.fixture(scope="session", autouse=True)
def library() -> Path:
    return built_library()
