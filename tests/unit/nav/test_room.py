"""Room to back off to, and to turn in."""

from __future__ import annotations

import math

import numpy as np
import pytest

from target_nav.config import Config
from target_nav.nav.room import Room
from target_nav.state.types import STOP
from tests.unit.nav.views import NO_POINTS, wall

CONFIG = Config()
CORNER = np.vstack([wall(0.25, -1.0, 0.25, 1.0), wall(-1.0, 0.25, 1.0, 0.25)])


def test_in_a_corner_the_most_room_is_away_from_both_walls() -> None:
    direction, free = Room(CONFIG).widest(CORNER, math.radians(-135.0))
    assert direction == pytest.approx(math.radians(-135.0))
    assert free >= 0.6


def test_with_room_everywhere_the_wanted_direction_is_taken() -> None:
    direction, _ = Room(CONFIG).widest(NO_POINTS, math.radians(45.0))
    assert direction == pytest.approx(math.radians(45.0))


def test_a_differential_base_has_two_directions_only() -> None:
    room = Room(CONFIG.override({"robot.drive": "differential"}))
    direction, _ = room.widest(CORNER, math.radians(-90.0))
    assert abs(direction) == pytest.approx(math.pi)


def test_to_turn_beside_a_wall_it_first_makes_room() -> None:
    twist = Room(CONFIG).for_turning(wall(-1.0, 0.17, 1.0, 0.17))
    assert twist.vy_mps < -0.04
    assert twist.speed_mps == pytest.approx(0.06)


def test_with_room_to_turn_it_stays() -> None:
    assert Room(CONFIG).for_turning(wall(-1.0, 0.4, 1.0, 0.4)) == STOP
    assert Room(CONFIG).for_turning(NO_POINTS) == STOP


def test_between_two_walls_there_is_no_room_to_make() -> None:
    both = np.vstack([wall(-1.0, 0.16, 1.0, 0.16), wall(-1.0, -0.16, 1.0, -0.16), wall(0.17, -0.16, 0.17, 0.16),
                      wall(-0.17, -0.16, -0.17, 0.16)])  # fmt: skip
    assert Room(CONFIG).for_turning(both) == STOP
