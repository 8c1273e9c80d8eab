"""Focal length from known distances: exact without noise, honest with it, and refusing what cannot be."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from target_nav.detectors.focal_fit import FocalFit, Sighting, fit_focal
from target_nav.errors import DeviceError

HEIGHT_M = 0.28
CENTER_PX = 320.0


def sighting(
    depth_m: float,
    focal_px: float = 554.0,
    noise: float = 0.0,
    seed: int = 0,
    count: int = 40,
    u_px: float = 320.0,
) -> Sighting:
    rng = np.random.default_rng(seed)
    heights = focal_px * HEIGHT_M / depth_m * (1.0 + noise * rng.standard_normal(count))
    return Sighting(depth_m, HEIGHT_M, tuple(heights.tolist()), (u_px,) * count)


def fit(*sightings: Sighting) -> FocalFit:
    return fit_focal(sightings, CENTER_PX)


@given(st.floats(200.0, 2000.0), st.lists(st.floats(0.5, 4.0), min_size=1, max_size=5, unique=True))
def test_without_noise_it_is_exact(focal_px: float, depths_m: list[float]) -> None:
    result = fit(*(sighting(d, focal_px) for d in depths_m))
    assert result.focal_px == pytest.approx(focal_px, rel=1e-9)
    assert max(abs(r) for r in result.residuals) < 1e-9


def test_its_sigma_is_honest() -> None:
    """Over many calibrations the errors are as large as said: the mean of squared errors over sigmas is about one."""
    scores = []
    for seed in range(200):
        result = fit(*(sighting(d, 554.0, 0.03, 10 * seed + k) for k, d in enumerate((1.0, 1.5, 2.0))))
        scores.append(((result.focal_px - 554.0) / result.focal_sigma_px) ** 2)
    assert 0.3 < float(np.mean(scores)) < 2.0


def test_distances_measured_from_the_wrong_point_are_told() -> None:
    """Given from the front edge, 3 cm before the lens: each looks that much longer."""
    depths_m = (1.0, 1.5, 2.0, 3.0)
    wrong = [
        Sighting(d - 0.03, s.height_m, s.heights_px, s.columns_px) for d in depths_m for s in [sighting(d)]
    ]
    result = fit(*wrong)
    assert result.offset_m == pytest.approx(0.03, abs=1e-6)
    assert fit(sighting(1.0)).offset_m is None


@given(st.floats(-0.2, 0.2))
def test_the_bearing_is_left_positive(bearing_rad: float) -> None:
    result = fit(sighting(1.5, u_px=CENTER_PX - 554.0 * float(np.tan(bearing_rad))))
    assert result.bearing_rad == pytest.approx(bearing_rad, abs=1e-9)


def test_a_mistyped_distance_is_named() -> None:
    good = [sighting(d) for d in (1.0, 1.5, 2.0)]
    bad = Sighting(2.2, HEIGHT_M, sighting(2.0).heights_px, (320.0,) * 40)
    with pytest.raises(DeviceError, match=r"2\.2 m is \+.* off the common focal length"):
        fit(*good, bad)


def test_two_things_at_once_are_noticed() -> None:
    heights = tuple([150.0] * 20 + [90.0] * 20)
    with pytest.raises(DeviceError, match="more than one target"):
        fit(Sighting(1.0, HEIGHT_M, heights, (320.0,) * 40))


@pytest.mark.parametrize("count", [0, 4])
def test_few_boxes_are_not_enough(count: int) -> None:
    with pytest.raises(DeviceError, match=f"only {count} boxes"):
        fit(Sighting(1.0, HEIGHT_M, (150.0,) * count, (320.0,) * count))


@pytest.mark.parametrize("depth_m", [0.0, -1.0, float("nan")])
def test_a_distance_that_is_none_is_refused(depth_m: float) -> None:
    with pytest.raises(DeviceError, match="greater than 0"):
        fit(Sighting(depth_m, HEIGHT_M, (150.0,) * 10, (320.0,) * 10))
    with pytest.raises(DeviceError, match="no sighting"):
        fit()
