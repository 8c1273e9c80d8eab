"""What a room looks like: one number chooses it, walls carry their pictures where geometry puts them."""

from __future__ import annotations

import numpy as np
import pytest

from target_nav.config import Config
from target_nav.sim.arena import Arena, Bounds
from target_nav.sim.render import Renderer
from target_nav.sim.render_canvas import Canvas
from target_nav.sim.render_look import FLOORS, Look
from target_nav.state.types import Pose2D

CONFIG = Config()
CAMERA = CONFIG.camera
ROOM = Arena("room", Bounds(-4.0, -3.0, 4.0, 3.0), Pose2D(-3.0, 0.0, 0.0))


def draw(look: Look) -> np.ndarray:
    return Renderer(ROOM, CONFIG, look=look).draw(Pose2D(-1.0, 0.0, 0.4), 0.0, np.random.default_rng(1))


def test_a_seed_is_a_look_and_another_another() -> None:
    assert Look.of(5) == Look.of(5)
    assert np.array_equal(draw(Look.of(5)), draw(Look.of(5)))
    assert np.abs(draw(Look.of(5)).astype(int) - draw(Look.of(6))).mean() > 3.0


def test_no_seed_is_the_plain_room() -> None:
    assert Look.of(0) == Look()
    assert np.array_equal(
        draw(Look()), Renderer(ROOM, CONFIG).draw(Pose2D(-1.0, 0.0, 0.4), 0.0, np.random.default_rng(1))
    )


def test_all_floors_come_up_and_no_room_is_black_or_white() -> None:
    looks = [Look.of(seed) for seed in range(1, 60)]
    assert {look.floor for look in looks} == set(FLOORS)
    for seed in (1, 2, 3, 4, 5, 6):
        assert 25 < draw(Look.of(seed)).mean() < 235


def test_a_negative_seed_is_refused() -> None:
    with pytest.raises(ValueError, match="-1"):
        Look.of(-1)


@pytest.mark.parametrize("depth_m", [1.0, 2.0])
def test_a_wall_s_picture_is_where_the_pinhole_formula_puts_it(depth_m: float) -> None:
    """A wall square to the camera, 100 pixels a metre, with a mark 0.5 m to the right and 0.3 m high."""
    canvas = Canvas(CAMERA)
    view = canvas.view_from(Pose2D(0.0, 0.0, 0.0))
    texture = np.zeros((240, 400, 3), np.uint8)
    top_m, middle_px = 2.4, 200.0
    texture[240 - 32 : 240 - 28, 248:252] = 255
    along_px = middle_px - view.slopes * depth_m * 100.0
    canvas.paint_texture(np.full(CAMERA.width_px, depth_m), top_m, along_px, texture, 100.0)
    rows, columns = np.nonzero(canvas.image_bgr[:, :, 0] > 127)
    scale = CAMERA.focal_px / depth_m
    assert columns.mean() + 0.5 == pytest.approx(320.0 + 0.5 * scale, abs=1.0)
    assert rows.mean() + 0.5 == pytest.approx(240.0 - (0.3 - CAMERA.z_m) * scale, abs=1.0)
    assert np.ptp(columns) + 1 == pytest.approx(0.04 * scale, abs=2.0)
