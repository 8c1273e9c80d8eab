"""Searching by turning: to where it was last, all the way round, slowly enough to see, and never for ever."""

from __future__ import annotations

import math

import numpy as np
import pytest

from target_nav.config import Config
from target_nav.nav.skill import SkillStatus, SkillStep, View
from target_nav.nav.turn_search import TurnSearch
from target_nav.state.types import Pose2D
from tests.unit.nav.toy_world import ToyWorld, box, room
from tests.unit.nav.views import assert_mirrored, mirrored, track_at, view, wall

CONFIG = Config()


def search(config: Config = CONFIG, *, time_limit_s: float = 30.0, yaw_rate_radps: float = 0.5) -> TurnSearch:
    return TurnSearch(config, time_limit_s=time_limit_s, yaw_rate_radps=yaw_rate_radps)


def begun(first: View, config: Config = CONFIG) -> SkillStep:
    skill = search(config)
    skill.start(first)
    return skill.step(first)


def test_it_turns_first_to_where_the_target_was_last() -> None:
    to_the_right = view(track=track_at(1.0, -1.0, 100.0, seen_ago_s=5.0))
    assert begun(to_the_right).twist.wz_radps == -0.5
    assert begun(mirrored(to_the_right)).twist.wz_radps == 0.5
    assert_mirrored(begun(to_the_right).twist, begun(mirrored(to_the_right)).twist)


def test_it_remembers_where_the_target_was_when_there_is_no_track_any_more() -> None:
    skill = search()
    skill.start(view(10.0, track=track_at(1.0, -1.0, 10.0)))
    skill.step(view(10.05, track=track_at(1.0, -1.0, 10.0)))
    skill.start(view(20.0))
    assert skill.step(view(20.0)).twist.wz_radps < 0.0


def test_a_track_seen_just_now_ends_it() -> None:
    step = begun(view(track=track_at(1.0, 0.5, 100.0)))
    assert step.status is SkillStatus.SUCCESS
    assert "found" in step.reason


def test_an_unsure_track_is_looked_at_standing() -> None:
    step = begun(view(track=track_at(2.0, 0.1, 100.0, confirmed=False)))
    assert step.status is SkillStatus.RUNNING
    assert abs(step.twist.wz_radps) < 0.2


@pytest.mark.parametrize("asked", [0.2, 0.5, 3.0])
def test_a_target_that_crosses_the_picture_is_seen_often_enough(asked: float) -> None:
    skill = search(yaw_rate_radps=asked)
    skill.start(view())
    rate = skill.step(view()).twist.wz_radps
    frames = 2.0 * CONFIG.camera.half_fov_rad / rate * CONFIG.camera.rate_hz
    assert frames >= 8.0 - 1e-9
    assert rate <= asked


def test_it_fails_after_a_turn_and_a_bit() -> None:
    world = ToyWorld(pin=None, noise=0.0)
    step = world.run(search(), 40.0)
    assert step.status is SkillStatus.FAILURE
    assert "1.15 turns" in step.reason
    turned = sum(
        abs(math.remainder(b.yaw_rad - a.yaw_rad, math.tau))
        for a, b in zip(world.path, world.path[1:], strict=False)
    )
    assert turned == pytest.approx(1.15 * math.tau, abs=0.2)


def test_it_fails_at_the_time_limit() -> None:
    step = ToyWorld(pin=None, noise=0.0).run(search(time_limit_s=3.0), 10.0)
    assert step.status is SkillStatus.FAILURE
    assert "limit 3.0 s" in step.reason


@pytest.mark.parametrize("bearing", [-2.8, -1.2, 0.9, 2.4])
def test_it_finds_a_pin_that_stands_anywhere_round_it(bearing: float) -> None:
    pin = (-1.0 + 2.0 * math.cos(bearing), 2.0 * math.sin(bearing))
    world = ToyWorld(room(4.0), pin=pin, start=Pose2D(-1.0, 0.0, 0.0), seed=3)
    step = world.run(search(), 40.0)
    assert step.status is SkillStatus.SUCCESS, step.reason


def test_false_boxes_do_not_keep_it_from_getting_round() -> None:
    world = ToyWorld(pin=None, false_rate=0.15, seed=1)
    step = world.run(search(time_limit_s=60.0), 70.0)
    assert step.status is SkillStatus.FAILURE
    assert "1.15 turns" in step.reason


@pytest.mark.parametrize("drive", ["mecanum", "differential"])
def test_beside_a_wall_it_makes_room_and_gets_round(drive: str) -> None:
    config = CONFIG.override({"robot.drive": drive})
    world = ToyWorld(
        room() + box(0.0, 0.3, 2.0, 0.2), pin=None, start=Pose2D(0.0, 0.03, 0.0), noise=0.0, config=config
    )
    assert world.clearance_m() < 0.04
    step = world.run(search(config, time_limit_s=60.0), 70.0)
    if drive == "mecanum":
        assert "1.15 turns" in step.reason
    assert step.status is SkillStatus.FAILURE
    assert world.min_clearance_m > 0.01


def test_room_is_made_away_from_the_wall() -> None:
    step = begun(view(obstacles=np.vstack([wall(-1.0, 0.17, 1.0, 0.17)])))
    assert step.twist.vy_mps < 0.0
    assert step.twist.wz_radps > 0.0
    assert "making room" in step.reason
