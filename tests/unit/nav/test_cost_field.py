"""Cost to go: the way round things, dearer where it is tight, and no way where the body does not fit."""

from __future__ import annotations

import math

import numpy as np
import pytest

from target_nav.nav.cost_field import CostField
from target_nav.state.types import FloatArray

FITS_M, TURNS_M, COMFORT_M = 0.25, 0.35, 0.55


def field(
    points_m: FloatArray, goal: tuple[float, float], robot: tuple[float, float] = (0.0, 0.0)
) -> CostField:
    return CostField(
        points_m,
        robot,
        np.array([[*goal, 0.0]]),
        half_m=3.0,
        cell_m=0.1,
        fits_m=FITS_M,
        turns_m=TURNS_M,
        comfort_m=COMFORT_M,
    )


def at(costs: CostField, x_m: float, y_m: float) -> float:
    return float(costs.at(np.array([x_m]), np.array([y_m]))[0])


def wall(x_m: float, low_m: float, high_m: float) -> FloatArray:
    y = np.arange(low_m, high_m + 0.01, 0.05)
    return np.column_stack([np.full(len(y), x_m), y])


NOTHING: FloatArray = np.empty((0, 2))


def test_in_the_open_it_costs_what_the_way_is_long() -> None:
    costs = field(NOTHING, (2.0, 0.0))
    for x, y in [(0.0, 0.0), (1.0, 0.0), (0.0, -1.0), (-2.0, 1.0)]:
        # eight neighbours make a way up to 8 % longer than it is
        assert math.hypot(2.0 - x, y) - 0.02 <= at(costs, x, y) <= 1.09 * math.hypot(2.0 - x, y) + 0.02
    assert costs.has_way


def test_a_goal_out_of_the_window_pulls_towards_it() -> None:
    costs = field(NOTHING, (40.0, 0.0))
    assert at(costs, 1.0, 0.0) < at(costs, 0.0, 0.0) < at(costs, -1.0, 0.0)
    assert at(costs, 0.0, 0.0) == pytest.approx(40.0, rel=0.02)


def test_the_way_leads_round_a_wall_and_keeps_off_its_end() -> None:
    costs = field(wall(1.0, -2.0, 0.5), (2.0, 0.0))
    assert costs.has_way
    assert at(costs, 0.0, 0.0) > 1.15 * math.hypot(1.0, 0.5) * 2.0
    assert at(costs, 0.5, 0.9) < at(costs, 0.5, -0.9)


@pytest.mark.parametrize(("gap_m", "fits"), [(0.30, False), (0.40, False), (0.75, True), (1.0, True)])
def test_a_gap_is_a_way_if_the_body_fits(gap_m: float, fits: bool) -> None:
    points = np.vstack([wall(1.0, -3.2, -0.5 * gap_m), wall(1.0, 0.5 * gap_m, 3.2)])
    assert field(points, (2.0, 0.0)).has_way is fits


def test_a_wider_gap_never_costs_more() -> None:
    costs = [
        at(field(np.vstack([wall(1.0, -3.2, -half), wall(1.0, half, 3.2)]), (2.0, 0.0)), 0.0, 0.0)
        for half in (0.3, 0.4, 0.5, 0.7, 1.0)
    ]
    assert costs == sorted(costs, reverse=True)


def test_who_stands_too_near_to_something_is_led_away_from_it() -> None:
    costs = field(wall(-0.15, -0.5, 0.5), (2.0, 0.0))
    assert costs.has_way
    assert at(costs, 0.2, 0.0) < at(costs, 0.0, 0.0) < math.inf


def test_a_mirrored_world_costs_the_same() -> None:
    points = np.random.default_rng(3).uniform(-2.0, 2.0, (25, 2))
    points = points[np.hypot(points[:, 0], points[:, 1]) > 0.5]
    one, other = field(points, (2.5, 0.5)), field(points * [1.0, -1.0], (2.5, -0.5))
    for x, y in [(0.0, 0.0), (0.5, 0.7), (-1.0, -0.4)]:
        assert at(one, x, y) == pytest.approx(at(other, x, -y), rel=1e-6)
