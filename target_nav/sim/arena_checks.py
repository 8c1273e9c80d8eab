"""What is wrong with an arena's geometry: things that are in each other, outside of the walls, or of no size."""

from __future__ import annotations

import math
from collections.abc import Iterator

from target_nav.config import Config, RobotConfig
from target_nav.sim.arena_types import (
    Arena,
    Bounds,
    BoxObstacle,
    CircleObstacle,
    Obstacle,
    PlacedObject,
)
from target_nav.sim.geometry import (
    box_corners,
    point_to_rectangle,
    point_to_segment,
    segment_to_rectangle,
)
from target_nav.sim.objects import OBSTACLE_HEIGHT_M
from target_nav.state.types import Pose2D
from target_nav.utils.frames import to_child

MIN_SIZE_M = 0.5
"""Smaller bounds than this hold no robot that could go anywhere."""

HANGS_M = 0.01
"""A tag is so near to what it hangs on."""

Problem = tuple[str, str]
"""Where (`robot`, `obstacles[2]`) and what."""


def geometry_problems(arena: Arena) -> Iterator[Problem]:
    """Everything that is wrong with the places of things. Empty: the arena can be run."""
    bounds = arena.bounds
    width_m, height_m = bounds.x_max_m - bounds.x_min_m, bounds.y_max_m - bounds.y_min_m
    if min(width_m, height_m) < MIN_SIZE_M:
        yield (
            "bounds",
            (
                f"bounds are {width_m:g} by {height_m:g} m; x_max must be over x_min and y_max over y_min "
                f"by at least {MIN_SIZE_M:g} m"
            ),
        )
        return
    for i, obstacle in enumerate(arena.obstacles):
        if not _overlaps(bounds, obstacle):
            yield (
                f"obstacles[{i}]",
                f"obstacles[{i}] lies outside of the bounds {_show(bounds)}; move it or drop it",
            )
    yield from _robot_problems(arena)
    if arena.target is not None:
        yield from _object_problems(arena, "target", arena.target)
    for i, decoy in enumerate(arena.decoys):
        yield from _object_problems(arena, f"decoys[{i}]", decoy)
    if arena.goal is not None:
        where = f"goal at ({arena.goal.x_m:g}, {arena.goal.y_m:g})"
        yield from _place_problems(arena, "goal", where, arena.goal.x_m, arena.goal.y_m, 0.0)
    yield from _config_problems(arena.config)


def _robot_problems(arena: Arena) -> Iterator[Problem]:
    pose, body = arena.robot, arena.config.robot
    where = f"robot at ({pose.x_m:g}, {pose.y_m:g})"
    if not all(_inside(arena.bounds, x, y, 0.0) for x, y in _footprint(pose, body)):
        yield (
            "robot",
            (
                f"{where}: its footprint ({body.front_m + body.rear_m:g} by {2 * body.half_width_m:g} m) reaches "
                f"outside of the bounds {_show(arena.bounds)}; move it in"
            ),
        )
    for i, obstacle in enumerate(arena.obstacles):
        if footprint_clearance(pose, body, obstacle) <= 0.0:
            yield "robot", f"{where}: its footprint touches obstacles[{i}]; move one of them"
    for name, thing in _named_objects(arena):
        if footprint_clearance(pose, body, _as_circle(thing)) <= 0.0:
            yield "robot", f"{where}: its footprint touches {name}; move one of them"


def _object_problems(arena: Arena, place: str, thing: PlacedObject) -> Iterator[Problem]:
    where = f"{place} ({thing.class_name}) at ({thing.x_m:g}, {thing.y_m:g})"
    yield from _place_problems(arena, place, where, thing.x_m, thing.y_m, thing.shape.radius_m)
    if thing.is_tag and not _hangs(arena, thing):
        yield place, f"{where} hangs on nothing; put it within {HANGS_M:g} m of a wall, a box or the bounds"
    for name, other in _named_objects(arena):
        if other is thing:
            break
        gap_m = math.hypot(other.x_m - thing.x_m, other.y_m - thing.y_m)
        if gap_m < other.shape.radius_m + thing.shape.radius_m:
            yield place, f"{where} stands in {name}; move one of them"


def _hangs(arena: Arena, tag: PlacedObject) -> bool:
    x0, y0, x1, y1 = arena.bounds
    gaps = [tag.x_m - x0, x1 - tag.x_m, tag.y_m - y0, y1 - tag.y_m]
    gaps += [point_clearance(tag.x_m, tag.y_m, obstacle) for obstacle in arena.obstacles]
    return min(gaps) <= HANGS_M


def _place_problems(
    arena: Arena, place: str, where: str, x_m: float, y_m: float, radius_m: float
) -> Iterator[Problem]:
    if not _inside(arena.bounds, x_m, y_m, radius_m):
        yield place, f"{where} lies outside of the bounds {_show(arena.bounds)}; move it in"
    for i, obstacle in enumerate(arena.obstacles):
        if point_clearance(x_m, y_m, obstacle) < radius_m or point_clearance(x_m, y_m, obstacle) == 0.0:
            yield place, f"{where} stands in obstacles[{i}]; move one of them"


