"""The pinhole camera: laws that hold for every range, bearing and size."""

from __future__ import annotations

import math
from dataclasses import replace

import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

from target_nav.config import CameraConfig, DetectorConfig
from target_nav.utils.distance import (
    Box,
    bearing_from_u,
    bearing_sigma,
    clip_box,
    clipping_of,
    project,
    range_from_height,
    range_from_width,
    range_sigma,
    u_from_bearing,
)

CAMERA = CameraConfig()
DETECTOR = DetectorConfig()
PIN_HEIGHT_M, PIN_WIDTH_M = 0.28, 0.08

ranges = st.floats(0.2, 8.0)
bearings = st.floats(-1.2, 1.2)
sizes = st.floats(0.02, 1.0)
focals = st.floats(200.0, 2000.0)


@given(ranges, bearings, sizes, sizes, focals)
def test_what_is_projected_is_measured_back(
    range_m: float, bearing_rad: float, height_m: float, width_m: float, focal_px: float
) -> None:
    camera = replace(CAMERA, focal_px=focal_px)
    box = project(camera, range_m, bearing_rad, height_m, width_m)
    assert box is not None
    measured_rad = bearing_from_u(camera, box.u_px)
    assert measured_rad == pytest.approx(bearing_rad, abs=1e-9)
    assert range_from_height(camera, height_m, box.height_px, measured_rad) == pytest.approx(
        range_m, rel=1e-9
    )
    assert range_from_width(camera, width_m, box.width_px, measured_rad) == pytest.approx(range_m, rel=1e-9)


def test_a_pin_one_metre_ahead_has_the_size_of_the_textbook() -> None:
    """554 px * 0.28 m / 1 m, standing on a floor that is 0.14 m under the camera."""
    box = project(CAMERA, 1.0, 0.0, PIN_HEIGHT_M, PIN_WIDTH_M)
    assert box is not None
    assert (box.u_px, box.v_px) == pytest.approx((320.0, 240.0))
    assert (box.width_px, box.height_px) == pytest.approx((44.32, 155.12))


@given(bearings)
def test_left_of_the_axis_is_left_in_the_picture(bearing_rad: float) -> None:
    assume(abs(bearing_rad) > 1e-6)
    assert (u_from_bearing(CAMERA, bearing_rad) < 320.0) == (bearing_rad > 0.0)


@given(bearings)
def test_the_mirrored_bearing_is_the_mirrored_column(bearing_rad: float) -> None:
    there, back = u_from_bearing(CAMERA, bearing_rad), u_from_bearing(CAMERA, -bearing_rad)
    assert there + back == pytest.approx(CAMERA.width_px)


@pytest.mark.parametrize("bearing_rad", [math.pi / 2, 2.0, math.pi])
def test_nothing_is_projected_from_behind(bearing_rad: float) -> None:
    assert project(CAMERA, 1.0, bearing_rad, PIN_HEIGHT_M, PIN_WIDTH_M) is None


@given(ranges, st.floats(1.01, 5.0))
def test_sigma_grows_with_range_in_metres_and_as_a_share(range_m: float, farther: float) -> None:
    def height_at(r: float) -> float:
        return CAMERA.focal_px * PIN_HEIGHT_M / r

    near = range_sigma(DETECTOR, range_m, height_at(range_m))
    far = range_sigma(DETECTOR, range_m * farther, height_at(range_m * farther))
    assert far > near * farther > near > 0.0


@pytest.mark.parametrize("range_m", [1.0, 2.0, 4.0, 7.0])
def test_sigma_is_what_was_measured_on_real_logs(range_m: float) -> None:
    share = range_sigma(DETECTOR, range_m, CAMERA.focal_px * PIN_HEIGHT_M / range_m) / range_m
    assert 0.034 <= share <= 0.0435


def test_bearing_sigma_holds_the_detector_and_the_mount() -> None:
    alone = bearing_sigma(replace(DETECTOR, mount_sigma_rad=0.0))
    assert math.radians(0.4) <= alone <= math.radians(0.7)
    assert bearing_sigma(DETECTOR) == pytest.approx(math.hypot(alone, DETECTOR.mount_sigma_rad))


@given(st.floats(-200, 840), st.floats(-200, 680), st.floats(1, 900), st.floats(1, 900))
def test_a_clipped_box_lies_in_the_picture_and_in_the_box(
    u: float, v: float, width: float, height: float
) -> None:
    box = Box(u, v, width, height)
    inside = clip_box(CAMERA, box)
    if inside is None:
        left, top, right, bottom = box.edges
        assert right <= 0.0 or bottom <= 0.0 or left >= CAMERA.width_px or top >= CAMERA.height_px
        return
    left, top, right, bottom = inside.edges
    slack = 1e-9
    assert left >= max(0.0, box.edges[0]) - slack
    assert top >= max(0.0, box.edges[1]) - slack
    assert right <= min(640.0, box.edges[2]) + slack
    assert bottom <= min(480.0, box.edges[3]) + slack


def test_borders_are_told_apart() -> None:
    clipping = clipping_of(CAMERA, Box.from_edges(1.0, 100.0, 300.0, 478.5), border_px=3.0)
    assert (clipping.left, clipping.top, clipping.right, clipping.bottom) == (True, False, False, True)
    assert clipping.sideways
    assert clipping.upright
    assert not clipping_of(CAMERA, Box.from_edges(4.0, 4.0, 636.0, 476.0), border_px=3.0).any


@given(ranges)
def test_a_pin_near_enough_to_fill_the_picture_is_clipped(range_m: float) -> None:
    """Camera at half the pin's height: it fits as long as its 0.28 m take less than 480 px, that is beyond 0.323 m."""
    box = project(CAMERA, range_m, 0.0, PIN_HEIGHT_M, PIN_WIDTH_M)
    assert box is not None
    visible = clip_box(CAMERA, box)
    assert visible is not None
    assert clipping_of(CAMERA, visible, border_px=0.0).upright == (range_m <= 554.0 * 0.28 / 480.0)
