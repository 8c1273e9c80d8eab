"""Whether an arena can be solved: a gap decides by the width of the body, a dead end does not."""

from __future__ import annotations

import pytest

from target_nav.config import Config
from target_nav.sim.arena_types import Arena, Bounds, BoxObstacle, Goal, PlacedObject, WallObstacle
from target_nav.sim.solvable import Solver
from target_nav.state.types import Pose2D


def room(gap_m: float, yaw_rad: float = 0.0, **extra: object) -> Arena:
    """A wall across the room at x = 0 with a gap of that width; the robot to the left, the target to the right."""
    half = 0.5 * gap_m
    walls = (WallObstacle(0.0, half, 0.0, 2.0), WallObstacle(0.0, -half, 0.0, -2.0)) if half < 2.0 else ()
    values: dict[str, object] = {"target": PlacedObject("bowling_pin", 1.2, 0.0), **extra}
    return Arena("gap", Bounds(-2, -2, 2, 2), Pose2D(-1.2, 0.3, yaw_rad), obstacles=walls, **values)  # type: ignore[arg-type]


@pytest.mark.parametrize("yaw_rad", [0.0, 1.0, 3.0])
@pytest.mark.parametrize(("gap_m", "fits"), [(0.32, False), (0.35, False), (0.42, True), (0.6, True)])
def test_the_body_and_its_margin_decide_at_a_gap(gap_m: float, fits: bool, yaw_rad: float) -> None:
    assert Solver(room(gap_m, yaw_rad)).is_solvable() is fits


def test_a_long_narrow_body_passes_lengthways_but_cannot_turn_in_a_bend() -> None:
    slim = Config().override({"robot.half_width_m": 0.1, "robot.front_m": 0.4, "robot.rear_m": 0.4})
    assert Solver(room(0.36, config=slim, goal=Goal(1.3, 0.0, 0.1), target=None)).is_solvable()
    bend = Arena(
        "bend",
        Bounds(-2, -2, 2, 2),
        Pose2D(-1.3, 0.0, 0.0),
        goal=Goal(0.0, 1.3, 0.1),
        obstacles=(
            BoxObstacle(-1.1, 1.1, 1.8, 1.8, 0.0),
            BoxObstacle(0.2, -1.1, 3.6, 1.8, 0.0),
            BoxObstacle(1.1, 0.9, 1.8, 2.2, 0.0),
        ),
        config=slim,
    )
    assert not Solver(bend).is_solvable()
    short = slim.override({"robot.front_m": 0.1, "robot.rear_m": 0.1, "robot.half_width_m": 0.05})
    assert Solver(Arena(**{**bend.__dict__, "config": short})).is_solvable()


def test_a_target_that_is_boxed_in_cannot_be_stopped_at() -> None:
    boxed = (
        BoxObstacle(1.0, 0.0, 0.1, 0.5, 0.0),
        BoxObstacle(1.4, 0.0, 0.1, 0.5, 0.0),
        BoxObstacle(1.2, 0.25, 0.5, 0.1, 0.0),
        BoxObstacle(1.2, -0.25, 0.5, 0.1, 0.0),
    )
    open_room = room(4.0)
    assert Solver(open_room).is_solvable()
    assert not Solver(Arena(**{**open_room.__dict__, "obstacles": boxed})).is_solvable()


def test_without_an_end_to_reach_there_must_be_room_to_search() -> None:
    assert Solver(room(4.0, target=None)).is_solvable()
    closed = tuple(
        BoxObstacle(x, y, length, width, 0.0)
        for x, y, length, width in [(-0.5, 0.3, 0.1, 1.4), (-1.2, 1.0, 1.6, 0.1), (-1.2, -0.4, 1.6, 0.1)]
    )
    assert not Solver(Arena(**{**room(4.0, target=None).__dict__, "obstacles": closed})).is_solvable()
