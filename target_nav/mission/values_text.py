"""Blackboard values as text for a person: short, whatever they hold. An array is its shape, never its content."""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping
from enum import Enum
from typing import Any

import numpy as np

MAX_TEXT = 500
MAX_ITEMS = 8
MAX_DEPTH = 4
MANY_FIELDS = 12
"""An object inside another that has more is not for reading."""


def value_text(value: Any) -> str:
    """One line, cut at `MAX_TEXT`. What is large is described: arrays by shape, long lists by length."""
    text = _text(value, MAX_DEPTH)
    return text if len(text) <= MAX_TEXT else f"{text[:MAX_TEXT]}..."


def _text(value: Any, depth: int) -> str:
    if isinstance(value, Enum):
        return value.name
    if isinstance(value, float):
        return f"{value:.6g}"
    if isinstance(value, str):
        return value[: MAX_TEXT + 1]
    if value is None or isinstance(value, (bool, int)):
        return str(value)
    if isinstance(value, np.ndarray):
        return f"array of shape {value.shape}, {value.dtype}"
    if depth == 0:
        return "..."
    if dataclasses.is_dataclass(value) and not isinstance(value, type):
        if depth < MAX_DEPTH and len(dataclasses.fields(value)) > MANY_FIELDS:
            return f"{type(value).__name__}(...)"
        fields = (f"{f.name}={_text(getattr(value, f.name), depth - 1)}" for f in dataclasses.fields(value))
        return f"{type(value).__name__}({', '.join(fields)})"
    if isinstance(value, Mapping):
        # list() at once: a leaf's own thread must not grow it while it is walked through
        items = [f"{key}: {_text(each, depth - 1)}" for key, each in list(value.items())[:MAX_ITEMS]]
        return "{" + ", ".join(items) + _more(value) + "}"
    if isinstance(value, (list, tuple, set, frozenset)):
        items = [_text(each, depth - 1) for each in list(value)[:MAX_ITEMS]]
        return "[" + ", ".join(items) + _more(value) + "]"
    return str(value)


def _more(value: Any) -> str:
    return f", ... {len(value)} in all" if len(value) > MAX_ITEMS else ""
