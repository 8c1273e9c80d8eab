"""An arena as the YAML that the loader reads back to the very same arena."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import yaml

from target_nav.config import Config
from target_nav.sim.arena_types import Arena, BoxObstacle, CircleObstacle, Obstacle, PlacedObject


def arena_text(arena: Arena, config: Config) -> str:
    """`config` is what the reader will apply the profile to: only what differs from it is written."""
    robot = arena.robot
    data: dict[str, Any] = {
        "name": arena.name,
        "bounds": list(arena.bounds),
        "robot": {"x": robot.x_m, "y": robot.y_m, "yaw": robot.yaw_rad},
    }
    if arena.target is not None:
        data["target"] = _thing(arena.target)
    if arena.goal is not None:
        data["goal"] = {"x": arena.goal.x_m, "y": arena.goal.y_m, "radius": arena.goal.radius_m}
    data["obstacles"] = [_obstacle(obstacle) for obstacle in arena.obstacles]
    data["decoys"] = [_thing(decoy) for decoy in arena.decoys]
    usual = {key: value for key, value, _ in config.items()}
    # where to go is said by the goal itself
    data["profile"] = {
        key: value
        for key, value, _ in arena.config.items()
        if value != usual[key] and not (arena.goal is not None and key.startswith("goal."))
    }
    data["time_limit_s"] = arena.time_limit_s
    data["expect"] = arena.expect
    if arena.kind:
        data["kind"] = arena.kind
    if arena.level:
        data["level"] = arena.level
    kept = {key: value for key, value in data.items() if value not in ([], {})}
    text: str = yaml.safe_dump(kept, sort_keys=False, default_flow_style=None, width=110)
    return text


def write_arena(arena: Arena, folder: Path, config: Config) -> Path:
    """A file of the arena's name."""
    path = folder / f"{arena.name}.yaml"
    path.write_text(arena_text(arena, config), encoding="utf-8")
    return path


def _thing(thing: PlacedObject) -> dict[str, Any]:
    data: dict[str, Any] = {"class": thing.class_name, "x": thing.x_m, "y": thing.y_m}
    if thing.is_tag:
        data["yaw"] = thing.yaw_rad
    if thing.velocity_mps != (0.0, 0.0):
        data["velocity_mps"] = list(thing.velocity_mps)
        if math.isfinite(thing.moves_s):
            data["moves_s"] = thing.moves_s
    return data


def _obstacle(obstacle: Obstacle) -> dict[str, list[float]]:
    if isinstance(obstacle, CircleObstacle):
        return {"circle": [obstacle.x_m, obstacle.y_m, obstacle.radius_m]}
    if isinstance(obstacle, BoxObstacle):
        size = [obstacle.length_m, obstacle.width_m, obstacle.yaw_rad]
        return {"box": [obstacle.x_m, obstacle.y_m, *size]}
    return {"wall": [obstacle.x1_m, obstacle.y1_m, obstacle.x2_m, obstacle.y2_m]}
