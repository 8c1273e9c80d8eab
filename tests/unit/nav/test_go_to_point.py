"""Driving to a place: there within the tolerance, round obstacles, and an end where there is no way."""

from __future__ import annotations

import math

import pytest

from target_nav.config import Config
from target_nav.nav.go_to_point import GoToPoint
from target_nav.nav.skill import SkillStatus
from target_nav.state.types import Pose2D
from tests.unit.nav.toy_world import ToyWorld, box, room
from tests.unit.nav.views import view

CONFIG = Config()


def go_to(x_m: float, y_m: float, *, within_m: float = 0.1, time_limit_s: float = 90.0) -> GoToPoint:
    return GoToPoint(CONFIG, x_m=x_m, y_m=y_m, within_m=within_m, speed_mps=0.2, time_limit_s=time_limit_s)


@pytest.mark.parametrize("place", [(2.0, 0.0), (0.5, 1.5), (0.0, -1.0), (-0.6, 0.0)])
def test_it_gets_there_and_stands(place: tuple[float, float]) -> None:
    world = ToyWorld(pin=None, start=Pose2D(-1.5, 0.0, 0.0), drift=0.0)
    step = world.run(go_to(*place))
    assert step.status is SkillStatus.SUCCESS, step
    assert step.twist.speed_mps == 0.0
    assert math.hypot(world.pose_in_odom.x_m - place[0], world.pose_in_odom.y_m - place[1]) <= 0.1


@pytest.mark.parametrize("seed", range(3))
def test_it_goes_round_what_stands_in_the_way(seed: int) -> None:
    walls = [*room(), *box(0.0, 0.1, 0.4, 0.8)]
    world = ToyWorld(walls=walls, pin=None, start=Pose2D(-1.5, 0.0, 0.0), seed=seed)
    step = world.run(go_to(3.0, 0.0))
    assert step.status is SkillStatus.SUCCESS, step
    assert world.min_clearance_m > 0.0


def test_a_place_that_is_walled_off_is_given_up_with_a_reason() -> None:
    world = ToyWorld(walls=[*room(), *box(1.0, 0.0, 1.0, 1.0)], pin=None, start=Pose2D(-1.5, 0.0, 0.0))
    step = world.run(go_to(2.5, 0.0), limit_s=120.0)
    assert step.status is SkillStatus.FAILURE, step
    assert "m off" in step.reason
    assert world.min_clearance_m > 0.0


def test_a_limit_of_time_ends_it() -> None:
    skill = go_to(3.0, 0.0, time_limit_s=5.0)
    skill.start(view(0.0))
    assert skill.step(view(4.9)).status is SkillStatus.RUNNING
    step = skill.step(view(5.1))
    assert (step.status, step.reason) == (SkillStatus.FAILURE, "3.00 m off after 5.0 s (limit)")


def test_who_stands_there_already_need_not_move() -> None:
    skill = go_to(0.05, 0.0)
    skill.start(view(0.0))
    assert skill.step(view(0.0)).status is SkillStatus.SUCCESS
