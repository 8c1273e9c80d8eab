"""An arena on the drawing board: a room, and things put into it by chance."""

from __future__ import annotations

import math

import numpy as np

from target_nav.sim.arena_checks import point_clearance
from target_nav.sim.arena_types import BoxObstacle, CircleObstacle, Obstacle, PlacedObject, WallObstacle
from target_nav.state.types import Pose2D

PIN = "bowling_pin"
WALL_THICKNESS_M = 0.08
ROBOT_ROOM_M = 0.30
"""From the robot's middle to the nearest thing at the start: it can turn on the spot there."""
FACING_RAD = {1: 0.5, 2: 1.6, 3: math.pi, 4: math.pi}
"""How far off the target's direction the robot may look at the start."""
_TRIES = 60

Place = tuple[float, float]


def _mm(value: float) -> float:
    return round(float(value), 3)


class Draft:
    """The room is [-half_x, half_x] by [-half_y, half_y]. Everything is rounded to whole millimetres."""

    def __init__(self, rng: np.random.Generator, level: int, half_x_m: float, half_y_m: float) -> None:
        self.rng, self.level = rng, level
        self.half_x_m, self.half_y_m = half_x_m, half_y_m
        self.robot: Pose2D | None = None
        self.target: PlacedObject | None = None
        self.obstacles: list[Obstacle] = []
        self.decoys: list[PlacedObject] = []

    # -- chance --

    def between(self, low: float, high: float) -> float:
        return float(self.rng.uniform(low, high))

    def by_level(self, *ranges: tuple[float, float]) -> float:
        """Drawn from the range of this draft's level."""
        return self.between(*ranges[self.level - 1])

    def count(self, low: int, high: int) -> int:
        """Both included."""
        return int(self.rng.integers(low, high + 1))

    def chance(self, probability: float) -> bool:
        return bool(self.rng.random() < probability)

    def direction(self) -> float:
        return self.between(-math.pi, math.pi)

    # -- places --

    def clearance_m(self, x_m: float, y_m: float) -> float:
        """From a point to the nearest wall, obstacle or thing."""
        gaps = [self.half_x_m - abs(x_m), self.half_y_m - abs(y_m)]
        gaps += [point_clearance(x_m, y_m, obstacle) for obstacle in self.obstacles]
        things = self.decoys + ([self.target] if self.target is not None else [])
        gaps += [math.hypot(x_m - t.x_m, y_m - t.y_m) - t.shape.radius_m for t in things]
        if self.robot is not None:
            gaps.append(math.hypot(x_m - self.robot.x_m, y_m - self.robot.y_m) - ROBOT_ROOM_M)
        return min(gaps)

    def place(
        self,
        room_m: float,
        x_m: tuple[float, float] | None = None,
        y_m: tuple[float, float] | None = None,
        away_from: Place | None = None,
        away_m: tuple[float, float] = (0.0, math.inf),
    ) -> Place | None:
        """Somewhere with so much room round it; None when none of many tries found one."""
        xs, ys = x_m or (-self.half_x_m, self.half_x_m), y_m or (-self.half_y_m, self.half_y_m)
        for _ in range(_TRIES):
            x, y = _mm(self.between(*xs)), _mm(self.between(*ys))
            if away_from is not None:
                away = math.hypot(x - away_from[0], y - away_from[1])
                if not away_m[0] <= away <= away_m[1]:
                    continue
            if self.clearance_m(x, y) >= room_m:
                return x, y
        return None

    # -- things --

    def put_target(self, place: Place | None) -> bool:
        if place is None:
            return False
        self.target = PlacedObject(PIN, _mm(place[0]), _mm(place[1]))
        return True

    def put_robot(self, place: Place | None, look_at: Place | None = None) -> bool:
        """Looking at a place, or roughly so by level; anywhere without one."""
        if place is None:
            return False
        if look_at is None and self.target is not None:
            look_at = (self.target.x_m, self.target.y_m)
        yaw = self.direction()
        if look_at is not None:
            off = FACING_RAD[self.level]
            yaw = math.atan2(look_at[1] - place[1], look_at[0] - place[0]) + self.between(-off, off)
        self.robot = Pose2D(_mm(place[0]), _mm(place[1]), _mm(math.remainder(yaw, 2.0 * math.pi)))
        return True

    def put_box(self, x_m: float, y_m: float, length_m: float, width_m: float, yaw_rad: float = 0.0) -> None:
        self.obstacles.append(BoxObstacle(*(_mm(v) for v in (x_m, y_m, length_m, width_m, yaw_rad))))

    def put_wall(self, x1_m: float, y1_m: float, x2_m: float, y2_m: float) -> None:
        """A thin one, without thickness. Shorter than a centimetre: none."""
        if math.hypot(x2_m - x1_m, y2_m - y1_m) >= 0.01:
            self.obstacles.append(WallObstacle(*(_mm(v) for v in (x1_m, y1_m, x2_m, y2_m))))

    def put_partition(self, x_m: float, gaps: list[tuple[float, float]]) -> None:
        """A wall across the room at x, with gaps from y to y, ascending."""
        begin = -self.half_y_m
        for low, high in [*gaps, (self.half_y_m, self.half_y_m)]:
            if low - begin > 0.02:
                self.put_box(x_m, 0.5 * (begin + low), WALL_THICKNESS_M, low - begin)
            begin = high

    def scatter(self, count: int, size_m: tuple[float, float] = (0.12, 0.6), apart_m: float = 0.0) -> None:
        """Boxes and round things anywhere, none nearer than `apart_m` to another (or to the robot, or the target).

        Without room for one it is left out.
        """
        for _ in range(count):
            length, width = self.between(*size_m), self.between(*size_m)
            place = self.place(0.5 * math.hypot(length, width) + max(apart_m, 0.02))
            if place is None:
                continue
            if self.chance(0.4):
                self.obstacles.append(CircleObstacle(*place, _mm(0.5 * min(length, width))))
            else:
                self.put_box(*place, length, width, self.direction())

    def scatter_decoys(self, count: int, names: tuple[str, ...]) -> None:
        for _ in range(count):
            place = self.place(0.25)
            if place is not None:
                self.decoys.append(PlacedObject(names[self.count(0, len(names) - 1)], *place))
