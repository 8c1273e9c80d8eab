"""Training pictures: boxes fit the pins in them, what is no pin has none, targets say what the boxes say."""

from __future__ import annotations

import math

import numpy as np
import pytest

from deploy.model.backgrounds import a_background
from deploy.model.bodies import Light, draw_sprite
from deploy.model.degrade import degrade
from deploy.model.scenes import HEIGHT, WIDTH, Bank, make_bank, make_scene
from deploy.model.shapes import DUCK_PIN, SHARES, TEN_PIN, a_pin, an_odd_thing
from deploy.model.sim_frames import make_frames
from deploy.model.targets import CENTERS, FRAME_TOP, STRIDES, assign
from target_nav.sim.render_revolved import revolved_from
from target_nav.utils import bowling_pin

WHITE = np.full((SHARES.size, 3), 240.0)


@pytest.fixture(scope="module")
def bank() -> Bank:
    return make_bank(np.random.default_rng(1), 12, 12, 6)


def test_a_level_view_has_the_profile_it_was_given() -> None:
    body = revolved_from(SHARES, TEN_PIN, WHITE, 1.0, 0.15)
    sprite = draw_sprite(body, 0.0, 50.0, Light(), 200, True)
    alpha = sprite.levels[0][:, :, 3] > 127
    rows = np.flatnonzero(alpha.any(axis=1))
    assert len(rows) == pytest.approx(200, abs=2)
    widths = alpha.sum(axis=1)
    for share in (0.1, 0.3, 0.6, 0.9):
        row = round(rows[-1] - share * 200)
        wanted = 60.0 * float(bowling_pin.width_at(np.array([share]))[0])
        assert widths[row] == pytest.approx(wanted, abs=2.5)


def test_from_above_a_pin_is_shorter_by_the_cosine_and_shows_its_roundness() -> None:
    body = revolved_from(SHARES, DUCK_PIN, WHITE, 1.0, 0.2)
    level = draw_sprite(body, 0.0, 20.0, Light(), 200, True)
    above = draw_sprite(body, math.radians(30.0), 20.0, Light(), 200, True)
    heights = [float(np.ptp(sprite.outline[:, 1])) for sprite in (level, above)]
    assert heights[1] < heights[0]
    assert heights[1] > heights[0] * math.cos(math.radians(30.0))


def test_duckpins_are_squatter_than_ten_pins_and_nothing_else_is_taken_for_a_pin() -> None:
    rng = np.random.default_rng(3)
    assert all(a_pin(rng, 64).is_pin for _ in range(5))
    assert not any(an_odd_thing(rng, 64).is_pin for _ in range(20))


def test_a_scene_s_boxes_fit_what_is_painted(bank: Bank) -> None:
    """A white pin alone on black: the box is where it is bright."""
    body = revolved_from(SHARES, TEN_PIN, WHITE, 1.0, 0.15)
    pin = draw_sprite(body, 0.0, 20.0, Light(ambient=1.0, diffuse=0.0, gloss=0.0), 224, True)
    black = Bank([pin], [], [np.zeros((300, 400, 3), np.uint8)])
    from deploy.model.scenes import _box_of, _Painter, _Placed

    for height, tilt in ((30.0, 0.0), (90.0, 0.05), (150.0, -0.1)):
        painter = _Painter(np.zeros((HEIGHT, WIDTH, 3), np.float32))
        thing = _Placed(black.pins[0], 160.3, 200.6, height, tilt, False)
        painter.paint(thing, 1, 0.0)
        bright = painter.picture.max(axis=2) > 120
        rows, columns = np.flatnonzero(bright.any(axis=1)), np.flatnonzero(bright.any(axis=0))
        seen = (columns[0], rows[0], columns[-1] + 1, rows[-1] + 1)
        assert _box_of(thing) == pytest.approx(seen, abs=1.0 + 0.005 * height)


