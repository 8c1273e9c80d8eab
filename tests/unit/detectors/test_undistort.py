from __future__ import annotations

import cv2
import numpy as np
import pytest

from target_nav.detectors.undistort import Undistorter
from target_nav.state.snapshots import Calibration

NONE = (0.0, 0.0, 0.0, 0.0, 0.0)
BARREL = (-0.3, 0.1, 0.001, -0.002, 0.0)


def calibration(distortion: tuple[float, float, float, float, float]) -> Calibration:
    return Calibration(0.0, 554.0, 554.0, 320.0, 240.0, distortion, 0.5, "bowling_pin")


def dot_at(u_px: float, v_px: float) -> np.ndarray:
    image = np.zeros((480, 640, 3), np.uint8)
    cv2.circle(image, (round(u_px - 0.5), round(v_px - 0.5)), 3, (255, 255, 255), -1)
    return image


def middle_of_dot(image: np.ndarray) -> tuple[float, float]:
    rows, columns = np.nonzero(image[:, :, 0] > 127)
    return float(columns.mean()) + 0.5, float(rows.mean()) + 0.5


def test_without_calibration_or_distortion_the_picture_passes_as_it_is() -> None:
    image = dot_at(100.0, 100.0)
    assert Undistorter().apply(image, None) is image
    assert Undistorter().apply(image, calibration(NONE)) is image


@pytest.mark.parametrize("ray", [(-0.4, 0.2), (0.3, -0.3), (0.0, 0.0)])
def test_a_distorted_point_goes_where_a_pinhole_would_have_put_it(ray: tuple[float, float]) -> None:
    """Brown's model, written out: x' = x (1 + k1 r2 + k2 r4) + 2 p1 x y + p2 (r2 + 2 x2), y' alike."""
    x, y = ray
    k1, k2, p1, p2, _ = BARREL
    r2 = x * x + y * y
    radial = 1.0 + k1 * r2 + k2 * r2 * r2
    seen_x = x * radial + 2.0 * p1 * x * y + p2 * (r2 + 2.0 * x * x)
    seen_y = y * radial + p1 * (r2 + 2.0 * y * y) + 2.0 * p2 * x * y
    image = dot_at(320.0 + 554.0 * seen_x, 240.0 + 554.0 * seen_y)
    u, v = middle_of_dot(Undistorter().apply(image, calibration(BARREL)))
    assert (u, v) == pytest.approx((320.0 + 554.0 * x, 240.0 + 554.0 * y), abs=1.0)


def test_a_new_calibration_is_followed() -> None:
    undistorter = Undistorter()
    image = dot_at(100.0, 100.0)
    one = undistorter.apply(image, calibration(BARREL))
    two = undistorter.apply(image, calibration((0.2, 0.0, 0.0, 0.0, 0.0)))
    assert not np.array_equal(one, two)
    assert np.array_equal(undistorter.apply(image, calibration(BARREL)), one)
