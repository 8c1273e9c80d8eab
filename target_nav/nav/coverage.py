"""Which of the floor the camera has looked at, and how much more it would see from somewhere else.

A coarse grid in odom round the place where a search began. Obstacle points block the line of sight; what the
camera's field of view has swept, near enough and unblocked, often enough, counts as seen. This tells a search where to
go next and which way to look, in place of driving and turning by rote.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from target_nav.config import CameraConfig
from target_nav.nav.sight_lines import nearest_by_direction_m
from target_nav.state.types import FloatArray, Pose2D

_CELL_M = 0.1
_HALF = 120
_SIDE = 2 * _HALF + 1
_LOOKS = 3
"""So many updates must have a cell in view before it counts as seen: one frame may miss the target."""
_EDGE_RAD = math.radians(4.0)
"""Left out at either side of the picture: a target there is cut off."""
_NEAREST_M = 0.3
_VIEW_RAY_RAD = 0.02
_RAY_STEP_M = 0.08
"""Together finer than a cell everywhere in range: else some cells in sight would never be hit."""
_GAIN_STEP_M = 0.1
_GAIN_RAYS = 72
_KNOWN_RAYS = 180
_BEHIND_M = (0.1, 0.6)
_UNKNOWN_STEPS = 10
"""Of a ray through floor that is not known to be floor, so many steps count: 1 m."""


class Coverage:
    def __init__(self, camera: CameraConfig, range_m: float) -> None:
        """`range_m`: how far off the target is surely found."""
        self._half_fov_rad = max(camera.half_fov_rad - _EDGE_RAD, 0.05)
        self._camera_yaw_rad = camera.yaw_rad
        self._range_m = range_m
        count = max(round(2.0 * self._half_fov_rad / _VIEW_RAY_RAD), 2)
        self._view_angles: FloatArray = np.linspace(-self._half_fov_rad, self._half_fov_rad, count)
        self.ray_angles_rad: FloatArray = np.linspace(-math.pi, math.pi, _GAIN_RAYS, endpoint=False)
        """Directions in odom that `unseen_by_ray_m2` answers for."""
        self._all_round: FloatArray = np.linspace(-math.pi, math.pi, _KNOWN_RAYS, endpoint=False)
        self.begin(Pose2D())

    def begin(self, pose_in_odom: Pose2D) -> None:
        """Forget all; the grid lies round this pose."""
        self._origin = np.array([pose_in_odom.x_m, pose_in_odom.y_m])
        self._blocked = np.zeros((_SIDE, _SIDE), dtype=np.bool_)
        self._shade = np.zeros((_SIDE, _SIDE), dtype=np.bool_)
        self._looks = np.zeros((_SIDE, _SIDE), dtype=np.uint8)
        self._known = np.zeros((_SIDE, _SIDE), dtype=np.bool_)
        self._missing: NDArray[np.bool_] | None = None
        self._reach_m = math.inf
        self._free_m: FloatArray = np.full(_KNOWN_RAYS, math.inf)

    @property
    def sure_m(self) -> float:
        """So far off something counts as seen: near enough for the camera, and for obstacles to be known."""
        return min(self._range_m, self._reach_m)

    @property
    def known_m2(self) -> float:
        """How much floor has been in the LiDAR's line of sight."""
        return float(np.count_nonzero(self._known)) * _CELL_M**2

    @property
    def unseen_m2(self) -> float:
        """How much of the grid has not been looked at."""
        return float(np.count_nonzero(self._looks < _LOOKS)) * _CELL_M**2

    def look_again(self, range_m: float) -> None:
        """Everything counts as unseen again, and the target as found only within `range_m`."""
        self._looks[:] = 0
        self._missing = None
        self._range_m = range_m

    def update(self, pose_in_odom: Pose2D, points_in_odom_m: FloatArray, reach_m: float) -> None:
        """Take in the obstacles that are known by now, and what the camera sees from here; a few times a second.

        Beyond `reach_m` obstacles are not known, so nothing there counts as seen or as free.
        """
        self._block(points_in_odom_m)
        self._reach_m = reach_m
        angles = self._view_angles + pose_in_odom.yaw_rad + self._camera_yaw_rad
        free_m = _free_by_ray_m(pose_in_odom, points_in_odom_m)
        rows, columns = self._in_sight(pose_in_odom, angles, _RAY_STEP_M, self.sure_m, free_m)
        self._looks[rows, columns] = np.minimum(self._looks[rows, columns] + 1, _LOOKS)
        self._missing = None
        # A little less than is in sight: between two returns of a wall seen at a slant there is no way through.
        self._doubt_behind(pose_in_odom, reach_m, free_m)
        beside_m = np.minimum(free_m, np.minimum(np.roll(free_m, 1), np.roll(free_m, -1)))
        rows, columns = self._in_sight(pose_in_odom, self._all_round, _GAIN_STEP_M, reach_m, beside_m)
        self._known[rows, columns] = True
        self._free_m = free_m

    def settle(self, pose_in_odom: Pose2D) -> None:
        """Everything in sight from here counts as seen: it was looked round as far as it was worth it.

        Obstacles are those of the last `update`.
        """
        all_round = np.arange(-math.pi, math.pi, _VIEW_RAY_RAD)
        rows, columns = self._in_sight(pose_in_odom, all_round, _RAY_STEP_M, self.sure_m, self._free_m)
        self._looks[rows, columns] = _LOOKS
        self._missing = None

    def is_known_free(self, spots_m: FloatArray) -> NDArray[np.bool_]:
        """Which spots, shape (K, 2), have been in the LiDAR's line of sight and are not blocked."""
        rows, columns = self._cells(spots_m)
        free: NDArray[np.bool_] = self._known[rows, columns] & ~self._shade[rows, columns]
        return free

    def unseen_by_ray_m2(self, spots_m: FloatArray, *, crumbs: bool = False) -> FloatArray:
        """Unseen area that would be seen from each spot, by direction, shape (K, rays). `spots_m` is (K, 2).

        Of floor that the LiDAR has not been through either, a little counts: it may as well be a wall's inside.
        Single cells do not count without `crumbs`: along walls some are left over everywhere, and together they would
        outweigh what lies behind the next corner. They are worth a look, not a way.
        """
        rows, columns, sees = self._rays(spots_m, self.ray_angles_rad, _GAIN_STEP_M, self.sure_m)
        sees &= np.cumsum(~self._known[rows, columns], axis=2, dtype=np.int16) <= _UNKNOWN_STEPS
        if crumbs:
            unseen = sees & (self._looks[rows, columns] < _LOOKS)
        else:
            if self._missing is None:
                self._missing = _without_crumbs(self._looks < _LOOKS)
            unseen = sees & self._missing[rows, columns]
        radius = _NEAREST_M + np.arange(rows.shape[2]) * _GAIN_STEP_M
        area: FloatArray = (unseen * radius).sum(axis=2) * (_GAIN_STEP_M * 2.0 * math.pi / _GAIN_RAYS)
        return area

    def _doubt_behind(self, pose_in_odom: Pose2D, reach_m: float, free_m: FloatArray) -> None:
        """What lies just behind a wall in sight is not known to be floor, even if it once was.

        Drift moves walls; floor before a wall's old place would be floor inside of it, and worth a way.
        Of a room behind a thin wall this takes a strip, until it is seen again from there.
        """
        here = np.array([[pose_in_odom.x_m, pose_in_odom.y_m]])
        rows, columns, _ = self._rays(here, self._all_round, _GAIN_STEP_M, reach_m + _BEHIND_M[1])
        radius = _NEAREST_M + np.arange(rows.shape[2]) * _GAIN_STEP_M
        behind = (radius > free_m[:, None] + _BEHIND_M[0]) & (radius < free_m[:, None] + _BEHIND_M[1])
        self._known[rows[0][behind], columns[0][behind]] = False

    def _block(self, points_m: FloatArray) -> None:
        self._blocked[:] = False
        if len(points_m):
            rows, columns = self._cells(points_m)
            self._blocked[rows, columns] = True
        shade = self._blocked.copy()
        # Walls are seen as single points, and a ray slips between two cells that touch at a corner: two by two cells
        # close such gaps. More would hide the very shadows that a search is for.
        shade[1:] |= self._blocked[:-1]
        shade[:, 1:] |= shade[:, :-1].copy()
        self._shade = shade

    def _rays(
        self, spots_m: FloatArray, angles_rad: FloatArray, step_m: float, range_m: float
    ) -> tuple[NDArray[np.intp], NDArray[np.intp], NDArray[np.bool_]]:
        """Rows and columns of samples along rays from each spot, shape (K, rays, steps), and which are in sight."""
        radius = np.arange(_NEAREST_M, max(range_m, 2.0 * _NEAREST_M), step_m)
        along = np.multiply.outer(np.column_stack([np.cos(angles_rad), np.sin(angles_rad)]), radius)
        offsets = (spots_m - self._origin) / _CELL_M + _HALF
        x = offsets[:, 0, None, None] + along[:, 0] / _CELL_M
        y = offsets[:, 1, None, None] + along[:, 1] / _CELL_M
        columns = np.clip(np.rint(x), 0, _SIDE - 1).astype(np.intp)
        rows = np.clip(np.rint(y), 0, _SIDE - 1).astype(np.intp)
        sees = ~np.logical_or.accumulate(self._shade[rows, columns], axis=2)
        inside = (x >= 0.0) & (x <= _SIDE - 1) & (y >= 0.0) & (y <= _SIDE - 1)
        return rows, columns, sees & inside

    def _in_sight(
        self, pose_in_odom: Pose2D, angles_rad: FloatArray, step_m: float, range_m: float, free_m: FloatArray
    ) -> tuple[NDArray[np.intp], NDArray[np.intp]]:
        """Rows and columns of the cells in sight along rays from where the robot is; `free_m` by `_ray_of`."""
        here = np.array([[pose_in_odom.x_m, pose_in_odom.y_m]])
        rows, columns, sees = self._rays(here, angles_rad, step_m, range_m)
        radius = _NEAREST_M + np.arange(rows.shape[2]) * step_m
        sees[0] &= radius < free_m[_ray_of(angles_rad), None]
        return rows[sees], columns[sees]

    def _cells(self, points_m: FloatArray) -> tuple[NDArray[np.intp], NDArray[np.intp]]:
        index = np.clip(np.rint((points_m - self._origin) / _CELL_M) + _HALF, 0, _SIDE - 1).astype(np.intp)
        return index[:, 1], index[:, 0]


