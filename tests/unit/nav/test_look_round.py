"""Looking all round: a whole turn whatever comes, and then the nearest ahead."""

from __future__ import annotations

import math

import pytest

from target_nav.config import Config
from target_nav.nav.look_round import LookRound
from target_nav.nav.skill import SkillStatus, SkillStep, View
from target_nav.state.types import Pose2D
from target_nav.utils.frames import wrap_angle
from tests.unit.nav.toy_world import TICK_S, ToyWorld, box, room
from tests.unit.nav.views import track_at, view

CONFIG = Config()


def look(time_limit_s: float = 40.0) -> LookRound:
    return LookRound(CONFIG, time_limit_s=time_limit_s, yaw_rate_radps=0.5)


def turned(
    skill: LookRound, seen_at: dict[float, tuple[float, float]], limit_s: float = 60.0
) -> tuple[SkillStep, float]:
    """A robot that turns as it is told; a target is tracked from each angle on (radians turned)."""
    yaw = total = now_s = 0.0
    place: tuple[float, float] | None = None
    step: SkillStep | None = None
    while now_s < limit_s:
        for angle, where in seen_at.items():
            if total >= angle:
                place = where
        pose = Pose2D(0.0, 0.0, yaw)
        track = track_at(*place, now_s) if place is not None else None
        now: View = view(now_s, pose=pose, track=track)
        if step is None:
            skill.start(now)
        step = skill.step(now)
        if step.status is not SkillStatus.RUNNING:
            return step, total
        yaw = wrap_angle(yaw + step.twist.wz_radps * TICK_S)
        total += step.twist.wz_radps * TICK_S
        now_s += TICK_S
    raise AssertionError(f"did not end: {step}")


def test_it_turns_all_the_way_whatever_it_sees_and_then_faces_the_nearest() -> None:
    step, total = turned(look(), {0.5: (3.0, 0.0), 2.0: (0.0, 1.5), 4.0: (-2.0, 0.0)})
    assert step.status is SkillStatus.SUCCESS
    assert "1.50 m off" in step.reason
    assert total == pytest.approx(2.0 * math.pi + math.pi / 2.0, abs=0.3)


def test_the_nearest_may_lie_back_and_turning_there_does_not_begin_the_look_again() -> None:
    step, total = turned(look(), {0.5: (1.0, -1.0)})
    assert step.status is SkillStatus.SUCCESS
    assert total == pytest.approx(2.0 * math.pi - math.pi / 4.0, abs=0.3)


def test_nothing_to_be_seen_is_told_after_the_turn() -> None:
    step, total = turned(look(), {})
    assert step.status is SkillStatus.FAILURE
    assert step.reason.startswith("nothing to be seen all round")
    assert total >= 2.0 * math.pi


def test_a_glimpse_that_is_not_confirmed_does_not_count() -> None:
    skill = look()
    skill.start(view(0.0))
    skill.step(view(0.0, track=track_at(1.0, 0.0, 0.0, confirmed=False)))
    skill.step(view(0.1, track=track_at(1.0, 0.0, 0.1, seen_ago_s=5.0)))
    step, _ = turned(skill, {})
    assert step.status is SkillStatus.FAILURE


def test_a_turn_that_is_held_up_ends_by_its_limit() -> None:
    skill = look(time_limit_s=3.0)
    skill.start(view(0.0))
    step = skill.step(view(3.1))
    assert step.status is SkillStatus.FAILURE
    assert "limit 3.0 s" in step.reason


@pytest.mark.parametrize("seed", range(3))
def test_in_a_room_with_noise_it_ends_facing_the_pin_without_touching_anything(seed: int) -> None:
    world = ToyWorld(
        walls=[*room(), *box(-1.4, 0.3, 0.3, 0.3)], pin=(-2.6, -1.2), start=Pose2D(-2.0, 0.0, 0.4), seed=seed
    )
    step = world.run(look())
    assert step.status is SkillStatus.SUCCESS, step
    x, y = -2.6 - world.true_pose.x_m, -1.2 - world.true_pose.y_m
    assert abs(wrap_angle(math.atan2(y, x) - world.true_pose.yaw_rad)) < 0.3
    assert world.min_clearance_m > 0.0
