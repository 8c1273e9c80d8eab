"""Routes: round what is known, through what the body fits through, and not now one side, now the other."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from target_nav.config import Config
from target_nav.nav.route import RoutePlanner
from target_nav.state.types import FloatArray
from tests.unit.nav.views import NO_POINTS, points, wall

CONFIG = Config()
ORIGIN = (0.0, 0.0)
LIMIT_M = 20.0


def goal(x: float, y: float, extra: float = 0.0) -> FloatArray:
    return np.array([[x, y, extra]])


def clearance(route: FloatArray, obstacles: FloatArray) -> float:
    return float(np.hypot(*(route[:, None, :] - obstacles[None, :, :]).transpose(2, 0, 1)).min())


def box(x: float, y: float, length: float, width: float) -> FloatArray:
    a, b, c, d = x - length / 2, x + length / 2, y - width / 2, y + width / 2
    return np.vstack([wall(a, c, b, c), wall(b, c, b, d), wall(b, d, a, d), wall(a, d, a, c)])


def test_on_a_free_floor_the_goal_is_in_sight_at_once() -> None:
    route = RoutePlanner(CONFIG).plan(NO_POINTS, ORIGIN, goal(1.0, 0.4), LIMIT_M)
    assert route is not None
    assert route.next_m == pytest.approx((1.0, 0.4), abs=0.04)
    assert route.length_m == pytest.approx(math.hypot(1.0, 0.4), rel=0.1)


def test_it_goes_round_a_box_and_keeps_clear_of_it() -> None:
    obstacles = box(1.0, 0.1, 0.4, 0.8)
    route = RoutePlanner(CONFIG).plan(obstacles, ORIGIN, goal(2.0, 0.0), LIMIT_M)
    assert route is not None
    assert route.points_m[0] == pytest.approx(ORIGIN)
    assert route.points_m[-1] == pytest.approx((2.0, 0.0), abs=0.04)
    assert clearance(route.points_m, obstacles) > CONFIG.robot.circumscribed_radius_m
    assert float(route.points_m[:, 1].min()) < -0.4, "the shorter side is the right one"


def test_the_next_point_is_in_sight() -> None:
    obstacles = box(1.0, 0.1, 0.4, 0.8)
    route = RoutePlanner(CONFIG).plan(obstacles, ORIGIN, goal(2.0, 0.0), LIMIT_M)
    assert route is not None
    line = np.linspace(ORIGIN, route.next_m, 60)
    assert clearance(line, obstacles) > CONFIG.robot.half_width_m + CONFIG.avoid.stop_clearance_m


@pytest.mark.parametrize("off_m", [0.0, 0.013, 0.025, 0.04])
@pytest.mark.parametrize(
    ("width", "passes"), [(0.28, False), (0.31, False), (0.39, True), (0.45, True), (0.70, True)]
)
def test_a_wall_is_passed_only_by_a_gap_the_body_fits_through(
    width: float, passes: bool, off_m: float
) -> None:
    """Whatever way the cells of the grid happen to lie; 0.34 m is what the limiter lets through."""
    room = np.vstack([wall(-1.0, -1.5, 2.5, -1.5), wall(-1.0, 1.5, 2.5, 1.5), wall(-1.0, -1.5, -1.0, 1.5)])
    low, high = off_m - width / 2, off_m + width / 2
    gap = np.vstack(
        [room, wall(1.0 + off_m, high, 1.0 + off_m, 1.5), wall(1.0 + off_m, -1.5, 1.0 + off_m, low)]
    )
    route = RoutePlanner(CONFIG).plan(gap, ORIGIN, goal(1.8, 0.3), LIMIT_M)
    assert (route is not None) == passes


def test_a_wider_robot_needs_a_wider_gap() -> None:
    wide = CONFIG.override({"robot.half_width_m": 0.3, "robot.front_m": 0.3, "robot.rear_m": 0.3})
    gap = np.vstack([wall(1.0, 0.3, 1.0, 3.9), wall(1.0, -3.9, 1.0, -0.3)])
    assert RoutePlanner(CONFIG).plan(gap, ORIGIN, goal(2.0, 0.0), 6.0) is not None
    assert RoutePlanner(wide).plan(gap, ORIGIN, goal(2.0, 0.0), 6.0) is None


def test_a_wide_way_is_preferred_to_a_slightly_shorter_tight_one() -> None:
    tight_and_wide = np.vstack(
        [wall(1.0, 0.22, 1.0, 0.9), wall(1.0, -1.0, 1.0, -0.22), wall(1.0, 1.9, 1.0, 3.0)]
    )
    route = RoutePlanner(CONFIG).plan(tight_and_wide, (0.0, 0.7), goal(2.0, 0.7), LIMIT_M)
    assert route is not None
    assert clearance(route.points_m, tight_and_wide) > CONFIG.robot.circumscribed_radius_m


def test_it_starts_even_with_the_body_close_to_something() -> None:
    beside = wall(-0.5, 0.16, 0.8, 0.16)
    route = RoutePlanner(CONFIG).plan(beside, ORIGIN, goal(1.5, 0.0), LIMIT_M)
    assert route is not None


def test_a_goal_out_of_the_window_is_driven_at() -> None:
    route = RoutePlanner(CONFIG).plan(NO_POINTS, ORIGIN, goal(9.0, 3.0), LIMIT_M)
    assert route is not None
    end = route.points_m[-1]
    assert math.atan2(end[1], end[0]) == pytest.approx(math.atan2(3.0, 9.0), abs=0.1)
    assert math.hypot(*end) > 2.5


def test_a_goal_that_is_walled_in_has_no_route() -> None:
    assert RoutePlanner(CONFIG).plan(box(1.5, 0.0, 0.8, 0.8), ORIGIN, goal(1.5, 0.0), LIMIT_M) is None


def test_noise_does_not_change_the_side_of_a_box_in_the_middle() -> None:
    planner = RoutePlanner(CONFIG)
    rng = np.random.default_rng(2)
    sides = set()
    for step in range(20):
        at = (0.02 * step, 0.01 * math.sin(step))
        noisy = box(1.4, 0.0, 0.3, 0.8) + rng.normal(0.0, 0.02, (len(box(1.4, 0.0, 0.3, 0.8)), 2))
        route = planner.plan(noisy, at, goal(2.6, 0.0), LIMIT_M)
        assert route is not None
        middle = route.points_m[np.abs(route.points_m[:, 0] - 1.4).argmin()]
        sides.add(math.copysign(1.0, middle[1]))
    assert len(sides) == 1


def test_a_way_that_stays_blocked_is_left() -> None:
    planner = RoutePlanner(CONFIG)
    obstacles = box(1.2, 0.1, 0.3, 0.8)
    first = planner.plan(obstacles, ORIGIN, goal(2.4, 0.0), LIMIT_M)
    assert first is not None
    assert first.points_m[:, 1].min() < -0.3
    blocked = np.vstack([obstacles, wall(1.2, -2.5, 1.2, -0.3)])
    routes = [planner.plan(blocked, ORIGIN, goal(2.4, 0.0), LIMIT_M) for _ in range(4)]
    assert routes[0] is first, "one plan may be noise"
    last = routes[-1]
    assert last is not None
    assert last.points_m[:, 1].max() > 0.4


def test_costs_to_spots() -> None:
    obstacles = box(1.5, 0.0, 0.8, 0.8)
    spots = points((-1.0, 0.0), (1.5, 0.0), (2.5, 0.0), (9.0, 0.0))
    costs = RoutePlanner(CONFIG).costs_to(obstacles, ORIGIN, spots, LIMIT_M)
    assert costs[0] == pytest.approx(1.0, abs=0.25), "near enough is two tenths before it"
    assert math.isinf(costs[1])
    assert 2.3 < costs[2] < 4.5
    assert costs[3] == LIMIT_M, "out of the window anything may be"


@settings(max_examples=20, deadline=None)
@given(st.lists(st.tuples(st.floats(-2.5, 2.5), st.floats(-2.5, 2.5)), max_size=30))
def test_costs_to_spots_are_those_of_routes_there_to_a_metre_and_a_tenth(
    cloud: list[tuple[float, float]],
) -> None:
    obstacles = np.array([p for p in cloud if math.hypot(*p) > 0.5]).reshape(-1, 2)
    spots = points((2.0, 1.0), (-1.5, 2.0), (0.5, -2.4))
    costs = RoutePlanner(CONFIG).costs_to(obstacles, ORIGIN, spots, 40.0)
    for (x, y), cost in zip(spots.tolist(), costs.tolist()):
        route = RoutePlanner(CONFIG).plan(obstacles, ORIGIN, goal(x, y), 40.0)
        if route is not None:
            # the nearest of the cells two tenths round it, in steps of 0.8 m, and least of two by two cells
            assert cost <= 1.1 * route.cost_m + 1.0


def test_no_wall_gets_a_hole_on_the_coarse_grid() -> None:
    room = np.vstack(
        [wall_at(1.0, bearing) for bearing in np.linspace(0.0, 2.0 * math.pi, 8, endpoint=False)]
    )
    outside = points((2.5, 0.0), (0.0, 2.6), (-2.0, -2.0))
    assert np.isinf(RoutePlanner(CONFIG).costs_to(room, ORIGIN, outside, 40.0)).all()


def wall_at(range_m: float, bearing_rad: float) -> FloatArray:
    """One side of an octagon round the robot, a point each 8 cm."""
    half_m = 1.1 * range_m * math.tan(math.pi / 8.0)
    along = np.arange(-half_m, half_m, 0.08)
    c, s = math.cos(bearing_rad), math.sin(bearing_rad)
    return np.column_stack([c * range_m - s * along, s * range_m + c * along])
