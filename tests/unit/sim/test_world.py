"""Rays and clearances of whole arenas, against slow and plain geometry, and by symmetry."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from target_nav.config import Config
from target_nav.sim.arena import (
    Arena,
    Bounds,
    BoxObstacle,
    CircleObstacle,
    PlacedObject,
    WallObstacle,
    list_arenas,
    load_arena,
)
from target_nav.sim.arena_checks import footprint_clearance, point_clearance
from target_nav.sim.world import RayCaster, World
from target_nav.state.types import Pose2D

BOUNDS = Bounds(-3.0, -3.0, 3.0, 3.0)
PIN = PlacedObject("bowling_pin", 1.5, 0.4)

coordinate = st.floats(-2.6, 2.6)
obstacle = st.one_of(
    st.builds(CircleObstacle, coordinate, coordinate, st.floats(0.02, 0.5)),
    st.builds(
        BoxObstacle, coordinate, coordinate, st.floats(0.05, 1.0), st.floats(0.05, 1.0), st.floats(-3, 3)
    ),
    st.builds(
        lambda x, y, a: WallObstacle(x, y, x + math.cos(a), y + math.sin(a)),
        coordinate,
        coordinate,
        st.floats(-3, 3),
    ),
)
arenas = st.builds(
    lambda obstacles: Arena("any", BOUNDS, Pose2D(), target=PIN, obstacles=tuple(obstacles)),
    st.lists(obstacle, max_size=6),
)


def cast(world: World, x: float, y: float, angles: np.ndarray, height_m: float = 0.18) -> np.ndarray:
    start = np.full(len(angles), x), np.full(len(angles), y)
    return world.ray_caster(height_m).cast(*start, np.cos(angles), np.sin(angles))


def free_range(arena: Arena, x: float, y: float, angle: float) -> float:
    """Marches along the ray by the distance to the nearest surface (sphere tracing): no algebra in common."""
    pin = CircleObstacle(PIN.x_m, PIN.y_m, PIN.shape.radius_m)
    walked = 0.0
    for _ in range(2000):
        px, py = x + walked * math.cos(angle), y + walked * math.sin(angle)
        gap = min(
            px - BOUNDS.x_min_m, BOUNDS.x_max_m - px, py - BOUNDS.y_min_m, BOUNDS.y_max_m - py,
            *(point_clearance(px, py, o) for o in (*arena.obstacles, pin)),
        )  # fmt: skip
        if gap < 1e-6:
            break
        walked += gap
    return walked


@settings(max_examples=40, deadline=None)
@given(arenas, coordinate, coordinate, st.floats(-math.pi, math.pi))
def test_rays_end_where_marching_ends(arena, x, y, angle):
    if any(point_clearance(x, y, o) < 0.05 for o in arena.obstacles) or math.hypot(x - 1.5, y - 0.4) < 0.1:
        return
    angles = angle + np.linspace(0.0, 2.0 * math.pi, 7)
    for found, ray in zip(cast(World(arena), x, y, angles), angles):
        # A ray that grazes an edge may pass it by a hair in one and meet it in the other.
        marched = [free_range(arena, x, y, ray + turned) for turned in (-1e-3, 0.0, 1e-3)]
        assert min(marched) - 1e-3 <= found <= max(marched) + 1e-3


def test_a_thousand_scans_in_a_square_room_are_what_the_walls_say():
    world = World(Arena("square", BOUNDS, Pose2D()))
    rng = np.random.default_rng(5)
    x, y = rng.uniform(-2.9, 2.9, (2, 1000))
    angles = rng.uniform(-math.pi, math.pi, 1000)
    dx, dy = np.cos(angles), np.sin(angles)
    expected = np.minimum((np.where(dx > 0, 3.0, -3.0) - x) / dx, (np.where(dy > 0, 3.0, -3.0) - y) / dy)
    assert np.allclose(world.ray_caster(0.18).cast(x, y, dx, dy), expected)


@settings(max_examples=30, deadline=None)
@given(arenas, coordinate, coordinate)
def test_the_mirrored_world_gives_the_mirrored_scan(arena, x, y):
    flipped = tuple(
        CircleObstacle(o.x_m, -o.y_m, o.radius_m)
        if isinstance(o, CircleObstacle)
        else BoxObstacle(o.x_m, -o.y_m, o.length_m, o.width_m, -o.yaw_rad)
        if isinstance(o, BoxObstacle)
        else WallObstacle(o.x1_m, -o.y1_m, o.x2_m, -o.y2_m)
        for o in arena.obstacles
    )
    pin = PlacedObject("bowling_pin", PIN.x_m, -PIN.y_m)
    mirror = World(Arena("mirror", BOUNDS, Pose2D(), target=pin, obstacles=flipped))
    world = World(arena)
    angles = np.linspace(-3.0, 3.0, 61) + 0.0123
    differ = ~np.isclose(cast(world, x, y, angles), cast(mirror, x, -y, -angles), atol=1e-6)
    assert np.count_nonzero(differ) <= 1  # a ray that grazes a corner may fall to either side of it
    assert math.isclose(world.clearance_m(x, y, 0.7), mirror.clearance_m(x, -y, -0.7), abs_tol=1e-9)


@settings(max_examples=60, deadline=None)
@given(arenas, coordinate, coordinate, st.floats(-7.0, 7.0))
def test_clearance_is_the_least_over_all_parts(arena, x, y, yaw):
    body, pose = Config().robot, Pose2D(x, y, yaw)
    if any(point_clearance(x, y, o) == 0.0 for o in arena.obstacles if isinstance(o, BoxObstacle)):
        return  # a box round the robot's middle is no case for a robot that may never enter one
    pin = CircleObstacle(PIN.x_m, PIN.y_m, PIN.shape.radius_m)
    walls = [
        WallObstacle(-3, -3, 3, -3), WallObstacle(3, -3, 3, 3), WallObstacle(3, 3, -3, 3), WallObstacle(-3, 3, -3, -3)
    ]  # fmt: skip
    expected = min(footprint_clearance(pose, body, part) for part in (*arena.obstacles, pin, *walls))
    assert math.isclose(World(arena).clearance_m(x, y, yaw), expected, abs_tol=1e-9)


def test_a_ray_along_a_wall_does_not_stop_at_it():
    arena = Arena("wall", BOUNDS, Pose2D(), obstacles=(WallObstacle(1.0, 0.0, 2.0, 0.0),))
    assert np.allclose(cast(World(arena), 0.0, 0.0, np.array([0.0, math.pi])), 3.0)


def test_a_level_ray_passes_over_a_cup_and_meets_a_pin():
    things = (PlacedObject("cup", 1.0, 0.0), PlacedObject("bottle", -1.0, 0.0))
    world = World(Arena("things", BOUNDS, Pose2D(), decoys=things))
    assert np.allclose(cast(world, 0.0, 0.0, np.array([0.0, math.pi])), [3.0, 1.0 - 0.035])
    assert math.isclose(cast(world, 0.0, 0.0, np.array([0.0]), height_m=0.05)[0], 1.0 - 0.042)


def test_every_arena_starts_with_room_round_the_robot():
    for name in list_arenas():
        arena = load_arena(name)
        assert World(arena).clearance_m(arena.robot.x_m, arena.robot.y_m, arena.robot.yaw_rad) > 0.2


@pytest.mark.parametrize("seed", range(4))
def test_rays_sorted_by_direction_meet_the_same_circles_as_all_of_them_at_once(seed: int) -> None:
    rng = np.random.default_rng(seed)
    circles = np.column_stack([rng.uniform(-4.0, 4.0, (60, 2)), rng.uniform(0.02, 0.6, 60)])
    caster = RayCaster(np.empty((0, 4)), circles)
    angles = np.linspace(-3.0, 3.2, 360) + rng.uniform(-9.0, 9.0)
    ox, oy = np.linspace(0.0, 0.08, 360) + rng.uniform(-1.0, 1.0), np.linspace(0.0, -0.05, 360)
    ranges = caster.cast(ox, oy, np.cos(angles), np.sin(angles))
    few = [
        caster.cast(ox[i : i + 9], oy[i : i + 9], np.cos(angles[i : i + 9]), np.sin(angles[i : i + 9]))
        for i in range(0, 360, 9)
    ]
    assert np.array_equal(ranges, np.concatenate(few))


def test_a_pin_is_thin_at_the_lidars_height_if_that_is_asked_for() -> None:
    arena = Arena("pin", Bounds(-3, -3, 3, 3), Pose2D(), target=PlacedObject("bowling_pin", 1.0, 0.0))
    world = World(arena)
    ahead = (np.zeros(1), np.zeros(1), np.ones(1), np.zeros(1))
    assert world.ray_caster(0.18).cast(*ahead)[0] == pytest.approx(0.96)
    assert world.ray_caster(0.18, true_profile=True).cast(*ahead)[0] == pytest.approx(0.985, abs=0.001)
    assert world.clearance_m(0.0, 0.0, 0.0) == pytest.approx(1.0 - 0.15 - 0.04), (
        "it is no thinner to bump into"
    )
