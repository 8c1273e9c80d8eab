"""How far one sees in each direction past obstacle points, which are a sample of surfaces and not the surfaces.

Points are kept one a cell of 5 cm. Of a wall a quarter of a metre away they are eleven degrees apart; taken as points,
there would be a view through it between any two, and what lies behind it would count as seen.
"""

from __future__ import annotations

import math

import numpy as np

from target_nav.state.types import FloatArray

HALF_WIDTH_M = 0.05
"""Half of the way from one point of a surface to the next, at most: two cells."""


def nearest_by_direction_m(
    dx_m: FloatArray, dy_m: FloatArray, directions: int, turn: float = 0.0
) -> FloatArray:
    """Range of the nearest obstacle by direction, shape (directions,), infinite where there is none.

    `dx_m`, `dy_m`, shape (N,), are the points as seen from the place, axes as odom's. Direction k is centred at
    -pi + (k + turn) times the step.
    """
    nearest: FloatArray = np.full(directions, math.inf)
    if not len(dx_m):
        return nearest
    range_m = np.hypot(dx_m, dy_m)
    step_rad = 2.0 * math.pi / directions
    index = np.rint((np.arctan2(dy_m, dx_m) + math.pi) / step_rad - turn).astype(np.intp)
    half_width = np.arctan2(HALF_WIDTH_M, range_m) / step_rad
    np.minimum.at(nearest, index % directions, range_m)
    beside = 1
    while len(wide := np.flatnonzero(half_width > beside - 0.5)):
        index, range_m, half_width = index[wide], range_m[wide], half_width[wide]
        np.minimum.at(nearest, (index + beside) % directions, range_m)
        np.minimum.at(nearest, (index - beside) % directions, range_m)
        beside += 1
    return nearest