def _config_problems(config: Config) -> Iterator[Problem]:
    lidar = config.lidar
    if lidar.range_min_m >= lidar.range_max_m:
        limit = f"it must be under lidar.range_max_m ({lidar.range_max_m:g} m)"
        yield "profile", f"lidar.range_min_m is {lidar.range_min_m:g} m; {limit}"
    for name, z_m in (("lidar.z_m", lidar.z_m), ("camera.z_m", config.camera.z_m)):
        if z_m >= OBSTACLE_HEIGHT_M:
            yield (
                "profile",
                f"{name} is {z_m:g} m; it must be under the obstacles' height, {OBSTACLE_HEIGHT_M:g} m",
            )


def footprint_clearance(pose: Pose2D, body: RobotConfig, obstacle: Obstacle) -> float:
    """From the footprint to an obstacle, m; 0 when they touch or one is in the other."""
    half_x, half_y = 0.5 * (body.front_m + body.rear_m), body.half_width_m
    shift = 0.5 * (body.front_m - body.rear_m)

    def in_body(x_m: float, y_m: float) -> tuple[float, float]:
        x, y = to_child(pose, x_m, y_m)
        return x - shift, y

    if isinstance(obstacle, CircleObstacle):
        gap = point_to_rectangle(*in_body(obstacle.x_m, obstacle.y_m), half_x, half_y)
        return max(gap - obstacle.radius_m, 0.0)
    if isinstance(obstacle, BoxObstacle) and point_clearance(pose.x_m, pose.y_m, obstacle) == 0.0:
        return 0.0
    return min(segment_to_rectangle(*in_body(*a), *in_body(*b), half_x, half_y) for a, b in edges(obstacle))


def point_clearance(x_m: float, y_m: float, obstacle: Obstacle) -> float:
    """From a point to an obstacle, m; 0 inside."""
    if isinstance(obstacle, CircleObstacle):
        return max(math.hypot(x_m - obstacle.x_m, y_m - obstacle.y_m) - obstacle.radius_m, 0.0)
    if isinstance(obstacle, BoxObstacle):
        u, v = to_child(Pose2D(obstacle.x_m, obstacle.y_m, obstacle.yaw_rad), x_m, y_m)
        return point_to_rectangle(u, v, 0.5 * obstacle.length_m, 0.5 * obstacle.width_m)
    return point_to_segment(x_m, y_m, obstacle.x1_m, obstacle.y1_m, obstacle.x2_m, obstacle.y2_m)


Point = tuple[float, float]


def edges(obstacle: Obstacle) -> list[tuple[Point, Point]]:
    """The segments an obstacle is made of; a circle has none."""
    if isinstance(obstacle, CircleObstacle):
        return []
    if isinstance(obstacle, BoxObstacle):
        corners = box_corners(
            obstacle.x_m, obstacle.y_m, obstacle.length_m, obstacle.width_m, obstacle.yaw_rad
        )
        return [(corners[i - 1], corners[i]) for i in range(4)]
    return [((obstacle.x1_m, obstacle.y1_m), (obstacle.x2_m, obstacle.y2_m))]


def _named_objects(arena: Arena) -> Iterator[tuple[str, PlacedObject]]:
    if arena.target is not None:
        yield f"the target ({arena.target.class_name})", arena.target
    for i, decoy in enumerate(arena.decoys):
        yield f"decoys[{i}] ({decoy.class_name})", decoy


def _as_circle(thing: PlacedObject) -> CircleObstacle:
    return CircleObstacle(thing.x_m, thing.y_m, thing.shape.radius_m)


def _footprint(pose: Pose2D, body: RobotConfig) -> tuple[Point, ...]:
    middle = 0.5 * (body.front_m - body.rear_m)
    return box_corners(
        pose.x_m + middle * math.cos(pose.yaw_rad),
        pose.y_m + middle * math.sin(pose.yaw_rad),
        body.front_m + body.rear_m,
        2.0 * body.half_width_m,
        pose.yaw_rad,
    )


def _inside(bounds: Bounds, x_m: float, y_m: float, radius_m: float) -> bool:
    return (
        bounds.x_min_m + radius_m <= x_m <= bounds.x_max_m - radius_m
        and bounds.y_min_m + radius_m <= y_m <= bounds.y_max_m - radius_m
    )


def _overlaps(bounds: Bounds, obstacle: Obstacle) -> bool:
    if isinstance(obstacle, CircleObstacle):
        r = obstacle.radius_m
        xs, ys = [obstacle.x_m - r, obstacle.x_m + r], [obstacle.y_m - r, obstacle.y_m + r]
    else:
        xs = [x for edge in edges(obstacle) for x, _ in edge]
        ys = [y for edge in edges(obstacle) for _, y in edge]
    return (
        min(xs) <= bounds.x_max_m
        and max(xs) >= bounds.x_min_m
        and min(ys) <= bounds.y_max_m
        and max(ys) >= bounds.y_min_m
    )


def _show(bounds: Bounds) -> str:
    return "[" + ", ".join(f"{value:g}" for value in bounds) + "]"
