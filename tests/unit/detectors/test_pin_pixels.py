"""The pin in rendered pixels: found, measured, not mistaken for anything else."""

from __future__ import annotations

from statistics import median

import numpy as np
import pytest

from target_nav.detectors.detector import Detector, ImageBgr
from target_nav.detectors.pin_pixels import PinPixelDetector
from target_nav.sim.render import Renderer
from target_nav.state.types import Pose2D, RawDetection
from target_nav.utils.distance import Box, bearing_from_u, clipping_of, range_from_height
from tests.unit.detectors.scenes import BACKGROUNDS, CONFIG, SPEC, picture_of_pin, room_without_pin, true_box

SCORE_MIN = CONFIG.detector.score_min
DETECTOR: Detector = PinPixelDetector()
RANGES_M = (0.6, 0.8, 1.0, 1.4, 1.9, 2.4, 3.0, 3.5)
BEARINGS_RAD = (-0.4, -0.13, 0.0, 0.27)


def believed(image: ImageBgr) -> list[RawDetection]:
    return [detection for detection in DETECTOR.detect(image) if detection.score >= SCORE_MIN]


def box_of(detection: RawDetection) -> Box:
    return Box(detection.u_px, detection.v_px, detection.width_px, detection.height_px)


@pytest.mark.parametrize("background", BACKGROUNDS)
class TestOverTheWholeRange:
    def test_one_pin_is_found_in_every_picture_and_measured_well(self, background: str) -> None:
        height_errors, range_errors, width_errors = [], [], []
        for range_m in RANGES_M:
            for bearing_rad in BEARINGS_RAD:
                detections = believed(picture_of_pin(background, range_m, bearing_rad))
                assert len(detections) == 1, (range_m, bearing_rad, detections)
                (found,) = detections
                truth = true_box(range_m, bearing_rad)
                assert found.u_px == pytest.approx(truth.u_px, abs=1.0 + 0.01 * truth.height_px)
                height_errors.append(found.height_px / truth.height_px - 1.0)
                width_errors.append(found.width_px / truth.width_px - 1.0)
                measured_m = range_from_height(
                    CONFIG.camera, SPEC.height_m, found.height_px, bearing_from_u(CONFIG.camera, found.u_px)
                )
                range_errors.append(measured_m / range_m - 1.0)
        assert abs(median(height_errors)) < 0.015
        assert max(map(abs, height_errors)) < 0.05
        assert max(map(abs, range_errors)) < 0.05
        assert max(map(abs, width_errors)) < 0.20

    @pytest.mark.parametrize("range_m", [3.8, 4.1])
    def test_it_is_found_as_far_as_the_simulator_s_camera_reaches(
        self, background: str, range_m: float
    ) -> None:
        (found,) = believed(picture_of_pin(background, range_m, 0.1))
        assert found.height_px == pytest.approx(true_box(range_m, 0.1).height_px, rel=0.06)

    @pytest.mark.parametrize("range_m", [0.22, 0.25, 0.29])
    def test_nearer_than_it_fits_its_box_touches_top_and_bottom(
        self, background: str, range_m: float
    ) -> None:
        (found,) = believed(picture_of_pin(background, range_m, 0.05))
        clipping = clipping_of(CONFIG.camera, box_of(found), CONFIG.detector.border_px)
        assert clipping.top
        assert clipping.bottom
        assert not clipping.sideways
        assert found.u_px == pytest.approx(true_box(range_m, 0.05).u_px, abs=6.0)


@pytest.mark.parametrize("side", [-1.0, 1.0])
@pytest.mark.parametrize("range_m", [0.6, 1.0])
def test_a_pin_cut_at_the_side_touches_that_border(range_m: float, side: float) -> None:
    """A quarter of its width is outside."""
    bearing_rad = side * (CONFIG.camera.half_fov_rad - 0.5 * SPEC.radius_m / range_m)
    (found,) = believed(picture_of_pin("open floor", range_m, bearing_rad))
    clipping = clipping_of(CONFIG.camera, box_of(found), CONFIG.detector.border_px)
    assert (clipping.left, clipping.right) == (side > 0.0, side < 0.0)
    assert found.height_px == pytest.approx(true_box(range_m, bearing_rad).height_px, rel=0.06)


def test_boxes_lie_inside_the_picture() -> None:
    for range_m in (0.18, 0.3, 0.5, 2.0):
        for bearing_rad in (-0.5, 0.0, 0.5):
            for found in DETECTOR.detect(picture_of_pin("open floor", range_m, bearing_rad)):
                left, top, right, bottom = box_of(found).edges
                assert left >= 0.0
                assert top >= 0.0
                assert right <= CONFIG.camera.width_px
                assert bottom <= CONFIG.camera.height_px


@pytest.mark.parametrize("seed", range(5))
def test_nothing_is_found_where_there_is_no_pin(seed: int) -> None:
    """White walls and boxes, brick-red boxes, bottles, cans, cones, balls, from 12 places each."""
    rng = np.random.default_rng(1000 + seed)
    renderer = Renderer(room_without_pin(seed), CONFIG)
    for _ in range(12):
        x, y = rng.uniform(-2.2, 2.2, 2)
        pose = Pose2D(float(x), float(y), float(rng.uniform(-3.1, 3.1)))
        assert believed(renderer.draw(pose, 0.0, rng)) == [], pose


@pytest.mark.parametrize("level", [0, 40, 128, 235, 255])
def test_a_picture_of_one_grey_is_empty(level: int) -> None:
    assert DETECTOR.detect(np.full((480, 640, 3), level, np.uint8)) == ()


def test_a_red_picture_and_red_noise_are_empty() -> None:
    red = np.zeros((480, 640, 3), np.uint8)
    red[..., 2] = 220
    assert DETECTOR.detect(red) == ()
    noise = np.random.default_rng(3).integers(0, 256, (480, 640, 3), dtype=np.uint8)
    assert believed(noise) == []


def test_other_picture_sizes_are_taken() -> None:
    import cv2

    image = picture_of_pin("open floor", 1.5)
    small = np.asarray(cv2.resize(image, (320, 240), interpolation=cv2.INTER_AREA), np.uint8)
    (found,) = believed(small)
    assert 2.0 * found.height_px == pytest.approx(true_box(1.5, 0.0).height_px, rel=0.05)


@pytest.mark.parametrize(
    "image",
    [np.zeros((480, 640), np.uint8), np.zeros((480, 640, 4), np.uint8), np.zeros((480, 640, 3), np.float32)],
)
def test_what_is_no_picture_is_refused(image: ImageBgr) -> None:
    with pytest.raises(ValueError, match="uint8"):
        DETECTOR.detect(image)


def test_it_says_what_it_can_find() -> None:
    assert DETECTOR.class_names == ("bowling_pin",)
    (found,) = believed(picture_of_pin("open floor", 1.0))
    assert found.class_name == "bowling_pin"
