"""Going to the target: round what stands in the way, to where the last metre is free, and not for ever."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from target_nav.config import Config
from target_nav.nav.navigate import NavigateToTarget
from target_nav.nav.skill import SkillStatus
from target_nav.state.types import Pose2D, Twist2D
from target_nav.utils.frames import to_child
from tests.unit.nav.toy_world import Segment, ToyWorld, box, room
from tests.unit.nav.views import points, track_at, view, wall

CONFIG = Config()
DOOR: list[Segment] = [(0.0, -3.0, 0.0, -0.35), (0.0, 0.35, 0.0, 3.0)]
GAP: list[Segment] = [(0.0, -3.0, 0.0, -0.23), (0.0, 0.23, 0.0, 3.0)]


def navigate(
    config: Config = CONFIG, *, until_range_m: float = 0.8, lost_after_s: float = 3.0, speed_mps: float = 0.2
) -> NavigateToTarget:
    return NavigateToTarget(
        config, cruise_speed_mps=speed_mps, until_range_m=until_range_m, lost_after_s=lost_after_s
    )


def arrived(world: ToyWorld) -> None:
    """Within range, facing the pin, nothing touched."""
    assert world.pin is not None
    x, y = to_child(world.true_pose, *world.pin)
    assert math.hypot(x, y) < 0.85
    assert abs(math.atan2(y, x)) < 0.25
    assert world.min_clearance_m > 0.01


PLACES: dict[str, tuple[list[Segment], tuple[float, float], Pose2D]] = {
    "open floor": ([], (1.0, 0.5), Pose2D(-1.5, 0.0, 0.0)),
    "box in the way": (box(0.0, 0.1, 0.3, 0.35), (1.2, 0.5), Pose2D(-1.2, 0.3, 0.0)),
    "doorway": (DOOR, (1.3, 0.5), Pose2D(-1.3, -0.5, 0.2)),
    "narrow gap": (GAP, (1.3, 0.0), Pose2D(-1.3, -0.3, 0.1)),
    "pin beside a wall": ([], (1.0, 2.88), Pose2D(-0.8, 1.5, 0.6)),
    "box right in front of the pin": (box(1.0, 0.0, 0.3, 0.1), (1.35, 0.0), Pose2D(-0.2, 0.9, -0.5)),
    "pin in a corner": ([], (2.7, 2.7), Pose2D(1.0, 1.5, 0.6)),
}


@pytest.mark.parametrize("place", PLACES)
@pytest.mark.parametrize("drive", ["mecanum", "differential"])
def test_it_reaches_the_place_to_approach_from(place: str, drive: str) -> None:
    walls, pin, start = PLACES[place]
    config = CONFIG.override({"robot.drive": drive})
    world = ToyWorld(room() + walls, pin=pin, start=start, seed=7, config=config)
    step = world.run(navigate(config), 60.0)
    assert step.status is SkillStatus.SUCCESS, step.reason
    arrived(world)


def test_a_gap_narrower_than_the_robot_is_not_entered() -> None:
    bars: list[Segment] = [(0.0, 0.14, 0.0, 1.2), (0.0, -1.2, 0.0, -0.14)]
    world = ToyWorld(room(1.2) + bars, pin=(0.9, 0.0), start=Pose2D(-0.6, 0.0, 0.0), seed=1)
    step = world.run(navigate(lost_after_s=300.0), 80.0)
    assert step.status is SkillStatus.FAILURE
    assert "stuck" in step.reason
    assert "no way to the target" in step.reason
    assert max(pose.x_m for pose in world.path) < -0.1
    assert world.min_clearance_m > 0.01


def test_it_keeps_facing_the_target_while_it_strafes_round() -> None:
    walls, pin, start = PLACES["box in the way"]
    world = ToyWorld(room() + walls, pin=pin, start=start, noise=0.0)
    world.run(navigate(), 60.0)
    bearings = [math.atan2(*reversed(to_child(pose, *pin))) for pose in world.path[30:]]
    assert max(abs(bearing) for bearing in bearings) < 0.35
    assert max(abs(twist.vy_mps) for twist in world.sent) > 0.05


def test_it_does_not_circle_near_the_goal() -> None:
    world = ToyWorld(pin=(0.5, 0.0), start=Pose2D(-0.4, 0.2, 0.2), seed=2)
    step = world.run(navigate(), 20.0)
    assert step.status is SkillStatus.SUCCESS, step.reason
    way = sum(
        math.dist((a.x_m, a.y_m), (b.x_m, b.y_m)) for a, b in zip(world.path, world.path[1:], strict=False)
    )
    assert way < 0.3
    assert world.now_s - 100.6 < 8.0


def test_without_a_track_it_waits_then_fails() -> None:
    world = ToyWorld(pin=None, noise=0.0)
    step = world.run(navigate(lost_after_s=2.0), 10.0)
    assert step.status is SkillStatus.FAILURE
    assert "target lost" in step.reason
    assert all(twist.speed_mps == 0.0 for twist in world.sent)
    assert world.now_s - 100.6 == pytest.approx(2.0, abs=0.2)


def test_a_target_that_vanishes_is_given_up_after_the_limit() -> None:
    skill = navigate(lost_after_s=3.0)
    last = track_at(2.0, 0.0, 100.0)
    skill.start(view(100.0, track=last))
    for tick in range(200):
        now_s = 100.0 + 0.05 * tick
        step = skill.step(view(now_s, track=last if tick < 10 else None))
        if step.status is not SkillStatus.RUNNING:
            break
    assert step.status is SkillStatus.FAILURE
    assert now_s == pytest.approx(102.9 + 0.1, abs=0.2)
    assert "limit 3.0 s" in step.reason


def test_near_facing_and_with_a_free_way_it_is_done() -> None:
    skill = navigate()
    skill.start(view(track=track_at(0.7, 0.0, 100.0)))
    assert skill.step(view(track=track_at(0.7, 0.0, 100.0))).status is SkillStatus.SUCCESS


@pytest.mark.parametrize(
    ("track_xy", "obstacles"),
    [
        ((0.9, 0.0), []),
        ((0.5, 0.5), []),
        ((0.75, 0.0), [(0.4, 0.1)]),
        ((0.75, 0.0), [(0.4, 0.17)]),
    ],
)
def test_too_far_aside_or_with_something_in_between_it_is_not(
    track_xy: tuple[float, float], obstacles: list[tuple[float, float]]
) -> None:
    skill = navigate()
    seen = view(track=track_at(*track_xy, 100.0), obstacles=points(*obstacles))
    skill.start(seen)
    assert skill.step(seen).status is SkillStatus.RUNNING


def test_the_target_itself_is_no_obstacle_while_it_is_far_and_unsure() -> None:
    skill = navigate()
    own = wall(2.75, -0.04, 2.75, 0.04)
    seen = view(track=track_at(2.95, 0.05, 100.0, sigma_m=0.12), obstacles=own)
    skill.start(seen)
    step = skill.step(seen)
    assert step.twist.vx_mps == pytest.approx(0.2, abs=0.001)
    assert abs(step.twist.vy_mps) < 0.02


def test_a_mirrored_world_is_crossed_as_well() -> None:
    """Routes break ties one way, so step by step they differ; what counts does not."""
    walls, pin, start = PLACES["box in the way"]
    flipped = [(x1, -y1, x2, -y2) for x1, y1, x2, y2 in walls]
    world = ToyWorld(
        room() + flipped, pin=(pin[0], -pin[1]), start=Pose2D(start.x_m, -start.y_m, -start.yaw_rad)
    )
    assert world.run(navigate(), 60.0).status is SkillStatus.SUCCESS
    arrived(world)


anything = st.floats(allow_nan=True, allow_infinity=True)


@settings(max_examples=60)
@given(
    st.builds(Pose2D, anything, anything, anything),
    st.builds(Twist2D, anything, anything, anything),
    st.tuples(anything, anything),
    st.lists(st.tuples(anything, anything), max_size=5),
    st.sampled_from(["mecanum", "differential"]),
)
def test_whatever_it_is_told_its_velocity_stays_within_the_limits(
    pose: Pose2D, twist: Twist2D, target: tuple[float, float], cloud: list[tuple[float, float]], drive: str
) -> None:
    config = CONFIG.override({"robot.drive": drive})
    skill = navigate(config, speed_mps=5.0)
    skill.start(view())
    step = skill.step(view(pose=pose, twist=twist, track=track_at(*target, 100.0), obstacles=np.array(cloud)))
    assert step.twist.is_finite()
    assert step.twist.speed_mps <= config.robot.max_speed_mps + 1e-9
    assert abs(step.twist.vy_mps) <= (
        0.0 if drive == "differential" else config.robot.max_lateral_speed_mps + 1e-9
    )
    assert abs(step.twist.wz_radps) <= config.robot.max_yaw_rate_radps
