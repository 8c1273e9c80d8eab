"""View models as JSON values: dataclasses become mappings, arrays lists, what is not finite becomes null."""

from __future__ import annotations

import dataclasses
import math
from enum import Enum
from typing import Any

import numpy as np

DECIMALS = 3
"""Of metres, seconds and radians on a screen: more would only make messages longer."""


def to_plain(value: Any) -> Any:
    """Pictures (uint8 arrays) are left out as null: they go another way."""
    if isinstance(value, float):
        return round(value, DECIMALS) if math.isfinite(value) else None
    if isinstance(value, Enum):
        return value.name
    if value is None or isinstance(value, (bool, int, str)):
        return value
    if isinstance(value, np.ndarray):
        if value.dtype == np.uint8:
            return None
        if value.dtype == np.float64 and np.isfinite(value).all():
            return np.round(value, DECIMALS).tolist()
        return to_plain(value.tolist())
    if dataclasses.is_dataclass(value):
        return {field.name: to_plain(getattr(value, field.name)) for field in dataclasses.fields(value)}
    if isinstance(value, dict):
        return {str(key): to_plain(item) for key, item in value.items()}
    if isinstance(value, (list, tuple)):
        return [to_plain(item) for item in value]
    return str(value)
