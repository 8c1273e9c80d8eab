"""How far one sees past points that are a sample of surfaces."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from target_nav.nav.sight_lines import nearest_by_direction_m
from tests.unit.nav.views import NO_POINTS, points, wall


def test_nothing_is_infinitely_far() -> None:
    assert np.isinf(nearest_by_direction_m(NO_POINTS[:, 0], NO_POINTS[:, 1], 36)).all()


@pytest.mark.parametrize("away_m", [0.2, 0.5, 2.0])
def test_a_wall_of_points_a_cell_apart_is_shut(away_m: float) -> None:
    line = wall(away_m, -3.0 * away_m, away_m, 3.0 * away_m, step=0.1)
    nearest = nearest_by_direction_m(line[:, 0], line[:, 1], 180)
    ahead = np.abs(np.arange(180) - 90) <= 30
    assert (nearest[ahead] < 2.2 * away_m + 0.1).all()
    assert np.isinf(nearest[:30]).all()


def test_a_gap_as_wide_as_the_body_stays_open() -> None:
    posts = np.vstack([wall(1.0, 0.17, 1.0, 1.0), wall(1.0, -1.0, 1.0, -0.17)])
    nearest = nearest_by_direction_m(posts[:, 0], posts[:, 1], 180)
    assert np.isinf(nearest[88:93]).all()


@given(
    st.floats(-math.pi, math.pi),
    st.floats(0.16, 8.0),
    st.sampled_from([36, 120, 180]),
    st.sampled_from([0.0, 0.5]),
)
def test_a_point_is_seen_in_its_own_direction(
    bearing_rad: float, range_m: float, directions: int, turn: float
) -> None:
    xy = points((range_m * math.cos(bearing_rad), range_m * math.sin(bearing_rad)))
    nearest = nearest_by_direction_m(xy[:, 0], xy[:, 1], directions, turn)
    found = np.flatnonzero(np.isfinite(nearest))
    centres = -math.pi + (found + turn) * 2.0 * math.pi / directions
    off = np.abs(np.remainder(centres - bearing_rad + math.pi, 2.0 * math.pi) - math.pi)
    assert off.min() <= math.pi / directions + 1e-9
    assert (off <= math.atan2(0.05, range_m) + 2.0 * math.pi / directions).all()
    assert nearest[found] == pytest.approx(range_m)
