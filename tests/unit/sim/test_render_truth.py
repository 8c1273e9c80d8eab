"""The true boxes of a rendered picture: where the pinhole formula and the pixels have them."""

from __future__ import annotations

import math

import numpy as np
import pytest

from target_nav.config import Config
from target_nav.sim.arena import Arena, Bounds, BoxObstacle, PlacedObject
from target_nav.sim.render import Renderer
from target_nav.sim.render_truth import TrueBox
from target_nav.state.types import Pose2D
from target_nav.utils.distance import project

CONFIG = Config()
CAMERA = CONFIG.camera
PIN = PlacedObject("bowling_pin", 0.0, 0.0)


def boxes(
    range_m: float, bearing_rad: float = 0.0, obstacles: tuple[BoxObstacle, ...] = ()
) -> tuple[TrueBox, ...]:
    arena = Arena("room", Bounds(-5.0, -5.0, 5.0, 5.0), Pose2D(-3.0, 0.0, 0.0), PIN, None, obstacles)
    yaw = -bearing_rad
    pose = Pose2D(-range_m - CAMERA.x_m * math.cos(yaw), -CAMERA.x_m * math.sin(yaw), yaw)
    return Renderer(arena, CONFIG).true_boxes(pose)


@pytest.mark.parametrize("range_m", [0.7, 1.5, 3.5])
@pytest.mark.parametrize("bearing_rad", [-0.3, 0.0, 0.4])
def test_a_pin_in_the_open_is_where_the_formula_puts_it(range_m: float, bearing_rad: float) -> None:
    (box,) = boxes(range_m, bearing_rad)
    truth = project(CAMERA, range_m, bearing_rad, 0.28, 0.08)
    assert truth is not None
    left, top, right, bottom = truth.edges
    assert (box.range_m, box.bearing_rad) == pytest.approx((range_m, bearing_rad), abs=1e-6)
    assert (box.left_px, box.right_px) == pytest.approx((left, right), abs=0.05 * (right - left) + 0.2)
    # Head and foot are nearer than the axis by their radius.
    nearer = 0.04 / range_m * (bottom - top)
    assert top - nearer <= box.top_px <= top + 0.1
    assert bottom - 0.1 <= box.bottom_px <= bottom + nearer
    assert box.visible == 1.0
    assert box.in_picture == pytest.approx(1.0, abs=0.05)


def test_what_the_border_cuts_goes_on_beyond_it() -> None:
    (box,) = boxes(0.22)
    assert box.bottom_px > CAMERA.height_px
    assert box.top_px < 0.0
    assert box.in_picture < 0.9


def test_what_a_box_hides_is_not_visible() -> None:
    (half,) = boxes(2.0, obstacles=(BoxObstacle(-0.6, 0.25, 0.1, 0.5, 0.0),))
    assert 0.2 < half.visible < 0.8
    assert boxes(2.0, obstacles=(BoxObstacle(-0.6, 0.0, 0.1, 0.5, 0.0),)) == ()


def test_what_is_behind_the_camera_is_not_there() -> None:
    arena = Arena("room", Bounds(-5.0, -5.0, 5.0, 5.0), Pose2D(-3.0, 0.0, 0.0), PIN)
    assert Renderer(arena, CONFIG).true_boxes(Pose2D(1.0, 0.0, 0.0)) == ()


def test_drawing_is_the_same_after_asking_for_the_boxes() -> None:
    arena = Arena("room", Bounds(-5.0, -5.0, 5.0, 5.0), Pose2D(-3.0, 0.0, 0.0), PIN)
    first, second = Renderer(arena, CONFIG), Renderer(arena, CONFIG)
    pose = Pose2D(-1.0, 0.1, 0.0)
    first.true_boxes(Pose2D(-2.0, 0.0, 0.5))
    drawn = [r.draw(pose, 0.0, np.random.default_rng(1)) for r in (first, second)]
    assert np.array_equal(*drawn)
