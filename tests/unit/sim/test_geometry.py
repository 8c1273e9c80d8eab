"""Distances to the footprint's rectangle, held against distances to many points of it."""

import math

import numpy as np
from hypothesis import example, given
from hypothesis import strategies as st

from target_nav.sim.geometry import (
    box_corners,
    point_to_rectangle,
    point_to_segment,
    segment_meets_rectangle,
    segment_to_rectangle,
)

coordinate = st.floats(-2.0, 2.0)
size = st.floats(0.05, 1.0)


def points_along(ax: float, ay: float, bx: float, by: float, count: int = 400) -> np.ndarray:
    share = np.linspace(0.0, 1.0, count)
    return np.column_stack([ax + share * (bx - ax), ay + share * (by - ay)])


@given(coordinate, coordinate, coordinate, coordinate, size, size)
@example(1.0126308438228946, 1.0, 1.0126308438228946, 1.0, 0.5, 0.5)
def test_segment_to_rectangle_is_the_least_of_its_points(ax, ay, bx, by, half_x, half_y):
    points = points_along(ax, ay, bx, by)
    spacing = math.hypot(bx - ax, by - ay) / (len(points) - 1)
    sampled = min(point_to_rectangle(x, y, half_x, half_y) for x, y in points.tolist())
    exact = segment_to_rectangle(ax, ay, bx, by, half_x, half_y)
    assert exact <= sampled + 1e-9
    # The nearest point lies within half a spacing of a sample; two ways to reckon it differ in the last digits.
    assert exact >= sampled - 0.5 * spacing - 1e-9


@given(coordinate, coordinate, size, size)
def test_point_to_rectangle_is_zero_inside_and_only_there(x, y, half_x, half_y):
    inside = abs(x) <= half_x and abs(y) <= half_y
    assert (point_to_rectangle(x, y, half_x, half_y) == 0.0) == inside


@given(coordinate, coordinate, coordinate, coordinate, size, size)
def test_a_segment_meets_the_rectangle_where_its_distance_is_zero(ax, ay, bx, by, half_x, half_y):
    meets = segment_meets_rectangle(ax, ay, bx, by, half_x, half_y)
    assert meets == (segment_to_rectangle(ax, ay, bx, by, half_x, half_y) == 0.0)


@given(coordinate, coordinate, coordinate, coordinate, size, size)
def test_distances_do_not_change_when_mirrored_or_reversed(ax, ay, bx, by, half_x, half_y):
    exact = segment_to_rectangle(ax, ay, bx, by, half_x, half_y)
    assert math.isclose(exact, segment_to_rectangle(ax, -ay, bx, -by, half_x, half_y), abs_tol=1e-9)
    assert math.isclose(exact, segment_to_rectangle(-ax, ay, -bx, by, half_x, half_y), abs_tol=1e-9)
    assert math.isclose(exact, segment_to_rectangle(bx, by, ax, ay, half_x, half_y), abs_tol=1e-9)


def test_a_segment_of_no_length_is_a_point():
    assert point_to_segment(3.0, 4.0, 0.0, 0.0, 0.0, 0.0) == 5.0


@given(coordinate, coordinate, size, size, st.floats(-7.0, 7.0))
def test_box_corners_keep_their_sides_and_go_counter_clockwise(x, y, length, width, yaw):
    corners = np.array(box_corners(x, y, length, width, yaw))
    sides = np.hypot(*(np.roll(corners, -1, axis=0) - corners).T)
    assert np.allclose(sides, [length, width, length, width])
    ahead = np.roll(corners, -1, axis=0)
    area = 0.5 * np.sum(corners[:, 0] * ahead[:, 1] - corners[:, 1] * ahead[:, 0])
    assert math.isclose(area, length * width, rel_tol=1e-6)
