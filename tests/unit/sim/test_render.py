"""The rendered picture against geometry: everything is where a pinhole camera would put it."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from target_nav.config import Config
from target_nav.errors import ConfigError
from target_nav.sim.arena import Arena, Bounds, BoxObstacle, CircleObstacle, PlacedObject, WallObstacle
from target_nav.sim.render import Renderer
from target_nav.sim.render_canvas import ImageBgr
from target_nav.state.types import Pose2D
from target_nav.utils.distance import project

CONFIG = Config()
CAMERA = CONFIG.camera
QUIET = CONFIG.override({"camera.noise_scale": 0.0})
FAR = Bounds(-4.0, -4.0, 4.0, 4.0)
START = Pose2D(-3.0, 0.0, 0.0)


def arena(**changes: object) -> Arena:
    return replace(Arena("test", FAR, START), **changes)


def draw(world: Arena, pose: Pose2D = START, config: Config = QUIET, seed: int = 1) -> ImageBgr:
    return Renderer(world, config).draw(pose, 0.0, np.random.default_rng(seed))


def difference(world: Arena, pose: Pose2D = START) -> np.ndarray:
    """Where a world looks different from the empty one, (480, 640)."""
    there, empty = draw(world, pose).astype(int), draw(arena(), pose).astype(int)
    return np.abs(there - empty).max(axis=2) > 12


def test_a_picture_is_bgr_bytes_of_the_configured_size_and_its_own() -> None:
    renderer = Renderer(arena(), CONFIG)
    rng = np.random.default_rng(0)
    first = renderer.draw(START, 0.0, rng)
    kept = first.copy()
    second = renderer.draw(Pose2D(1.0, 1.0, 1.0), 0.1, rng)
    assert first.shape == second.shape == (CAMERA.height_px, CAMERA.width_px, 3)
    assert first.dtype == np.uint8
    assert np.array_equal(first, kept)


def test_the_same_seed_gives_the_same_picture_and_another_another() -> None:
    world = arena(target=PlacedObject("bowling_pin", 0.0, 0.0))
    assert np.array_equal(draw(world, config=CONFIG, seed=5), draw(world, config=CONFIG, seed=5))
    assert not np.array_equal(draw(world, config=CONFIG, seed=5), draw(world, config=CONFIG, seed=6))


@pytest.mark.parametrize("range_m", [0.6, 1.0, 2.0, 3.0])
@pytest.mark.parametrize("bearing_rad", [-0.4, 0.0, 0.3])
def test_a_pin_is_where_the_pinhole_formula_puts_it(range_m: float, bearing_rad: float) -> None:
    pose = Pose2D(-range_m * math.cos(bearing_rad) - CAMERA.x_m, -range_m * math.sin(bearing_rad), 0.0)
    truth = project(CAMERA, range_m, bearing_rad, 0.28, 0.08)
    assert truth is not None
    world = arena(target=PlacedObject("bowling_pin", 0.0, 0.0))
    picture = draw(world, pose).astype(int)
    left, top, right, bottom = truth.edges
    # Its shadow on the floor is wider than the pin; it is dark, the pin is not, and it begins under the belly.
    pin = difference(world, pose) & (picture.max(axis=2) > 125)
    belly = int(240.0 + CAMERA.focal_px * 0.07 / range_m)
    rows, columns = np.flatnonzero(pin.any(axis=1)), np.flatnonzero(pin[:belly].any(axis=0))
    assert columns[0] == pytest.approx(left, abs=2.5)
    assert columns[-1] + 1 == pytest.approx(right, abs=2.5)
    assert rows[0] == pytest.approx(top, abs=2.5)
    # The near edge of the foot is lower than its middle: it is 0.017 m nearer.
    nearer_px = CAMERA.focal_px * CAMERA.z_m * (1.0 / (range_m - 0.02) - 1.0 / range_m)
    assert bottom - 2.5 <= rows[-1] + 1 <= bottom + nearer_px + 2.5


def test_a_pin_is_white_with_two_red_stripes_round_its_neck() -> None:
    pose = Pose2D(-0.8 - CAMERA.x_m, 0.0, 0.0)
    column = draw(arena(target=PlacedObject("bowling_pin", 0.0, 0.0)), pose)[:, 320].astype(int)
    red = column[:, 2] - np.maximum(column[:, 0], column[:, 1]) > 60
    starts = np.flatnonzero(np.diff(red.astype(int)) == 1)
    assert len(starts) == 2
    box = project(CAMERA, 0.8, 0.0, 0.28, 0.08)
    assert box is not None
    _, top, _, bottom = box.edges
    shares = (bottom - starts) / (bottom - top)
    assert np.all((shares > 0.6) & (shares < 0.8))
    body = column[int(top + 0.5 * (bottom - top)) : int(bottom - 8)]
    assert (body.max(axis=1) - body.min(axis=1)).max() < 25
    assert body.min() > 120


def test_a_box_s_front_is_as_high_and_wide_as_it_should_be() -> None:
    """0.5 m high, 0.4 m wide, its front 2 m before the camera."""
    pose = Pose2D(-2.0 - CAMERA.x_m, 0.0, 0.0)
    changed = difference(arena(obstacles=(BoxObstacle(0.15, 0.0, 0.3, 0.4, 0.0),)), pose)
    rows, columns = np.flatnonzero(changed[:, 320]), np.flatnonzero(changed[200])
    scale = CAMERA.focal_px / 2.0
    assert rows[0] == pytest.approx(240.0 - scale * (0.5 - CAMERA.z_m), abs=2.0)
    assert rows[-1] + 1 == pytest.approx(240.0 + scale * CAMERA.z_m, abs=2.0)
    assert (columns[0], columns[-1] + 1) == pytest.approx((320.0 - 0.2 * scale, 320.0 + 0.2 * scale), abs=2.0)


def test_a_cylinder_is_seen_between_its_tangents() -> None:
    pose = Pose2D(-1.5 - CAMERA.x_m, 0.0, 0.0)
    columns = np.flatnonzero(difference(arena(obstacles=(CircleObstacle(0.0, 0.0, 0.15),)), pose)[200])
    half_px = CAMERA.focal_px * math.tan(math.asin(0.15 / 1.5))
    assert (columns[0], columns[-1] + 1) == pytest.approx((320.0 - half_px, 320.0 + half_px), abs=2.0)


@pytest.mark.parametrize(
    "obstacle",
    [
        BoxObstacle(-1.0, 0.0, 0.2, 0.8, 0.3),
        CircleObstacle(-1.0, 0.0, 0.3),
        WallObstacle(-1.0, -0.5, -1.1, 0.5),
    ],
)
def test_what_is_nearer_hides_a_pin_entirely(obstacle: BoxObstacle | CircleObstacle | WallObstacle) -> None:
    pin = PlacedObject("bowling_pin", 0.0, 0.0)
    without, with_pin = arena(obstacles=(obstacle,)), arena(obstacles=(obstacle,), target=pin)
    assert np.array_equal(draw(without), draw(with_pin))


@pytest.mark.parametrize(
    "obstacle",
    [BoxObstacle(1.0, 0.0, 0.2, 0.8, 0.3), CircleObstacle(1.0, 0.0, 0.3), WallObstacle(1.0, -0.5, 1.1, 0.5)],
)
def test_what_is_farther_does_not(obstacle: BoxObstacle | CircleObstacle | WallObstacle) -> None:
    pin = PlacedObject("bowling_pin", 0.0, 0.0)
    behind = draw(arena(obstacles=(obstacle,), target=pin)).astype(int)
    column = 320
    rows = range(235, 250)
    alone = draw(arena(target=pin)).astype(int)
    assert np.abs(behind[rows, column] - alone[rows, column]).max() <= 3


@pytest.mark.parametrize(
    "hidden",
    [CircleObstacle(0.5, 0.0, 0.1), BoxObstacle(0.5, 0.0, 0.2, 0.2, 0.4), WallObstacle(0.5, -0.1, 0.6, 0.1)],
)
@pytest.mark.parametrize("hides", [CircleObstacle(-1.0, 0.0, 0.3), BoxObstacle(-1.0, 0.0, 0.2, 0.8, 0.3)])
def test_obstacles_hide_each_other_whatever_is_drawn_first(
    hides: CircleObstacle | BoxObstacle, hidden: CircleObstacle | BoxObstacle | WallObstacle
) -> None:
    """Of two equally high things the farther one reaches neither as high nor as low in the picture."""
    alone, both = draw(arena(obstacles=(hides,))), draw(arena(obstacles=(hides, hidden)))
    assert np.array_equal(alone, both)


def test_turning_left_moves_things_to_the_right() -> None:
    """The robot turns round base_link, so the camera moves to the left as well."""
    world = arena(target=PlacedObject("bowling_pin", 0.0, 0.0))
    columns = np.flatnonzero(difference(world, replace(START, yaw_rad=0.2))[200:230].any(axis=0))
    eye_x, eye_y = START.x_m + CAMERA.x_m * math.cos(0.2), CAMERA.x_m * math.sin(0.2)
    bearing_rad = math.atan2(-eye_y, -eye_x) - 0.2
    assert columns.mean() + 0.5 == pytest.approx(320.0 - CAMERA.focal_px * math.tan(bearing_rad), abs=1.0)


def test_a_mount_error_is_a_turn_of_the_camera_that_nobody_told() -> None:
    world = arena(target=PlacedObject("bowling_pin", 0.0, 0.0))
    bent = Renderer(world, QUIET, mount_error_rad=0.02).draw(START, 0.0, np.random.default_rng(1))
    told = QUIET.override({"camera.yaw_rad": 0.02})
    assert np.array_equal(bent, draw(world, config=told))


def test_noise_scales_with_the_configuration() -> None:
    def noise_of(scale: float) -> float:
        config = CONFIG.override({"camera.noise_scale": scale})
        first = draw(arena(), config=config, seed=1).astype(float)
        second = draw(arena(), config=config, seed=2).astype(float)
        return float(np.std((first - second)[:200]))

    assert noise_of(0.0) < 0.6  # exposure alone
    assert noise_of(2.0) == pytest.approx(2.0 * noise_of(1.0), rel=0.15)


@settings(max_examples=40, deadline=None)
@given(st.floats(-2.9, 2.9), st.floats(-2.9, 2.9), st.floats(-4.0, 4.0))
def test_every_pose_gives_a_picture_even_inside_of_things(x_m: float, y_m: float, yaw_rad: float) -> None:
    assert CROWDED.draw(Pose2D(x_m, y_m, yaw_rad), 1.0, np.random.default_rng(2)).shape == (480, 640, 3)


CROWDED = Renderer(
    Arena(
        "crowded",
        Bounds(-3.0, -3.0, 3.0, 3.0),
        Pose2D(),
        PlacedObject("bowling_pin", 0.2, 0.1),
        obstacles=(
            BoxObstacle(0.5, -0.6, 0.4, 0.3, 0.2),
            CircleObstacle(-1.0, 1.0, 0.4),
            WallObstacle(1.0, 1.0, 1.0, 2.0),
            WallObstacle(-2.0, -1.0, 0.0, -1.0),
        ),
        decoys=tuple(
            PlacedObject(name, -2.0 + 0.5 * i, 0.5)
            for i, name in enumerate(("bottle", "can", "cup", "vase", "ball", "cone", "bin", "chair_leg"))
        ),
    ),
    CONFIG,
)


def test_a_camera_above_the_obstacles_is_refused() -> None:
    high = CONFIG.override({"camera.z_m": 0.8})
    with pytest.raises(ConfigError, match=r"camera\.z_m is 0\.8 m.*0\.5 m"):
        Renderer(arena(), high)
