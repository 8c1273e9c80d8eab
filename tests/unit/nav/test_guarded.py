"""Nothing that is not finite reaches a skill."""

from __future__ import annotations

import math

import pytest

from target_nav.nav.guarded import GuardedSkill
from target_nav.nav.skill import SkillStatus, SkillStep, View
from target_nav.state.types import STOP, Pose2D, Twist2D
from tests.unit.nav.views import points, track_at, view


class Recorder(GuardedSkill):
    def __init__(self) -> None:
        self.begun: list[View] = []
        self.seen: list[View] = []

    def _begin(self, view: View) -> None:
        self.begun.append(view)

    def _step(self, view: View) -> SkillStep:
        self.seen.append(view)
        return SkillStep(SkillStatus.SUCCESS, Twist2D(1.0, 0.0, 0.0), "done")


@pytest.mark.parametrize(
    "bad",
    [
        view(pose=Pose2D(math.nan)),
        view(pose=Pose2D(1e9)),
        view(twist=Twist2D(0.0, math.inf, 0.0)),
        view(math.nan),
    ],
)
def test_a_tick_that_cannot_be_used_stops_and_changes_nothing(bad: View) -> None:
    skill = Recorder()
    skill.start(view())
    step = skill.step(bad)
    assert step.status is SkillStatus.RUNNING
    assert step.twist == STOP
    assert "finite" in step.reason
    assert skill.seen == []


def test_it_begins_with_the_first_tick_that_can_be_used() -> None:
    skill = Recorder()
    skill.start(view(pose=Pose2D(math.nan)))
    assert skill.begun == []
    good = view(5.0)
    assert skill.step(good).status is SkillStatus.SUCCESS
    assert skill.begun == [good]
    skill.step(view(6.0))
    assert len(skill.begun) == 1


def test_points_and_tracks_are_cleaned() -> None:
    skill = Recorder()
    skill.start(view())
    skill.step(
        view(obstacles=points((1.0, 0.0), (math.nan, 0.0)), track=track_at(1.0, 0.0, 5.0, sigma_m=math.nan))
    )
    assert skill.seen[0].obstacles_in_base_m.tolist() == [[1.0, 0.0]]
    assert skill.seen[0].track is None
    usable = view(obstacles=points((1.0, 0.0)), track=track_at(1.0, 0.0, 5.0))
    skill.step(usable)
    assert skill.seen[1] is usable