def test_scenes_are_pictures_with_boxes_that_touch_them(bank: Bank) -> None:
    rng = np.random.default_rng(5)
    scenes = [make_scene(bank, rng) for _ in range(25)]
    assert all(scene.image_bgr.shape == (HEIGHT, WIDTH, 3) for scene in scenes)
    boxes = np.concatenate([scene.boxes for scene in scenes])
    assert len(boxes) > 20
    assert np.all(boxes[:, 2:] > boxes[:, :2])
    assert np.all((boxes[:, 0] < WIDTH) & (boxes[:, 2] > 0) & (boxes[:, 1] < HEIGHT) & (boxes[:, 3] > 0))
    assert any(len(scene.boxes) == 0 for scene in scenes)


def test_the_same_seed_draws_the_same_scene(bank: Bank) -> None:
    first, second = (make_scene(bank, np.random.default_rng(9)) for _ in range(2))
    assert np.array_equal(first.image_bgr, second.image_bgr)
    assert np.array_equal(first.boxes, second.boxes)


def test_backgrounds_differ_and_a_bad_camera_moves_nothing() -> None:
    rng = np.random.default_rng(7)
    first, second = a_background(rng), a_background(rng)
    assert first.dtype == np.uint8
    assert np.abs(first.astype(int) - second).mean() > 5.0
    picture = np.zeros((HEIGHT, WIDTH, 3), np.uint8)
    picture[80:160, 100:140] = 230
    for seed in range(8):
        worse = degrade(picture, np.random.default_rng(seed)).mean(axis=2)
        middle = 0.5 * (worse[110:130, 110:130].mean() + worse[10:30, 10:30].mean())
        columns = np.flatnonzero(worse[100:140].mean(axis=0) > middle)
        assert (columns[0], columns[-1] + 1) == pytest.approx((100, 140), abs=3)


def test_the_simulator_s_frames_carry_its_true_boxes() -> None:
    frames = make_frames(np.random.default_rng(11), 12)
    assert len(frames.frames) == 12
    assert sum(len(scene.boxes) for scene in frames.frames) > 0
    rng = np.random.default_rng(1)
    for _ in range(20):
        drawn = frames.draw(rng)
        assert drawn.image_bgr.shape == (HEIGHT, WIDTH, 3)
        for left, top, right, bottom in drawn.boxes:
            assert left < right
            assert top < bottom
            assert left < WIDTH
            assert right > 0
            assert top < HEIGHT
            assert bottom > 0


def test_targets_say_what_the_boxes_say() -> None:
    box = np.array([[100.0, 60.0, 120.0, 130.0]], np.float32)
    target = assign(box, np.zeros((0, 4), np.float32))
    mine = np.flatnonzero(target[:, 0] > 0)
    assert mine.size >= 1
    for cell in mine:
        u, v, stride = CENTERS[cell]
        left, top, right, bottom = target[cell, 1:5] * stride
        assert (u - left, v - top, u + right, v + bottom) == pytest.approx(tuple(box[0]), abs=1e-3)


@pytest.mark.parametrize("height", [14.0, 40.0, 64.0, 110.0, 150.0, 300.0])
def test_every_size_is_some_head_s_business(height: float) -> None:
    box = np.array([[160.0, 120.0, 160.0 + 0.3 * height, 120.0 + height]], np.float32)
    target = assign(box, np.zeros((0, 4), np.float32))
    strides = set(CENTERS[target[:, 0] > 0, 2].astype(int))
    assert strides
    assert strides <= set(STRIDES)


def test_an_edge_beyond_the_border_is_said_to_be_there_but_not_how_far() -> None:
    box = np.array([[100.0, -200.0, 200.0, 400.0]], np.float32)
    target = assign(box, np.zeros((0, 4), np.float32))
    cell = int(np.flatnonzero(target[:, 0] > 0)[0])
    _, v, stride = CENTERS[cell]
    top = v - target[cell, 2] * stride
    assert FRAME_TOP - 30.0 < top < FRAME_TOP


def test_where_it_does_not_matter_nothing_is_learnt() -> None:
    target = assign(np.zeros((0, 4), np.float32), np.array([[50.0, 50.0, 150.0, 150.0]], np.float32))
    inside = (CENTERS[:, 0] > 50) & (CENTERS[:, 0] < 150) & (CENTERS[:, 1] > 50) & (CENTERS[:, 1] < 150)
    assert np.array_equal(target[:, 0] < 0, inside)
