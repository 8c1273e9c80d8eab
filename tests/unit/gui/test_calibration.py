"""Calibration with a pin at a known place finds the focal length and the yaw that were wrong."""

from __future__ import annotations

import math
import random

import pytest

from target_nav.config import Config
from target_nav.gui.calibration import LEAST_SAMPLES, MOST_SAMPLES, PinCalibration
from tests.unit.gui import worlds
from tests.unit.gui.worlds import stale, world

GAP_M, PIN_M = 1.0, 0.08


def seen(config: Config, *, focal_px: float, yaw_rad: float, n: int, noise: float = 0.0) -> PinCalibration:
    """The pin stands straight ahead; the camera really has `focal_px` and `yaw_rad`."""
    calibration = PinCalibration(config, GAP_M, PIN_M)
    dice = random.Random(5)
    for i in range(n):
        range_m = calibration.true_m * config.camera.focal_px / focal_px * (1 + dice.gauss(0, noise))
        bearing = math.atan2(-config.camera.y_m, calibration.true_m) - yaw_rad + dice.gauss(0, noise / 5)
        detection = worlds.detection(range_m=range_m, bearing_rad=bearing)
        calibration.see(world(det=worlds.frame(detection, frame_id=i)))
    return calibration


@pytest.mark.parametrize(("focal_px", "yaw_rad"), [(554.0, 0.0), (580.0, 0.01), (500.0, -0.014)])
def test_it_finds_what_is_wrong(focal_px: float, yaw_rad: float) -> None:
    result = seen(Config(), focal_px=focal_px, yaw_rad=yaw_rad, n=40).result()
    assert result is not None
    assert result.focal_px == pytest.approx(focal_px)
    assert result.yaw_rad == pytest.approx(yaw_rad, abs=1e-9)
    assert not result.problem


def test_noise_of_a_real_detector_leaves_less_than_two_percent() -> None:
    result = seen(Config(), focal_px=580.0, yaw_rad=0.01, n=MOST_SAMPLES, noise=0.04).result()
    assert result is not None
    assert result.focal_px == pytest.approx(580.0, rel=0.02)
    assert result.spread == pytest.approx(0.04, abs=0.02)


def test_the_true_distance_counts_from_the_camera_to_the_pins_axis() -> None:
    config = Config()
    calibration = PinCalibration(config, GAP_M, PIN_M)
    assert calibration.true_m == pytest.approx(GAP_M + config.robot.front_m + 0.04 - config.camera.x_m)


@pytest.mark.parametrize(
    "look",
    [
        world(det=worlds.frame(worlds.detection(clipped=True))),
        world(det=worlds.frame(worlds.detection(confirmed=False))),
        world(det=worlds.frame(worlds.detection(class_name="bottle"))),
        world(det=worlds.frame(worlds.detection(range_m=math.nan))),
        world(det=worlds.frame()),
        world(det=stale("det", worlds.frame(worlds.detection()))),
        world(det=None),
        world(nav=None),
    ],
)
def test_what_must_not_be_believed_is_not_counted(look: object) -> None:
    calibration = PinCalibration(Config(), GAP_M, PIN_M)
    calibration.see(look)
    assert calibration.count == 0


def test_a_frame_counts_once_and_few_are_no_result() -> None:
    calibration = PinCalibration(Config(), GAP_M, PIN_M)
    for _ in range(100):
        calibration.see(world())
    assert calibration.count == 1
    assert seen(Config(), focal_px=554.0, yaw_rad=0.0, n=LEAST_SAMPLES - 1).result() is None


@pytest.mark.parametrize(("focal_px", "yaw_rad"), [(200.0, 0.0), (554.0, -0.2)])
def test_a_pin_that_stands_elsewhere_is_told_instead_of_being_calibrated_away(
    focal_px: float, yaw_rad: float
) -> None:
    result = seen(Config(), focal_px=focal_px, yaw_rad=yaw_rad, n=40).result()
    assert result is not None
    assert "does not stand where" in result.problem
