"""Way-points on a spiral."""

from __future__ import annotations

import math
from itertools import pairwise

import pytest

from target_nav.nav.spiral import spiral, spots_round


def test_way_points_go_outward_round_and_round() -> None:
    found = spiral(2.5, 0.8)
    away = [math.hypot(x, y) for x, y in found]
    assert away == sorted(away)
    assert away[0] == pytest.approx(0.6)
    assert 2.3 < away[-1] <= 2.5
    gaps = [math.dist(one, other) for one, other in pairwise(found)]
    assert max(gaps) < 0.7


def test_a_point_within_the_radius_is_never_far_from_a_way_point() -> None:
    found = spiral(2.5, 0.8)
    for x in range(-15, 16):
        for y in range(-15, 16):
            assert min(math.dist((x / 10, y / 10), spot) for spot in found) < 0.85


def test_a_radius_smaller_than_the_spacing_still_gives_a_way_point() -> None:
    assert spiral(0.3, 0.8) == [(0.3, 0.0)]


def test_spots_round_a_way_point_cost_more_the_farther_off_they_are() -> None:
    spots = spots_round((1.0, 2.0))
    assert spots[0].tolist() == [1.0, 2.0, 0.0]
    assert all(0.0 < math.dist(spot[:2], (1.0, 2.0)) < 0.25 and spot[2] > 0.0 for spot in spots[1:])
