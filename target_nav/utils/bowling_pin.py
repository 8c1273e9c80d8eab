"""What a bowling pin looks like: its profile and its neck stripes, for what draws it and for what finds it.

The profile is the USBC/BTI specification of a ten-pin bowling pin (diameters at fixed heights, inches, 15 in tall), as
shares of height and of largest width, so it fits a pin of any size.
"""

from __future__ import annotations

import numpy as np

from target_nav.state.types import FloatArray

CLASS_NAME = "bowling_pin"

_SPECIFICATION_IN = np.array(
    [
        (0.0, 2.031),
        (0.75, 2.828),
        (2.25, 3.906),
        (3.375, 4.510),
        (4.5, 4.766),
        (5.875, 4.563),
        (7.25, 3.703),
        (8.625, 2.472),
        (9.375, 1.965),
        (10.0, 1.797),
        (10.875, 1.870),
        (11.75, 2.094),
        (12.625, 2.406),
        (13.5, 2.547),
    ]
)
_HEIGHT_IN = 15.0
_HEAD_RADIUS_IN = 1.273
_BELLY_IN = 4.766
_HEAD_STEPS = 9

# Centre and thickness, shares of the height: one below and one above the narrowest place.
STRIPES = ((0.655, 0.045), (0.740, 0.045))


def _profile() -> tuple[FloatArray, FloatArray]:
    """Heights and widths; the head is a half circle over the last of the specified diameters."""
    angle = np.linspace(0.0, np.pi / 2, _HEAD_STEPS)[1:]
    rise_in = _HEIGHT_IN - _SPECIFICATION_IN[-1, 0]
    heights = np.concatenate([_SPECIFICATION_IN[:, 0], _SPECIFICATION_IN[-1, 0] + rise_in * np.sin(angle)])
    widths = np.concatenate([_SPECIFICATION_IN[:, 1], 2.0 * _HEAD_RADIUS_IN * np.cos(angle)])
    return heights / _HEIGHT_IN, widths / _BELLY_IN


PROFILE_HEIGHTS, PROFILE_WIDTHS = _profile()


def width_at(height_share: FloatArray) -> FloatArray:
    """Width of the pin, of its largest width, at heights given as shares of its own; 0 outside of [0, 1]."""
    return np.interp(height_share, PROFILE_HEIGHTS, PROFILE_WIDTHS, left=0.0, right=0.0)
