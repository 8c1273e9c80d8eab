"""Searching by driving about: what cannot be seen from here, within a radius and a time."""

from __future__ import annotations

import math

import pytest

from target_nav.config import Config
from target_nav.nav.skill import SkillStatus
from target_nav.nav.spiral_search import SpiralSearch
from target_nav.state.types import Pose2D
from tests.unit.nav.toy_world import ToyWorld, box, room
from tests.unit.nav.views import points, track_at, view

CONFIG = Config()
HIDDEN = room() + box(-0.2, 0.3, 0.3, 1.2)


def search(config: Config = CONFIG, *, time_limit_s: float = 90.0, radius_m: float = 2.5) -> SpiralSearch:
    return SpiralSearch(config, time_limit_s=time_limit_s, radius_m=radius_m, spacing_m=0.8, speed_mps=0.2)


def test_a_track_seen_just_now_ends_it() -> None:
    skill = search()
    seen = view(track=track_at(2.0, 0.0, 100.0))
    skill.start(seen)
    assert skill.step(seen).status is SkillStatus.SUCCESS


@pytest.mark.parametrize("drive", ["mecanum", "differential"])
def test_it_finds_a_pin_behind_a_wall(drive: str) -> None:
    config = CONFIG.override({"robot.drive": drive})
    world = ToyWorld(HIDDEN, pin=(1.2, 0.3), start=Pose2D(-1.5, 0.3, 0.0), config=config)
    step = world.run(search(config), 95.0)
    assert step.status is SkillStatus.SUCCESS, step.reason
    assert world.min_clearance_m > 0.01


def test_with_nothing_to_find_it_ends_and_says_what_it_did() -> None:
    world = ToyWorld(room(1.5), pin=None, start=Pose2D(), noise=0.0)
    step = world.run(search(), 100.0)
    assert step.status is SkillStatus.FAILURE
    assert step.reason.startswith("not found after")
    assert " m (" in step.reason


def test_the_time_limit_holds() -> None:
    world = ToyWorld(room(), pin=None, start=Pose2D(), noise=0.0)
    step = world.run(search(time_limit_s=5.0), 20.0)
    assert step.status is SkillStatus.FAILURE
    assert "limit 5.0 s" in step.reason
    assert world.now_s - 100.6 == pytest.approx(5.0, abs=0.2)


def test_it_stays_within_its_radius() -> None:
    world = ToyWorld(room(5.0), pin=None, start=Pose2D(), noise=0.0)
    world.run(search(radius_m=1.2, time_limit_s=40.0), 45.0)
    assert max(math.hypot(pose.x_m, pose.y_m) for pose in world.path) < 1.5


def test_way_points_beyond_walls_are_not_driven_at() -> None:
    cell = ToyWorld(room(0.7), pin=None, start=Pose2D(), noise=0.0)
    step = cell.run(search(radius_m=4.0, time_limit_s=200.0), 210.0)
    assert step.status is SkillStatus.FAILURE
    assert "all in reach was seen" in step.reason
    assert cell.min_clearance_m > 0.02


def test_it_looks_at_something_unsure_standing() -> None:
    skill = search()
    skill.start(view())
    step = skill.step(view(track=track_at(2.0, 0.0, 100.0, confirmed=False)))
    assert step.status is SkillStatus.RUNNING
    assert step.twist.speed_mps == 0.0


def test_shut_in_it_ends_soon() -> None:
    skill = search()
    ring = points(*((0.3 * math.cos(a / 10), 0.3 * math.sin(a / 10)) for a in range(63)))
    skill.start(view(100.0, obstacles=ring))
    step = skill.step(view(100.0, obstacles=ring))
    ticks = 0
    while step.status is SkillStatus.RUNNING and ticks < 2000:
        ticks += 1
        step = skill.step(view(100.0 + 0.05 * ticks, obstacles=ring))
        assert step.twist.speed_mps == 0.0
    assert step.status is SkillStatus.FAILURE
    assert ticks < 600


def test_after_a_find_that_was_none_it_goes_on_where_it_was() -> None:
    """A decoy ended the search for a moment; what was looked at need not be looked at again."""
    world, skill = ToyWorld(HIDDEN, pin=None, start=Pose2D(-1.5, 0.3, 0.0)), search(time_limit_s=60.0)
    world.run(skill, 20.0)
    found = view(world.now_s, track=track_at(2.0, 0.0, world.now_s))
    assert skill.step(found).status is SkillStatus.SUCCESS
    seen_m2 = skill.unseen_m2
    skill.start(view(world.now_s + 30.0))
    assert skill.unseen_m2 == seen_m2
    step = skill.step(view(world.now_s + 30.0 + 45.0))
    assert step.status is SkillStatus.FAILURE, "the time is counted over both"
    assert "limit 60.0 s" in step.reason


def test_after_all_was_seen_it_begins_anew() -> None:
    cell = ToyWorld(room(0.7), pin=None, start=Pose2D(), noise=0.0)
    skill = search(time_limit_s=200.0)
    assert "all in reach was seen" in cell.run(skill, 210.0).reason
    before_m2 = skill.unseen_m2
    skill.start(view(cell.now_s))
    assert skill.unseen_m2 > before_m2


def test_a_base_that_is_held_ends_it_long_before_the_time_is_over() -> None:
    skill = search(time_limit_s=180.0)
    skill.start(view(100.0))
    step, now_s = skill.step(view(100.0)), 100.0
    while step.status is SkillStatus.RUNNING and now_s < 200.0:
        now_s += 0.05
        step = skill.step(view(now_s))
    assert step.status is SkillStatus.FAILURE
    assert "in a row could not be driven to" in step.reason
    assert now_s < 145.0
