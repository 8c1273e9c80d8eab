"""Steering: goal-ward where it is free, round where it is not, and never into what the body cannot pass."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from target_nav.config import Config
from target_nav.nav.footprint import Footprint
from target_nav.nav.vfh import Steering, Vfh
from target_nav.state.types import FloatArray
from tests.unit.nav.views import NO_POINTS, points, wall

CONFIG = Config()
BODY = Footprint.of(CONFIG.robot)
clouds = st.lists(st.tuples(st.floats(-1.4, 1.4), st.floats(-1.4, 1.4)), max_size=30)
bearings = st.floats(-math.pi, math.pi)


def steer(
    obstacles: FloatArray,
    goal_rad: float = 0.0,
    goal_m: float = 1.0,
    *,
    vfh: Vfh | None = None,
    yaw_rad: float = 0.0,
    motion_rad: float | None = None,
    turned: bool = False,
) -> Steering | None:
    chooser = vfh or Vfh(CONFIG, turned=turned)
    return chooser.steer(obstacles, yaw_rad=yaw_rad, goal_rad=goal_rad, goal_m=goal_m, motion_rad=motion_rad)


@given(bearings)
def test_on_a_free_floor_it_goes_straight_to_the_goal(goal_rad: float) -> None:
    chosen = steer(NO_POINTS, goal_rad)
    assert chosen is not None
    assert chosen.direction_rad == goal_rad


def test_what_lies_behind_the_goal_does_not_matter() -> None:
    chosen = steer(wall(0.9, -0.5, 0.9, 0.5), goal_m=0.4)
    assert chosen is not None
    assert chosen.direction_rad == 0.0


def test_it_goes_round_a_box_on_the_shorter_side() -> None:
    chosen = steer(wall(0.7, -0.1, 0.7, 0.6))
    assert chosen is not None
    assert -math.pi / 2 < chosen.direction_rad < -0.1


def test_boxed_in_there_is_no_direction() -> None:
    ring = [(0.25 * math.cos(a), 0.25 * math.sin(a)) for a in np.linspace(-math.pi, math.pi, 60)]
    assert steer(points(*ring)) is None


@pytest.mark.parametrize("turned", [False, True])
@settings(max_examples=60)
@given(clouds, bearings, st.floats(0.1, 3.0))
def test_the_chosen_way_is_free_as_far_as_it_says(
    turned: bool, cloud: list[tuple[float, float]], goal_rad: float, goal_m: float
) -> None:
    obstacles = points(*cloud)
    if len(obstacles):
        assume(float(BODY.clearances_m(obstacles).min()) > 0.0)
    chosen = steer(obstacles, goal_rad, goal_m, turned=turned)
    if chosen is None or len(obstacles) == 0:
        return
    direction = chosen.direction_rad
    c, s = math.cos(direction), math.sin(direction)
    local = obstacles @ np.array([[c, -s], [s, c]]) if turned else obstacles
    step = np.array([1.0, 0.0]) if turned else np.array([c, s])
    for way in np.linspace(0.0, min(chosen.free_m, 1.2), 10):
        assert float(BODY.clearances_m(local - way * step).min()) > -0.001


@settings(max_examples=60)
@given(clouds, bearings, st.floats(0.2, 2.0), st.one_of(st.none(), bearings))
def test_a_mirrored_world_is_steered_through_mirrored(
    cloud: list[tuple[float, float]], goal_rad: float, goal_m: float, motion_rad: float | None
) -> None:
    obstacles = points(*cloud)
    one = steer(obstacles, goal_rad, goal_m, motion_rad=motion_rad)
    other = steer(
        obstacles * [1.0, -1.0], -goal_rad, goal_m, motion_rad=None if motion_rad is None else -motion_rad
    )
    assert (one is None) == (other is None)
    if one is None or other is None:
        return
    # Two equally good sides leave the choice open; everything else is the mirror image.
    same = abs(math.remainder(one.direction_rad + other.direction_rad, 2.0 * math.pi)) < 1e-6
    if not same:
        costs = [
            CONFIG.avoid.cost_target * abs(math.remainder(d - g, 2 * math.pi))
            + (0.0 if m is None else CONFIG.avoid.cost_heading * abs(math.remainder(d - m, 2 * math.pi)))
            for d, g, m in (
                (one.direction_rad, goal_rad, motion_rad),
                (-other.direction_rad, goal_rad, motion_rad),
            )
        ]
        assert costs[0] == pytest.approx(costs[1], abs=1e-6)


@pytest.mark.parametrize(("half_gap", "passes"), [(0.13, False), (0.16, False), (0.20, True), (0.35, True)])
def test_only_a_gap_wide_enough_for_the_body_is_a_valley(half_gap: float, passes: bool) -> None:
    gap = np.vstack([wall(0.6, half_gap, 0.6, 1.6, 0.02), wall(0.6, -1.6, 0.6, -half_gap, 0.02)])
    chosen = steer(gap, goal_m=1.2, turned=True)
    goes_through = chosen is not None and abs(chosen.direction_rad) < 0.3 and chosen.free_m > 0.6
    assert goes_through == passes


def test_it_does_not_change_sides_when_both_are_equally_good() -> None:
    vfh = Vfh(CONFIG, turned=False)
    rng = np.random.default_rng(4)
    box = wall(0.7, -0.25, 0.7, 0.25)
    sides = set()
    motion = None
    for _ in range(60):
        noisy = box + rng.normal(0.0, 0.02, box.shape)
        chosen = steer(noisy, vfh=vfh, motion_rad=motion)
        assert chosen is not None
        motion = chosen.direction_rad
        sides.add(math.copysign(1.0, chosen.direction_rad))
    assert len(sides) == 1


def test_its_memory_turns_with_the_body() -> None:
    box = wall(0.7, -0.25, 0.7, 0.25)
    vfh = Vfh(CONFIG, turned=False)
    first = steer(box, vfh=vfh)
    assert first is not None
    turn = 0.4
    c, s = math.cos(turn), math.sin(turn)
    seen = box @ np.array([[c, -s], [s, c]])
    second = steer(seen, -turn, vfh=vfh, yaw_rad=turn)
    assert second is not None
    assert math.copysign(1.0, second.direction_rad + turn) == math.copysign(1.0, first.direction_rad)


@pytest.mark.parametrize("aside_m", [-0.04, -0.02, 0.0, 0.02, 0.04, 0.06])
def test_it_aims_finer_than_its_sectors_at_a_gap_with_little_to_spare(aside_m: float) -> None:
    """Through the middle of a gap of 0.39 m, from wherever it stands before it, though the goal lies a little off."""
    gap = np.vstack([wall(0.5, 0.195, 0.5, 1.6, 0.02), wall(0.5, -1.6, 0.5, -0.195, 0.02)])
    goal = math.atan2(0.03 - aside_m, 0.7)
    chosen = steer(gap + np.array([0.0, -aside_m]), goal, goal_m=0.8, turned=True)
    assert chosen is not None
    assert chosen.free_m > 0.6
    assert abs(0.5 * math.tan(chosen.direction_rad) + aside_m) < 0.04
