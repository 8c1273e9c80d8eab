"""The nearest obstacle point by look-up: as near as a search through all of them says, to within a cell."""

from __future__ import annotations

import numpy as np
import pytest

from target_nav.nav.nearest_point import NOWHERE_M, NearestPoint

CELL_M = 0.05


@pytest.mark.parametrize("seed", range(5))
def test_the_distance_is_that_of_a_search_to_within_a_cell(seed: int) -> None:
    rng = np.random.default_rng(seed)
    points = rng.uniform(-1.9, 1.9, (40, 2)) + 5.0
    near = NearestPoint(points, (5.0, 5.0), 2.0, CELL_M)
    x, y = rng.uniform(3.1, 6.9, (2, 200))
    px, py = near.nearest_to(x, y)
    exact = np.hypot(x[:, None] - points[:, 0], y[:, None] - points[:, 1]).min(axis=1)
    found = np.hypot(x - px, y - py)
    assert (found >= exact - 1e-9).all(), "it names a point, so it is never nearer than the nearest"
    assert (found <= exact + 2.0 * CELL_M).all()


def test_what_it_names_is_one_of_the_points() -> None:
    points = np.array([[0.31, 0.27], [-0.8, 0.4]])
    near = NearestPoint(points, (0.0, 0.0), 1.0, CELL_M)
    px, py = near.nearest_to(np.array([0.3, -0.7]), np.array([0.3, 0.3]))
    assert np.column_stack([px, py]) == pytest.approx(points)


@pytest.mark.parametrize("points", [np.empty((0, 2)), np.array([[50.0, 50.0]])])
def test_without_points_in_the_window_the_nearest_is_nowhere(points: np.ndarray) -> None:
    near = NearestPoint(points, (0.0, 0.0), 1.0, CELL_M)
    assert near.nearest_to(np.array([0.0]), np.array([0.0]))[0][0] == NOWHERE_M
    assert near.distances_m().min() > 100.0


def test_a_place_outside_of_the_window_has_nothing_near_it_that_is_not_in_it() -> None:
    near = NearestPoint(np.array([[0.0, 0.0]]), (0.0, 0.0), 1.0, CELL_M)
    px, py = near.nearest_to(np.array([30.0]), np.array([-30.0]))
    assert (px[0], py[0]) == (0.0, 0.0)
