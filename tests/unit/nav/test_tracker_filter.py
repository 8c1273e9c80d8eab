"""The filter of one target: its covariance stays a covariance, and it tells position from the camera's own errors."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from target_nav.config import TrackConfig
from target_nav.nav.tracker_filter import CameraMeasurement, TargetFilter
from target_nav.state.types import Pose2D

CONFIG = TrackConfig()
ORIGIN = Pose2D()


def measured(range_m: float, bearing: float = 0.0, bearing_only: bool = False) -> CameraMeasurement:
    return CameraMeasurement(range_m, 0.035 * range_m, bearing, 0.01, bearing_only)


def see(target: TargetFilter, camera: Pose2D, measurement: CameraMeasurement) -> None:
    expected = target.expect(camera)
    assert expected is not None
    target.update_camera(expected, measurement)


def test_it_begins_where_the_detection_was_as_surely_as_the_detection_is() -> None:
    target = TargetFilter(CONFIG, Pose2D(1.0, 1.0, math.pi / 2), measured(2.0, 0.0))
    assert (target.x_m, target.y_m) == pytest.approx((1.0, 3.0))
    across, cross, along = target.position_covariance
    assert along == pytest.approx((0.07) ** 2 + (2.0 * CONFIG.camera_scale_sigma) ** 2)
    assert across == pytest.approx((2.0 * 0.01) ** 2 + (2.0 * CONFIG.camera_yaw_sigma_rad) ** 2)
    assert cross == pytest.approx(0.0, abs=1e-12)


def test_a_hundred_frames_from_one_place_do_not_average_the_cameras_own_errors_away() -> None:
    target = TargetFilter(CONFIG, ORIGIN, measured(2.0))
    for _ in range(100):
        see(target, ORIGIN, measured(2.0))
    along, _, across = target.position_covariance
    assert math.sqrt(along) > 0.95 * 2.0 * CONFIG.camera_scale_sigma
    assert math.sqrt(across) > 0.95 * 2.0 * CONFIG.camera_yaw_sigma_rad


def test_one_position_settles_target_and_camera() -> None:
    target = TargetFilter(CONFIG, ORIGIN, measured(2.0 * 1.04, 0.012))
    for _ in range(30):
        see(target, ORIGIN, measured(2.0 * 1.04, 0.012))
    target.update_position(2.0, 0.0, (1e-4, 0.0, 0.0, 1e-4))
    assert math.hypot(target.x_m - 2.0, target.y_m) < 0.01
    assert target.camera_scale_error == pytest.approx(0.04, abs=0.01)
    assert target.camera_yaw_error_rad == pytest.approx(0.012, abs=0.004)


def test_a_bearing_moves_it_sideways_and_leaves_its_range() -> None:
    target = TargetFilter(CONFIG, ORIGIN, measured(1.0))
    before = target.position_covariance
    see(target, ORIGIN, measured(0.5, 0.02, bearing_only=True))
    assert math.hypot(target.x_m, target.y_m) == pytest.approx(1.0, abs=1e-3)
    assert 0.0 < target.y_m < 0.02
    assert target.position_covariance[0] == pytest.approx(before[0], rel=0.01)
    assert target.position_covariance[2] < before[2]


def test_a_clipped_box_begins_a_target_somewhere_short_of_its_range() -> None:
    target = TargetFilter(CONFIG, ORIGIN, measured(0.4, 0.1, bearing_only=True))
    along, _, _ = target.position_covariance
    assert math.atan2(target.y_m, target.x_m) == pytest.approx(0.1)
    assert 0.0 < math.hypot(target.x_m, target.y_m) < 0.4
    assert math.sqrt(along) > 0.1


def test_a_target_at_the_lens_has_no_bearing() -> None:
    target = TargetFilter(CONFIG, ORIGIN, measured(1.0))
    assert target.expect(Pose2D(0.99, 0.0, 0.0)) is None


def test_uncertainty_grows_with_time_way_and_turning_and_turning_counts_across() -> None:
    target = TargetFilter(CONFIG, ORIGIN, measured(2.0))
    assert target.growth(ORIGIN, 0.0, 0.0, 0.0) == pytest.approx((0.0, 0.0, 0.0))
    xx, xy, yy = target.growth(ORIGIN, 0.0, 0.0, 1.0)
    assert (xx, xy) == pytest.approx((0.0, 0.0))
    assert math.sqrt(yy) == pytest.approx(2.0 * CONFIG.drift_yaw_sigma_rad)
    xx, xy, yy = TargetFilter(CONFIG, ORIGIN, measured(2.0, 0.6)).growth(ORIGIN, 0.0, 0.0, 1.0)
    along = np.array([math.cos(0.6), math.sin(0.6)])
    assert along @ np.array([[xx, xy], [xy, yy]]) @ along == pytest.approx(0.0, abs=1e-12)
    assert min(target.growth(ORIGIN, 10.0, 0.0, 0.0)[::2]) > 0.0
    assert min(target.growth(ORIGIN, 0.0, 1.0, 0.0)[::2]) >= CONFIG.drift_sigma**2


def test_a_copy_goes_its_own_way() -> None:
    target = TargetFilter(CONFIG, ORIGIN, measured(2.0))
    other = target.copy()
    other.update_position(2.1, 0.0, (1e-4, 0.0, 0.0, 1e-4))
    other.predict((0.1, 0.0, 0.1))
    assert target.x_m == pytest.approx(2.0)
    assert other.x_m > 2.05
    assert target.position_covariance != other.position_covariance


poses = st.builds(Pose2D, st.floats(-5, 5), st.floats(-5, 5), st.floats(-math.pi, math.pi))
camera_steps = st.tuples(
    st.just("camera"), poses, st.floats(0.05, 8.0), st.floats(-1.0, 1.0), st.floats(1e-4, 1.0), st.booleans()
)
fix_steps = st.tuples(st.just("fix"), st.floats(-5, 5), st.floats(-5, 5), st.floats(1e-8, 1.0))
growth_steps = st.tuples(st.just("grow"), poses, st.floats(0, 10), st.floats(0, 10), st.floats(0, 10))


@settings(max_examples=100, deadline=None)
@given(
    camera_steps,
    st.lists(st.one_of(camera_steps, fix_steps, growth_steps), max_size=40),
    st.sampled_from([0.0, 0.03]),
)
def test_the_covariance_is_always_symmetric_and_positive(
    first: tuple, steps: list[tuple], scale: float
) -> None:
    def measurement(step: tuple) -> CameraMeasurement:
        _, _, range_m, bearing, sigma, bearing_only = step
        return CameraMeasurement(range_m, sigma * range_m, bearing, sigma, bearing_only)

    target = TargetFilter(TrackConfig(camera_scale_sigma=scale), first[1], measurement(first))
    for step in steps:
        if step[0] == "camera":
            expected = target.expect(step[1])
            if expected is not None:
                target.update_camera(expected, measurement(step))
        elif step[0] == "fix":
            _, x_m, y_m, variance = step
            target.update_position(x_m, y_m, (variance, 0.0, 0.0, variance))
        else:
            target.predict(target.growth(*step[1:]))
        covariance = target.covariance
        assert np.isfinite(covariance).all()
        assert (covariance == covariance.T).all()
        assert np.linalg.eigvalsh(covariance).min() > 0.0
