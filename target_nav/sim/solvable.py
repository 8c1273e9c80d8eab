"""Can this body do it at all? A flood fill of its footprint over places and headings, from the start to a stop.

Each heading is a layer of the grid: a cell is free where the footprint, held so and grown by a margin, touches nothing.
Cells are neighbours along x, along y and to the next heading. So a narrow body passes a narrow gap lengthways, a wide
one does not, and neither is guessed by a radius.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import label
from scipy.sparse import coo_matrix
from scipy.sparse.csgraph import connected_components

from target_nav.sim.arena_types import Arena, BoxObstacle, CircleObstacle, PlacedObject
from target_nav.sim.world import World
from target_nav.state.types import FloatArray

CELL_M = 0.025
HEADINGS = 16
RUN_UP_M = 0.27
"""The last way to the stop is straight: nearer than this the camera does not see the pin."""
NO_TARGET_SHARE = 0.4
"""Where there is nothing to be found, so much of the room can be gone to."""

BoolGrid = NDArray[np.bool_]


class Solver:
    """One arena's answer. `margin_m` is kept free round the body: by default what the configuration wants kept free."""

    def __init__(self, arena: Arena, margin_m: float | None = None) -> None:
        self._arena = arena
        self._body = arena.config.robot
        self._margin_m = arena.config.avoid.margin_m if margin_m is None else margin_m
        x0, y0, x1, y1 = arena.bounds
        self._origin = (x0, y0)
        self._shape = (math.ceil((y1 - y0) / CELL_M) + 1, math.ceil((x1 - x0) / CELL_M) + 1)

    def is_solvable(self) -> bool:
        """Whether the stop before the target, or the goal, can be reached; without either, enough of the room."""
        arena = self._arena
        free = self._free()
        regions = _joined(free)
        at = self._cell(arena.robot.x_m, arena.robot.y_m)
        start = int(regions[_heading(arena.robot.yaw_rad), at[0], at[1]]) if at is not None else 0
        if start == 0:
            return False
        if arena.target is not None:
            return any(self._stop_reached(regions, start, arena.target, h) for h in range(HEADINGS))
        reached = regions == start
        if arena.goal is not None:
            goal = self._cell(arena.goal.x_m, arena.goal.y_m)
            return goal is not None and bool(reached[:, goal[0], goal[1]].any())
        return bool(reached.any(axis=0).mean() >= NO_TARGET_SHARE)

    def _stop_reached(
        self, regions: NDArray[np.int32], start: int, target: PlacedObject, heading: int
    ) -> bool:
        """Every cell of the run-up and of the stop itself belongs to where the start is."""
        angle = 2.0 * math.pi * heading / HEADINGS
        stop_m = self._body.front_m + self._arena.config.approach.stand_off_m + target.shape.radius_m
        for away_m in np.arange(stop_m, stop_m + RUN_UP_M + CELL_M, CELL_M):
            x, y = target.x_m - away_m * math.cos(angle), target.y_m - away_m * math.sin(angle)
            at = self._cell(x, y)
            if at is None or regions[heading, at[0], at[1]] != start:
                return False
        return True

    def _free(self) -> BoolGrid:
        """Shape (HEADINGS, rows, columns)."""
        rows, columns = self._shape
        reach = self._reach_cells()
        # convolved by way of Fourier, large enough that nothing wraps round into the room
        size = (rows + 2 * reach, columns + 2 * reach)
        occupied = np.fft.rfft2(self._occupied(), size)
        free = np.empty((HEADINGS, rows, columns), dtype=np.bool_)
        # a body as long before base_link as behind it looks the same from behind
        layers = HEADINGS // 2 if self._body.front_m == self._body.rear_m else HEADINGS
        for heading in range(layers):
            mask = self._mask(2.0 * math.pi * heading / HEADINGS)
            touched = np.fft.irfft2(occupied * np.fft.rfft2(mask, size), size)
            free[heading::layers] = touched[reach : reach + rows, reach : reach + columns] < 0.5
        return free

    def _reach_cells(self) -> int:
        return math.ceil((self._body.circumscribed_radius_m + 2.0 * self._margin_m) / CELL_M)

    def _mask(self, yaw_rad: float) -> FloatArray:
        """The grown footprint, mirrored, as a convolution asks for it."""
        body, grow, reach = self._body, self._margin_m, self._reach_cells()
        steps = np.arange(-reach, reach + 1) * CELL_M
        dx, dy = -steps[None, :], -steps[:, None]
        c, s = math.cos(yaw_rad), math.sin(yaw_rad)
        along, across = c * dx + s * dy, c * dy - s * dx
        over_x = np.maximum(np.maximum(along - body.front_m, -body.rear_m - along), 0.0)
        over_y = np.maximum(np.abs(across) - body.half_width_m, 0.0)
        mask: FloatArray = (np.hypot(over_x, over_y) <= grow).astype(np.float64)
        return mask

    def _occupied(self) -> BoolGrid:
        """Cells that anything solid reaches into."""
        rows, columns = np.indices(self._shape)
        x = self._origin[0] + columns * CELL_M
        y = self._origin[1] + rows * CELL_M
        half_cell_m = 0.5 * CELL_M
        occupied = np.zeros(self._shape, dtype=np.bool_)
        for x1, y1, x2, y2 in World(self._arena).segments.tolist():
            ex, ey = x2 - x1, y2 - y1
            along = np.clip(((x - x1) * ex + (y - y1) * ey) / (ex * ex + ey * ey), 0.0, 1.0)
            occupied |= np.hypot(x - x1 - along * ex, y - y1 - along * ey) <= half_cell_m
        for obstacle in self._arena.obstacles:
            if isinstance(obstacle, BoxObstacle):
                c, s = math.cos(obstacle.yaw_rad), math.sin(obstacle.yaw_rad)
                u = c * (x - obstacle.x_m) + s * (y - obstacle.y_m)
                v = c * (y - obstacle.y_m) - s * (x - obstacle.x_m)
                occupied |= (np.abs(u) <= 0.5 * obstacle.length_m) & (np.abs(v) <= 0.5 * obstacle.width_m)
        circles = [(o.x_m, o.y_m, o.radius_m) for o in self._arena.obstacles if isinstance(o, CircleObstacle)]
        circles += [(o.x_m, o.y_m, o.shape.radius_m) for o in self._arena.objects]
        for cx, cy, radius in circles:
            occupied |= np.hypot(x - cx, y - cy) <= radius + half_cell_m
        return occupied

    def _cell(self, x_m: float, y_m: float) -> tuple[int, int] | None:
        """Row and column; None outside."""
        row, column = round((y_m - self._origin[1]) / CELL_M), round((x_m - self._origin[0]) / CELL_M)
        inside = 0 <= row < self._shape[0] and 0 <= column < self._shape[1]
        return (row, column) if inside else None


def _heading(yaw_rad: float) -> int:
    return round(yaw_rad * HEADINGS / (2.0 * math.pi)) % HEADINGS


def _joined(free: BoolGrid) -> NDArray[np.int32]:
    """Connected regions, numbered from 1; the last heading is the first one's neighbour."""
    regions, count = label(free)
    seam = np.stack([regions[0], regions[-1]], axis=-1).reshape(-1, 2)
    pairs = np.unique(seam[(seam > 0).all(axis=1)], axis=0)
    graph = coo_matrix((np.ones(len(pairs)), (pairs[:, 0], pairs[:, 1])), shape=(count + 1, count + 1))
    # region 0, what is not free, is nobody's neighbour and keeps a number of its own
    _, number_of = connected_components(graph, directed=False)
    joined: NDArray[np.int32] = np.where(free, number_of[regions] + 1, 0).astype(np.int32)
    return joined
