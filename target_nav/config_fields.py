"""What a configuration's values are made of: a default with its unit, limits and reason, and the check against them."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import field
from typing import Any

from target_nav.errors import ConfigError


def quantity(default: float | int, unit: str, low: float, high: float, doc: str) -> Any:
    """A number with its unit and its inclusive limits."""
    return field(default=default, metadata={"unit": unit, "low": low, "high": high, "doc": doc})


def choice(default: str, options: tuple[str, ...], doc: str) -> Any:
    return field(default=default, metadata={"options": options, "doc": doc})


def switch(default: bool, doc: str) -> Any:
    return field(default=default, metadata={"doc": doc})


def checked(key: str, value: object, current: object, metadata: Mapping[str, Any]) -> Any:
    """`value` in the type of `current`, or a ConfigError that names the limit."""
    if isinstance(current, bool):
        if not isinstance(value, bool):
            raise ConfigError(f"{key} is {value!r}; it must be true or false")
        return value
    if isinstance(current, str):
        options = metadata.get("options")
        if not isinstance(value, str) or (options and value not in options):
            raise ConfigError(f"{key} is {value!r}; it must be {' or '.join(options) if options else 'text'}")
        return value
    if isinstance(value, bool) or not isinstance(value, (int, float)) or not math.isfinite(value):
        raise ConfigError(f"{key} is {value!r}; it must be a finite number in {metadata['unit']}")
    low, high, unit = metadata["low"], metadata["high"], metadata["unit"]
    if not low <= value <= high:
        raise ConfigError(
            f"{key} is {value:g} {unit}; it must lie in {low:g} ... {high:g} {unit} ({metadata['doc']})"
        )
    if isinstance(current, int):
        if value != int(value):
            raise ConfigError(f"{key} is {value!r}; it must be a whole number")
        return int(value)
    return float(value)
