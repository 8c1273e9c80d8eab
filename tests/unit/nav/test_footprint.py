"""The body as a rectangle: what touches it, and how far it can go."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import assume, example, given
from hypothesis import strategies as st

from target_nav.config import RobotConfig
from target_nav.nav.footprint import FAR_M, Footprint, as_points
from target_nav.state.types import Twist2D
from tests.unit.nav.views import points, wall

BODY = Footprint(0.20, 0.10, 0.15)
MARGIN = 0.05
coordinate = st.floats(-1.5, 1.5)
clouds = st.lists(st.tuples(coordinate, coordinate), min_size=1, max_size=25)
angles = st.floats(-math.pi, math.pi)


def test_clearance_is_the_distance_to_the_outline_and_negative_inside() -> None:
    found = BODY.clearances_m(points((0.5, 0.0), (-0.3, 0.1), (0.0, -0.25), (0.23, 0.19), (0.15, 0.0)))
    assert found == pytest.approx([0.3, 0.2, 0.1, 0.05, -0.05])


def test_body_of_the_reference_robot() -> None:
    body = Footprint.of(RobotConfig())
    assert body.circumscribed_radius_m == pytest.approx(math.hypot(0.15, 0.14))


@pytest.mark.parametrize(
    ("direction", "obstacle", "free"),
    [
        (0.0, (1.0, 0.0), 1.0 - 0.20 - MARGIN),
        (math.pi, (-1.0, 0.1), 1.0 - 0.10 - MARGIN),
        (math.pi / 2, (0.1, 0.8), 0.8 - 0.15 - MARGIN),
        (0.0, (1.0, 0.19), 1.0 - 0.20 - MARGIN),
        (0.0, (1.0, 0.21), FAR_M),
        (0.0, (-1.0, 0.0), FAR_M),
    ],
)
def test_free_distance_ends_where_the_grown_body_meets_a_point(
    direction: float, obstacle: tuple[float, float], free: float
) -> None:
    assert BODY.free_distances_m(points(obstacle), np.array([direction]), MARGIN)[0] == pytest.approx(free)


@given(clouds, angles)
def test_going_the_free_distance_touches_nothing_and_going_on_would(
    cloud: list[tuple[float, float]], direction: float
) -> None:
    obstacles = points(*cloud)
    assume(float(BODY.clearances_m(obstacles).min()) > 0.001)
    before = BODY.clearances_m(obstacles)
    free = float(BODY.free_distances_m(obstacles, np.array([direction]), MARGIN)[0])
    step = np.array([math.cos(direction), math.sin(direction)])
    for way in np.linspace(0.0, min(free, 3.0), 12):
        after = BODY.clearances_m(obstacles - way * step)
        # The margin has square corners, so it may keep a little more free than asked for, never less.
        assert (after >= np.minimum(before, MARGIN) - 0.002).all()
    if free < 3.0:
        nearer = BODY.clearances_m(obstacles - (free + 0.01) * step)
        assert (nearer < MARGIN * math.sqrt(2.0) + 0.002).any()


@given(clouds, angles)
@example([(1.0, 0.2)], 0.0)
@example([(1.0, -0.2), (-0.15, 0.3)], math.pi)
@example([(0.25, 1.0)], math.pi / 2)
def test_mirrored_points_leave_mirrored_directions_free(
    cloud: list[tuple[float, float]], direction: float
) -> None:
    obstacles = points(*cloud)
    one = BODY.free_distances_m(obstacles, np.array([direction]), MARGIN)
    other = BODY.free_distances_m(obstacles * [1.0, -1.0], np.array([-direction]), MARGIN)
    assert one == other


def test_inside_its_margin_the_body_may_still_go_away_and_along() -> None:
    beside = wall(-1.0, 0.15 + 0.02, 1.0, 0.15 + 0.02)
    away, towards = BODY.free_distances_m(beside, np.array([-math.pi / 2, math.pi / 2]), MARGIN)
    assert away == FAR_M
    assert towards == pytest.approx(0.0, abs=0.001)


def test_turned_body_passes_where_the_body_held_across_does_not() -> None:
    long_body = Footprint(0.30, 0.30, 0.10)
    gap = np.vstack([wall(0.8, 0.2, 0.8, 1.0), wall(0.8, -1.0, 0.8, -0.2)])
    sideways = np.array([math.pi / 2])
    turned_gap = gap[:, ::-1] * [-1.0, 1.0]  # the same gap, to the left
    assert long_body.free_distances_m(turned_gap, sideways, 0.05)[0] < 0.8
    assert long_body.free_distances_turned_m(turned_gap, sideways, 0.05)[0] == FAR_M


def test_turned_body_that_cannot_stand_so_has_no_way_at_all() -> None:
    long_body = Footprint(0.30, 0.30, 0.10)
    close = points((0.0, 0.2))
    assert long_body.free_distances_turned_m(close, np.array([math.pi / 2]), 0.05)[0] == 0.0
    assert long_body.free_distances_turned_m(close, np.array([0.0]), 0.05)[0] == FAR_M


@given(st.floats(0.05, 0.6), st.floats(0.05, 0.6))
def test_a_wider_body_never_passes_a_narrower_gap(half_gap: float, half_width: float) -> None:
    body = Footprint(0.15, 0.15, half_width)
    gap = np.vstack([wall(0.5, half_gap, 0.5, 2.0, 0.01), wall(0.5, -2.0, 0.5, -half_gap, 0.01)])
    free = body.free_distances_turned_m(gap, np.array([0.0]), 0.0)[0]
    assert (free > 0.5) == (half_width <= half_gap)


def test_predicted_clearance_of_a_straight_motion_is_that_of_the_shifted_body() -> None:
    cloud = points((0.6, 0.05), (0.1, -0.4))
    along = BODY.clearances_along_m(cloud, Twist2D(0.2, -0.1, 0.0), np.array([0.0, 1.0]))
    assert along[0] == pytest.approx(BODY.clearances_m(cloud))
    assert along[1] == pytest.approx(BODY.clearances_m(cloud - [0.2, -0.1]))


@given(st.floats(-0.4, 0.4), st.floats(-0.4, 0.4), st.floats(-1.5, 1.5))
def test_predicted_arc_agrees_with_many_small_steps(vx: float, vy: float, wz: float) -> None:
    cloud = points((0.7, 0.3))
    arc = BODY.clearances_along_m(cloud, Twist2D(vx, vy, wz), np.array([1.0]))[0, 0]
    x = y = yaw = 0.0
    for _ in range(2000):
        middle = yaw + 0.5 * wz / 2000
        x += (math.cos(middle) * vx - math.sin(middle) * vy) / 2000
        y += (math.sin(middle) * vx + math.cos(middle) * vy) / 2000
        yaw += wz / 2000
    c, s = math.cos(yaw), math.sin(yaw)
    moved = (cloud - [x, y]) @ np.array([[c, -s], [s, c]])
    assert arc == pytest.approx(BODY.clearances_m(moved)[0], abs=1e-5)


def test_points_that_are_not_finite_are_left_out() -> None:
    cloud = points((0.5, 0.0), (math.nan, 0.0), (1.0, math.inf))
    assert as_points(cloud).tolist() == [[0.5, 0.0]]
    assert as_points(np.empty(0)).shape == (0, 2)
