"""Which obstacle point is nearest to a place: looked up in a grid instead of searched for.

A distance transform gives each cell its nearest occupied cell, and that cell's own point gives the distance, so it is
not rounded to cells. Among points that are about equally near it may name the second, by a cell's width at most.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import distance_transform_edt

from target_nav.state.types import FloatArray

NOWHERE_M = 1e3
"""Where a point is said to be when there is none: off by so much in x and y."""


class NearestPoint:
    """Points round a centre, both in one frame. Outside of the window there are none."""

    def __init__(
        self, points_m: FloatArray, centre_m: tuple[float, float], half_m: float, cell_m: float
    ) -> None:
        """`points_m` has shape (N, 2); the window is `2 half_m` wide."""
        self._cell_m = cell_m
        self.half_cells = math.ceil(half_m / cell_m)
        self.side = 2 * self.half_cells + 1
        # one more on each side, for what is asked beyond the window
        self._last = self.side + 1
        self._origin = (centre_m[0] - self.half_cells * cell_m, centre_m[1] - self.half_cells * cell_m)
        shape = (self.side + 2, self.side + 2)
        self.x_m, self.y_m = np.full(shape, NOWHERE_M), np.full(shape, NOWHERE_M)
        if not len(points_m):
            return
        column, row = self.cells(points_m[:, 0], points_m[:, 1])
        inside = (column > 0) & (column < self._last) & (row > 0) & (row < self._last)
        column, row, points_m = column[inside], row[inside], points_m[inside]
        if not len(points_m):
            return
        free = np.ones(shape, dtype=np.bool_)
        free[row, column] = False
        own_x, own_y = self.x_m.copy(), self.y_m.copy()
        own_x[row, column], own_y[row, column] = points_m[:, 0], points_m[:, 1]
        nearest = distance_transform_edt(free, return_distances=False, return_indices=True)
        self.x_m, self.y_m = own_x[nearest[0], nearest[1]], own_y[nearest[0], nearest[1]]

    def cells(self, x_m: FloatArray, y_m: FloatArray) -> tuple[NDArray[np.intp], NDArray[np.intp]]:
        """Column and row in the arrays; what is outside lands in the rim."""
        column = np.rint((x_m - self._origin[0]) * (1.0 / self._cell_m)).astype(np.intp) + 1
        row = np.rint((y_m - self._origin[1]) * (1.0 / self._cell_m)).astype(np.intp) + 1
        return (
            np.minimum(np.maximum(column, 0), self._last),
            np.minimum(np.maximum(row, 0), self._last),
        )

    def centres(self) -> tuple[FloatArray, FloatArray]:
        """x and y of each cell's middle, rim included, shape (side + 2, side + 2)."""
        steps = np.arange(-1, self.side + 1) * self._cell_m
        x, y = np.meshgrid(self._origin[0] + steps, self._origin[1] + steps)
        return x, y

    def distances_m(self) -> FloatArray:
        """From each cell's middle to its nearest point, rim included."""
        x, y = self.centres()
        distance: FloatArray = np.hypot(self.x_m - x, self.y_m - y)
        return distance

    def nearest_to(self, x_m: FloatArray, y_m: FloatArray) -> tuple[FloatArray, FloatArray]:
        """x and y of the point nearest to each place."""
        column, row = self.cells(x_m, y_m)
        return self.x_m[row, column], self.y_m[row, column]
