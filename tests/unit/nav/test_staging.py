"""Where the last metre can begin."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from target_nav.config import RobotConfig
from target_nav.nav.footprint import Footprint
from target_nav.nav.staging import approach_spots, straight_way_clear, without_own
from target_nav.state.types import FloatArray
from tests.unit.nav.views import NO_POINTS, points, wall

BODY = Footprint.of(RobotConfig())
TARGET = (2.0, 1.0)
STAND_OFF_M, FARTHEST_M, MARGIN_M = 0.10, 0.70, 0.05


def spots(obstacles: FloatArray) -> FloatArray:
    return approach_spots(
        TARGET, obstacles, BODY, stand_off_m=STAND_OFF_M, farthest_m=FARTHEST_M, margin_m=MARGIN_M
    )


def angles(found: FloatArray) -> FloatArray:
    return np.arctan2(found[:, 1] - TARGET[1], found[:, 0] - TARGET[0])


def test_on_a_free_floor_every_side_will_do() -> None:
    found = spots(NO_POINTS)
    away = np.hypot(found[:, 0] - TARGET[0], found[:, 1] - TARGET[1])
    assert away.max() == pytest.approx(FARTHEST_M)
    assert away.min() > BODY.front_m + STAND_OFF_M
    assert len(np.unique(np.round(angles(found), 3))) == 64


def test_beside_a_wall_only_the_open_sides_are_left() -> None:
    found = angles(spots(wall(0.5, 1.12, 3.5, 1.12)))
    assert len(found) > 0
    assert found.max() < -0.3, "from below, not along the wall and not through it"
    assert found.min() > -math.pi + 0.3


def test_a_box_in_front_closes_that_side() -> None:
    found = angles(spots(wall(1.7, 0.9, 1.7, 1.1)))
    assert (np.abs(found) < 2.3).all(), "not from the left, where the box is"
    assert (np.abs(found) < 0.5).any()


def test_shut_in_there_is_no_side() -> None:
    ring = [(TARGET[0] + 0.3 * math.cos(a), TARGET[1] + 0.3 * math.sin(a)) for a in np.linspace(0, 6.2, 60)]
    assert len(spots(points(*ring))) == 0


@given(st.lists(st.tuples(st.floats(1.0, 3.0), st.floats(0.0, 2.0)), max_size=12))
def test_from_every_spot_the_straight_way_is_clear(cloud: list[tuple[float, float]]) -> None:
    obstacles = without_own(points(*cloud), TARGET, 0.2)
    for x, y, _ in spots(obstacles)[::7]:
        heading = math.atan2(TARGET[1] - y, TARGET[0] - x)
        c, s = math.cos(heading), math.sin(heading)
        in_base = (obstacles - [x, y]) @ np.array([[c, -s], [s, c]])
        target = (math.hypot(TARGET[0] - x, TARGET[1] - y), 0.0)
        assert straight_way_clear(target, in_base, BODY, stand_off_m=STAND_OFF_M, margin_m=MARGIN_M - 0.01)


@pytest.mark.parametrize(
    ("obstacle", "clear"),
    [
        ((0.4, 0.0), False),
        ((0.4, 0.18), False),
        ((0.4, 0.20), True),
        ((0.75, 0.0), True),
        ((1.2, 0.0), True),
        ((-0.1, 0.16), False),
        ((-0.3, 0.0), True),
    ],
)
def test_the_straight_way_is_the_body_swept_up_to_the_stand_off(
    obstacle: tuple[float, float], clear: bool
) -> None:
    found = straight_way_clear((0.8, 0.0), points(obstacle), BODY, stand_off_m=STAND_OFF_M, margin_m=MARGIN_M)
    assert found == clear


def test_own_points_are_those_near_the_target() -> None:
    assert without_own(points((1.0, 0.0), (1.05, 0.0), (1.2, 0.0)), (1.0, 0.0), 0.08).tolist() == [[1.2, 0.0]]
