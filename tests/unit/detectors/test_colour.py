"""Coloured things by their share of the light or by hue, and a pair of boxes whose gap is the scale."""

from __future__ import annotations

import numpy as np
import pytest

from target_nav.config import Config
from target_nav.detectors.colour import ColourDetector, TwoBoxDetector
from target_nav.detectors.pipeline import DetectionPipeline
from target_nav.errors import ConfigError
from target_nav.sim.arena import Arena, Bounds, PlacedObject
from target_nav.sim.render import Renderer
from target_nav.state.types import Pose2D, RawDetectionFrame, TargetSpec

CONFIG = Config()
CAMERA = CONFIG.camera
GREEN = (60, 190, 70)


def grey_picture(level: int = 120, seed: int = 1) -> np.ndarray:
    noise = np.random.default_rng(seed).normal(0.0, 4.0, (480, 640, 3))
    return np.clip(level + noise, 0, 255).astype(np.uint8)


def put(picture: np.ndarray, left: int, top: int, width: int, height: int, bgr: tuple[int, int, int]) -> None:
    picture[top : top + height, left : left + width] = bgr


@pytest.mark.parametrize("kind", ["share", "hsv"])
def test_a_green_thing_is_found_where_it_is(kind: str) -> None:
    picture = grey_picture()
    put(picture, 200, 150, 60, 90, GREEN)
    (box,) = ColourDetector("green", "colour:green", kind).detect(picture)
    assert (box.u_px, box.v_px) == pytest.approx((230.0, 195.0), abs=1.5)
    assert (box.width_px, box.height_px) == pytest.approx((60.0, 90.0), abs=5.0)
    assert box.class_name == "colour:green"


@pytest.mark.parametrize("light", [0.4, 0.7, 1.0, 1.25])
@pytest.mark.parametrize("kind", ["share", "hsv"])
def test_shadow_and_glare_change_little(kind: str, light: float) -> None:
    picture = grey_picture()
    put(picture, 200, 150, 60, 90, GREEN)
    lit = np.clip(picture * light, 0, 255).astype(np.uint8)
    (box,) = ColourDetector("green", "x", kind).detect(lit)
    assert box.height_px == pytest.approx(90.0, abs=6.0)


@pytest.mark.parametrize("kind", ["share", "hsv"])
@pytest.mark.parametrize(
    "bgr", [(60, 60, 190), (190, 60, 60), (120, 120, 120), (240, 240, 240), (84, 152, 184)]
)
def test_other_colours_are_not_green(kind: str, bgr: tuple[int, int, int]) -> None:
    picture = grey_picture()
    put(picture, 200, 150, 60, 90, bgr)
    assert ColourDetector("green", "x", kind).detect(picture) == ()


def test_a_rendered_orange_ball_is_found_by_hue_and_its_range_is_right() -> None:
    arena = Arena(
        "room", Bounds(-4.0, -4.0, 4.0, 4.0), Pose2D(-3.0, 0.0, 0.0), PlacedObject("ball", 0.0, 0.0)
    )
    picture = Renderer(arena, CONFIG).draw(Pose2D(-1.5 - CAMERA.x_m, 0.0, 0.0), 0.0, np.random.default_rng(2))
    label = "hsv:orange"
    boxes = ColourDetector("orange", label, "hsv").detect(picture)
    spec = TargetSpec(label, 0.22, 0.22)
    seen = DetectionPipeline(CONFIG).process(RawDetectionFrame(0.0, 0, boxes), spec).detections
    assert len(seen) == 1
    assert seen[0].range_m == pytest.approx(1.5, rel=0.08)
    assert abs(seen[0].bearing_rad) < 0.02


def two_boxes(gap_px: int, height_px: int = 50, right_height_px: int | None = None) -> np.ndarray:
    picture = grey_picture()
    left = 320 - gap_px // 2 - 15
    put(picture, left, 200, 30, height_px, GREEN)
    put(picture, left + gap_px, 200, 30, right_height_px or height_px, GREEN)
    return picture


@pytest.mark.parametrize("range_m", [0.8, 1.5, 3.0])
def test_the_gap_between_two_boxes_tells_the_range(range_m: float) -> None:
    gap_m = 0.4
    gap_px = round(CAMERA.focal_px * gap_m / range_m)
    label = "two_boxes:green"
    boxes = TwoBoxDetector("green", label).detect(two_boxes(gap_px, height_px=max(round(0.5 * gap_px), 24)))
    spec = TargetSpec(label, 0.5 * gap_m, gap_m)
    (seen,) = DetectionPipeline(CONFIG).process(RawDetectionFrame(0.0, 0, boxes), spec).detections
    assert seen.range_m == pytest.approx(range_m, rel=0.04)
    assert abs(seen.bearing_rad) < 0.01


def test_one_box_two_unequal_ones_and_a_third_between_are_no_pair() -> None:
    detector = TwoBoxDetector("green", "x")
    alone = grey_picture()
    put(alone, 300, 200, 30, 50, GREEN)
    assert detector.detect(alone) == ()
    assert detector.detect(two_boxes(150, 40, right_height_px=120)) == ()
    three = two_boxes(200)
    put(three, 305, 200, 30, 50, GREEN)
    # Its neighbours make two narrower pairs; the outer two make none.
    assert {round(box.width_px) for box in detector.detect(three)} == {100}


def test_a_colour_nobody_knows_is_told_with_those_that_are() -> None:
    with pytest.raises(ConfigError, match="share knows blue, green, red"):
        ColourDetector("mauve", "x")
