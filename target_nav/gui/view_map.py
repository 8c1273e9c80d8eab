"""The odometry frame from above: the way driven, where the robot stands, where the target is believed to be."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from target_nav.gui.geometry import Ellipse, ellipse_of
from target_nav.gui.source import World
from target_nav.state.types import FloatArray, Pose2D
from target_nav.utils.frames import points_to_parent

STEP_M = 0.04
"""Two points of the path are at least so far apart."""
MOST_POINTS = 2000
_JUMP_M = 0.5
"""Farther than a robot drives between two looks: odometry was reset, or another run has begun."""


@dataclass(frozen=True, eq=False)
class MapView:
    """Everything in odom. `path_m`, shape (N, 2), ends where the robot is; bounds hold all of it and some margin."""

    path_m: FloatArray
    driven_m: float
    pose: Pose2D
    target: Ellipse | None
    obstacles_m: FloatArray
    x_min_m: float
    y_min_m: float
    x_max_m: float
    y_max_m: float
    fresh: bool
    message: str


class MapModel:
    """Keeps the path. Its memory is bounded: a long path loses every second of its points."""

    def __init__(self) -> None:
        self.clear()

    def clear(self) -> None:
        self._path: list[tuple[float, float]] = []
        self._step_m = STEP_M
        self._driven_m = 0.0
        self._last: tuple[float, float] | None = None

    def view(self, world: World) -> MapView:
        nav = world.nav.value
        pose = nav.pose_in_odom if nav is not None else Pose2D()
        if nav is not None and world.nav.fresh and pose.is_finite():
            self._add(pose.x_m, pose.y_m)
        avoid = world.avoid.value
        obstacles: FloatArray = np.empty((0, 2))
        if avoid is not None and world.avoid.fresh:
            obstacles = points_to_parent(avoid.pose_in_odom, avoid.obstacles_in_base_m)
        path = np.array([*self._path, (pose.x_m, pose.y_m)])
        target = ellipse_of(nav.track) if nav is not None and nav.track is not None else None
        shown = path if target is None else np.vstack((path, [[target.x_m, target.y_m]]))
        low, high = shown.min(axis=0) - 0.6, shown.max(axis=0) + 0.6
        return MapView(
            path_m=path,
            driven_m=self._driven_m,
            pose=pose,
            target=target,
            obstacles_m=obstacles,
            x_min_m=float(low[0]),
            y_min_m=float(low[1]),
            x_max_m=float(high[0]),
            y_max_m=float(high[1]),
            fresh=world.nav.fresh,
            message=world.nav.excuse,
        )

    def _add(self, x_m: float, y_m: float) -> None:
        if self._last is not None:
            step_m = math.dist(self._last, (x_m, y_m))
            if step_m > _JUMP_M:
                self.clear()
            else:
                self._driven_m += step_m
        self._last = (x_m, y_m)
        if self._path and math.dist(self._path[-1], (x_m, y_m)) < self._step_m:
            return
        self._path.append((x_m, y_m))
        if len(self._path) > MOST_POINTS:
            self._path = self._path[::2]
            self._step_m *= 2.0
