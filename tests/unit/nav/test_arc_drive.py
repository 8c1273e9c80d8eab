"""Driving a base that cannot strafe: within its limits, never into anything, and the same in a mirror."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from target_nav.config import Config
from target_nav.nav.arc_drive import ArcDriver
from target_nav.nav.arcs import STEP_S, clearances_m, roll_out
from target_nav.nav.footprint import Footprint
from target_nav.nav.go_to_point import GoToPoint
from target_nav.nav.nearest_point import NearestPoint
from target_nav.nav.skill import SkillStatus, View
from target_nav.state.types import STOP, FloatArray, Pose2D, Twist2D
from tests.unit.nav.toy_world import ToyWorld, box, room
from tests.unit.nav.views import view

CONFIG = Config().override({"robot.drive": "differential", "robot.max_speed_mps": 0.6})
ROBOT, BODY = CONFIG.robot, Footprint.of(CONFIG.robot)


def seen(points: FloatArray, twist: Twist2D = STOP) -> View:
    return replace(view(0.0), obstacles_in_base_m=points, twist_in_base=twist, pose_in_odom=Pose2D())


def drive(points: FloatArray, goal: tuple[float, float], twist: Twist2D = STOP) -> Twist2D:
    goals = np.array([[*goal, 0.0]])
    return ArcDriver(CONFIG).drive(seen(points, twist), lambda _: goals, speed_mps=0.5).twist


def test_ahead_of_it_it_drives_straight_and_as_fast_as_it_may() -> None:
    assert drive(np.empty((0, 2)), (3.0, 0.0)) == Twist2D(0.5, 0.0, 0.0)


@pytest.mark.parametrize("bearing_rad", [1.0, 2.0, 3.0, -1.0, -2.5])
def test_it_turns_to_the_side_where_the_goal_is(bearing_rad: float) -> None:
    twist = drive(np.empty((0, 2)), (2.0 * math.cos(bearing_rad), 2.0 * math.sin(bearing_rad)))
    assert twist.wz_radps * bearing_rad > 0.0


coordinates = st.floats(-2.0, 2.0)
clouds = st.lists(st.tuples(coordinates, coordinates), max_size=30).map(
    lambda rows: np.array(rows, dtype=np.float64).reshape(-1, 2)
)
twists = st.builds(Twist2D, st.floats(-0.2, 0.6), st.just(0.0), st.floats(-1.0, 1.0))


@settings(max_examples=40, deadline=None)
@given(points=clouds, goal=st.tuples(coordinates, coordinates), twist=twists)
def test_what_it_asks_for_is_within_limits_and_what_it_would_meet_is_far_enough_to_stop(
    points: FloatArray, goal: tuple[float, float], twist: Twist2D
) -> None:
    outside = points[BODY.clearances_m(points) > 0.0] if len(points) else points
    asked = drive(outside, goal, twist)
    assert asked.is_finite()
    assert abs(asked.vx_mps) <= ROBOT.max_speed_mps
    assert asked.vy_mps == 0.0
    assert abs(asked.wz_radps) <= ROBOT.max_yaw_rate_radps
    if asked.vx_mps > ROBOT.min_speed_mps and len(outside):
        stop_s = asked.vx_mps / ROBOT.max_decel_mps2
        along = np.linspace(0.0, stop_s, 8)
        margin = min(0.0, float(BODY.clearances_m(outside).min()))
        assert BODY.clearances_along_m(outside, asked, along).min() > margin - 0.06


def test_a_mirrored_world_gets_the_mirrored_command() -> None:
    points = np.array([[0.6, 0.1], [0.65, 0.15], [0.7, 0.2], [0.4, -0.9], [1.3, 0.4]])
    one = drive(points, (2.0, 0.3))
    other = drive(points * [1.0, -1.0], (2.0, -0.3))
    assert (other.vx_mps, other.wz_radps) == pytest.approx((one.vx_mps, -one.wz_radps))


def test_a_wall_right_ahead_is_not_driven_into() -> None:
    wall = np.column_stack([np.full(41, 0.22), np.linspace(-1.0, 1.0, 41)])
    twist = drive(wall, (2.0, 0.0))
    assert twist.vx_mps <= ROBOT.min_speed_mps


def test_no_spot_is_no_way() -> None:
    step = ArcDriver(CONFIG).drive(seen(np.empty((0, 2))), lambda _: np.empty((0, 3)), speed_mps=0.3)
    assert (step.twist, step.cost_to_go_m, step.reason) == (STOP, math.inf, "no way")


def test_arcs_keep_the_limits_of_acceleration() -> None:
    arcs = roll_out(Pose2D(), Twist2D(0.1, 0.0, 0.5), ROBOT, 0.6)
    speed = np.diff(arcs.way_m, axis=0) / STEP_S
    assert (np.abs(np.diff(speed, axis=0)) <= ROBOT.max_decel_mps2 * STEP_S + 1e-9).all()
    rate = np.diff(arcs.yaw_rad, axis=0) / STEP_S
    assert (np.abs(np.diff(rate, axis=0)) <= ROBOT.max_yaw_accel_radps2 * STEP_S + 1e-9).all()


def test_room_along_an_arc_is_that_of_the_footprint() -> None:
    points = np.array([[0.8, 0.3], [0.5, -0.5], [1.2, 0.0]])
    arcs = roll_out(Pose2D(0.1, 0.2, 0.3), Twist2D(0.2, 0.0, 0.0), ROBOT, 0.5)
    near = NearestPoint(points, (0.0, 0.0), 2.0, 0.05)
    found = clearances_m(arcs, near, BODY)
    t, k = 5, 40
    c, s = math.cos(arcs.yaw_rad[t, k]), math.sin(arcs.yaw_rad[t, k])
    offset = points - [arcs.x_m[t, k], arcs.y_m[t, k]]
    exact = BODY.clearances_m(offset @ np.array([[c, -s], [s, c]])).min()
    assert found[t, k] == pytest.approx(exact, abs=1e-9)


@pytest.mark.parametrize("seed", range(2))
def test_a_differential_base_gets_there_round_a_box(seed: int) -> None:
    walls = [*room(), *box(0.0, 0.1, 0.4, 0.8)]
    world = ToyWorld(config=CONFIG, walls=walls, pin=None, start=Pose2D(-1.5, 0.0, 0.0), seed=seed)
    skill = GoToPoint(CONFIG, x_m=3.0, y_m=0.0, within_m=0.1, speed_mps=0.4, time_limit_s=60.0)
    step = world.run(skill)
    assert step.status is SkillStatus.SUCCESS, step
    assert world.min_clearance_m > 0.0
