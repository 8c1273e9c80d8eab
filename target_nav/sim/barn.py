"""The worlds of the Benchmark Autonomous Robot Navigation set (BARN) as arenas.

A world is a field of upright cylinders between three walls of cylinders; the robot goes 10 m through it to the open
end. Data are read from a folder that is not part of the project. Two robots: the set's own, a Clearpath Jackal, at the
set's scale; and any other, with the world scaled by that robot's circumscribed radius over the Jackal's.

Perille, Truong, Xiao, Stone: Benchmarking Metric Ground Navigation (SSRR 2020). Score: Xiao et al., Autonomous Ground
Navigation in Highly Constrained Spaces, with the clipping used since 2024.
"""

from __future__ import annotations

import csv
import gzip
import math
from collections import defaultdict
from collections.abc import Iterator
from dataclasses import dataclass, replace
from functools import lru_cache
from pathlib import Path

from target_nav.config import Config
from target_nav.errors import ConfigError
from target_nav.sim.arena_types import Arena, Bounds, CircleObstacle, Goal, config_for_goal
from target_nav.state.types import Pose2D

CYLINDERS, SUMMARY = "barn_cylinders.csv.gz", "barn_summary.csv"
CYLINDER_RADIUS_M = 0.075
START = Pose2D(-2.25, 3.0, 0.5 * math.pi)
GOAL = Goal(-2.25, 13.0, 1.0)
SET_RADIUS_M = 0.333
"""Circumscribed radius of the robot that the worlds were made for."""
TIME_LIMIT_S = 100.0
"""The set's own."""
BEST_SHARE, LEAST_SHARE = 2.0, 8.0
"""A run is worth 1 / 2 at most (twice the optimal time, or faster) and 1 / 8 at least, if it succeeds."""
AIM_SHARE = 0.3
"""Of the goal's radius: what the robot aims at."""
BEYOND_M = 2.5
"""The room goes on so far round the outermost cylinder and the goal."""

JACKAL = {
    "robot.drive": "differential",
    "robot.front_m": 0.254,
    "robot.rear_m": 0.254,
    "robot.half_width_m": 0.215,
    "robot.max_speed_mps": 2.0,
    "robot.max_yaw_rate_radps": 4.0,
    "robot.max_accel_mps2": 3.0,
    "robot.max_decel_mps2": 3.0,
    "robot.max_yaw_accel_radps2": 8.0,
    "lidar.beams": 720,
    "lidar.fov_rad": 1.5 * math.pi,
    "lidar.rate_hz": 40.0,
    "lidar.range_min_m": 0.1,
    "lidar.range_max_m": 30.0,
    "lidar.noise_scale": 0.3,
    "lidar.dropout_scale": 0.0,
    "lidar.lost_scan_probability": 0.0,
    "drive_sim.heading_drift_rad_per_m": 0.002,
    "drive_sim.slip_heading_rad": 0.005,
    "avoid.look_ahead_m": 4.0,
    "avoid.memory_radius_m": 6.0,
    "avoid.slow_clearance_m": 0.6,
    "approach.cruise_speed_mps": 1.5,
}
"""The set's robot. Its controller allows 20 m/s^2 and 25 rad/s^2, which no tyre does: 3 and 8 are taken.
Its LiDAR is a Hokuyo: 270 degrees, 720 beams, 40 Hz, no drop-outs; noise 30 % of the RPLidar's that `sim` has.
Its heading comes from a gyroscope as well as from its wheels, so it drifts less than the reference robot's."""

OWN = {"approach.cruise_speed_mps": 0.3}
"""The reference robot at its top speed."""

ROBOTS: dict[str, dict[str, object]] = {"jackal": dict(JACKAL), "own": dict(OWN)}
PREFIX = "barn"


@dataclass(frozen=True)
class BarnWorld:
    """At the set's scale. `path_m` is the length of the set's reference path, start and goal included."""

    index: int
    cylinders_m: tuple[tuple[float, float], ...]
    path_m: float


def read_barn(folder: Path) -> list[BarnWorld]:
    """All worlds of a folder, by index.

    Raises:
        ConfigError: a file is missing, or something in it is no number.
    """
    cylinders: dict[int, list[tuple[float, float]]] = defaultdict(list)
    paths: dict[int, float] = {}
    path = folder
    try:
        path = folder / CYLINDERS
        for row in _rows(path):
            cylinders[int(row["world"])].append((float(row["x"]), float(row["y"])))
        path = folder / SUMMARY
        for row in _rows(path):
            paths[int(row["world"])] = float(row["ref_path_len_m"])
    except OSError as error:
        raise ConfigError(
            f"{path}: {error.strerror or error}; the folder must hold {CYLINDERS} and {SUMMARY}"
        ) from error
    except (KeyError, ValueError, TypeError) as error:
        raise ConfigError(f"{path}: not the set's numbers ({error}); see the set's README") from error
    missing = sorted(set(paths) ^ set(cylinders))
    if missing or not paths:
        raise ConfigError(f"{folder}: worlds {missing[:5]} are in one of {CYLINDERS} and {SUMMARY} only")
    return [BarnWorld(index, tuple(cylinders[index]), paths[index]) for index in sorted(paths)]