def _without_crumbs(cells: NDArray[np.bool_]) -> NDArray[np.bool_]:
    """Only what holds two by two cells: a morphological opening."""
    square = cells[1:, 1:] & cells[:-1, 1:] & cells[1:, :-1] & cells[:-1, :-1]
    kept: NDArray[np.bool_] = np.zeros_like(cells)
    for down in (slice(1, None), slice(None, -1)):
        for across in (slice(1, None), slice(None, -1)):
            kept[down, across] |= square
    return kept


def _ray_of(angles_rad: FloatArray) -> NDArray[np.intp]:
    """Index of the nearest of `_KNOWN_RAYS` directions all round; 0 is at -pi."""
    ray: NDArray[np.intp] = np.rint((angles_rad + math.pi) * (_KNOWN_RAYS / (2.0 * math.pi))).astype(np.intp)
    return ray % _KNOWN_RAYS


def _free_by_ray_m(pose_in_odom: Pose2D, points_in_odom_m: FloatArray) -> FloatArray:
    """How far off the nearest obstacle is by direction, shape (_KNOWN_RAYS,); infinite where there is none.

    Unlike cells, directions as seen from here have no holes: a wall at a slant is a point a beam.
    """
    dx, dy = points_in_odom_m[:, 0] - pose_in_odom.x_m, points_in_odom_m[:, 1] - pose_in_odom.y_m
    return nearest_by_direction_m(dx, dy, _KNOWN_RAYS)
