"""What an arena is: where walls, obstacles and things are, where the robot starts, how the run should end."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import NamedTuple

from target_nav.config import Config
from target_nav.sim.objects import ObjectShape, is_tag, shape_of
from target_nav.state.types import Pose2D
from target_nav.utils.frames import to_child

ARRIVED = "arrived"
NOT_FOUND = "not_found"
ENDINGS = (ARRIVED, NOT_FOUND)

AIM_SHARE = 0.4
LEAST_WITHIN_M, MOST_WITHIN_M = 0.03, 5.0
"""What the configuration allows for `goal.within_m`."""


class Bounds(NamedTuple):
    """Four walls round everything."""

    x_min_m: float
    y_min_m: float
    x_max_m: float
    y_max_m: float


@dataclass(frozen=True)
class CircleObstacle:
    x_m: float
    y_m: float
    radius_m: float


@dataclass(frozen=True)
class BoxObstacle:
    """`yaw_rad` turns the length away from the x axis."""

    x_m: float
    y_m: float
    length_m: float
    width_m: float
    yaw_rad: float


@dataclass(frozen=True)
class WallObstacle:
    x1_m: float
    y1_m: float
    x2_m: float
    y2_m: float


Obstacle = CircleObstacle | BoxObstacle | WallObstacle


@dataclass(frozen=True)
class PlacedObject:
    """A target or a decoy. A target may move from there, at `velocity_mps` in the arena's axes, for `moves_s`."""

    class_name: str
    x_m: float
    y_m: float
    yaw_rad: float = 0.0
    """Of a tag, where its face looks; everything else is round."""
    velocity_mps: tuple[float, float] = (0.0, 0.0)
    moves_s: float = math.inf

    @property
    def shape(self) -> ObjectShape:
        return shape_of(self.class_name)

    @property
    def is_tag(self) -> bool:
        return is_tag(self.class_name)


@dataclass(frozen=True)
class Goal:
    """A place to go to: reached when base_link is within the radius."""

    x_m: float
    y_m: float
    radius_m: float


def config_for_goal(config: Config, robot: Pose2D, goal: Goal) -> Config:
    """The configuration with the goal as the robot is told it: in odom, which begins where the robot stands.

    It aims at a smaller circle than the one that counts: the rest is for what its odometry gets wrong.
    """
    x_m, y_m = to_child(robot, goal.x_m, goal.y_m)
    within_m = min(max(AIM_SHARE * goal.radius_m, LEAST_WITHIN_M), MOST_WITHIN_M)
    return config.override({"goal.x_m": x_m, "goal.y_m": y_m, "goal.within_m": within_m}, source="goal")


@dataclass(frozen=True)
class Arena:
    """`config` is the configuration with the arena's `profile` applied. `expect` is how a right mission ends here."""

    name: str
    bounds: Bounds
    robot: Pose2D
    target: PlacedObject | None = None
    goal: Goal | None = None
    obstacles: tuple[Obstacle, ...] = ()
    decoys: tuple[PlacedObject, ...] = ()
    config: Config = field(default_factory=Config)
    time_limit_s: float = 120.0
    expect: str = ARRIVED
    kind: str = ""
    """What it is an example of, and how hard it is from 1 on: campaigns count by these. Empty and 0: by its name."""
    level: int = 0

    @property
    def objects(self) -> tuple[PlacedObject, ...]:
        """All things that stand on the floor, the target (if there is one) first."""
        return ((self.target,) if self.target is not None else ()) + self.decoys