def _rows(path: Path) -> Iterator[dict[str, str]]:
    opener = gzip.open if path.suffix == ".gz" else open
    with opener(path, "rt", encoding="utf-8") as lines:
        # the names of the columns may stand in a comment
        yield from _named(line for line in lines)


def _named(lines: Iterator[str]) -> Iterator[dict[str, str]]:
    names: list[str] | None = None
    for cells in csv.reader(line for line in lines if not line.startswith("#")):
        if cells and not _is_number(cells[0]):
            names = cells
            continue
        yield dict(zip(names or ["world", "x", "y"], cells))


def _is_number(text: str) -> bool:
    try:
        float(text)
    except ValueError:
        return False
    return True


def barn_arena(world: BarnWorld, config: Config, scale: float = 1.0) -> Arena:
    """`scale` times the set's size. `config` is the robot; for the set's own `Config().override(JACKAL)`."""
    robot = Pose2D(scale * START.x_m, scale * START.y_m, START.yaw_rad)
    goal = Goal(scale * GOAL.x_m, scale * GOAL.y_m, scale * GOAL.radius_m)
    xs = [x for x, _ in world.cylinders_m] + [START.x_m, GOAL.x_m]
    ys = [y for _, y in world.cylinders_m] + [START.y_m, GOAL.y_m]
    return Arena(
        name=f"barn_{world.index}",
        bounds=Bounds(
            scale * (min(xs) - BEYOND_M),
            scale * (min(ys) - BEYOND_M),
            scale * (max(xs) + BEYOND_M),
            scale * (max(ys) + BEYOND_M),
        ),
        robot=robot,
        goal=goal,
        obstacles=tuple(
            CircleObstacle(scale * x, scale * y, scale * CYLINDER_RADIUS_M) for x, y in world.cylinders_m
        ),
        # the set's clock stops at the radius, and nothing is gained by standing right behind it
        config=config_for_goal(config, robot, goal).override({"goal.within_m": AIM_SHARE * goal.radius_m}),
        time_limit_s=TIME_LIMIT_S * scale * 2.0 / config.robot.max_speed_mps,
        kind="barn",
    )


def scale_for(config: Config) -> float:
    """How large the worlds are for this robot; 1 for the set's own."""
    if math.isclose(config.robot.circumscribed_radius_m, SET_RADIUS_M, abs_tol=0.001):
        return 1.0
    return config.robot.circumscribed_radius_m / SET_RADIUS_M


@dataclass(frozen=True)
class BarnName:
    """`barn:<robot>:<index>:<folder>`: one world for one robot, the set's own (`jackal`) or ours (`own`)."""

    robot: str
    index: int
    folder: Path

    def __str__(self) -> str:
        return f"{PREFIX}:{self.robot}:{self.index}:{self.folder}"

    @classmethod
    def parse(cls, text: str) -> BarnName | None:
        parts = text.split(":", 3)
        if len(parts) != 4 or parts[0] != PREFIX or parts[1] not in ROBOTS or not parts[2].isdigit():
            return None
        return cls(parts[1], int(parts[2]), Path(parts[3]))

    def robot_config(self) -> Config:
        return Config().override(ROBOTS[self.robot], source=self.robot)

    def world(self) -> BarnWorld:
        """
        Raises:
            ConfigError: the folder has no such world.
        """
        worlds = _read_once(self.folder)
        if self.index not in worlds:
            known = ", ".join(map(str, list(worlds)[:8]))
            raise ConfigError(f"{self.folder} has no world {self.index}; it has {known}, ...")
        return worlds[self.index]


@lru_cache(maxsize=2)
def _read_once(folder: Path) -> dict[int, BarnWorld]:
    return {world.index: world for world in read_barn(folder)}


def named_barn_arena(name: BarnName) -> Arena:
    config = name.robot_config()
    return replace(
        barn_arena(name.world(), config, scale_for(config)), name=f"barn_{name.robot}_{name.index}"
    )


def optimal_time_s(name: BarnName) -> float:
    """The reference path at the robot's top speed."""
    config = name.robot_config()
    return name.world().path_m * scale_for(config) / config.robot.max_speed_mps


def barn_score(time_s: float | None, optimal_s: float) -> float:
    """OT / clip(AT, 2 OT, 8 OT), for a run that reached the goal in `time_s`; 0 for one that did not."""
    if time_s is None:
        return 0.0
    return optimal_s / min(max(time_s, BEST_SHARE * optimal_s), LEAST_SHARE * optimal_s)
