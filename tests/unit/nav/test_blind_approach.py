"""The last metre: to the stand-off and not short of it, straight in front, and never through something."""

from __future__ import annotations

import math

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from target_nav.config import Config
from target_nav.nav.blind_approach import BlindApproach
from target_nav.nav.skill import SkillStatus, SkillStep
from target_nav.state.types import STOP, Pose2D, Track, Twist2D
from target_nav.utils.frames import compose
from tests.unit.nav.toy_world import ToyWorld, box, room
from tests.unit.nav.views import assert_mirrored, mirrored, points, track_at, view

CONFIG = Config()
STAND_OFF_M, RADIUS_M = 0.10, 0.04
DISTANCE_M = CONFIG.robot.front_m + STAND_OFF_M + RADIUS_M
DT = 0.05


def approach(config: Config = CONFIG, *, timeout_s: float = 20.0, speed_mps: float = 0.1) -> BlindApproach:
    return BlindApproach(
        config, stand_off_m=STAND_OFF_M, speed_mps=speed_mps, timeout_s=timeout_s, target_radius_m=RADIUS_M
    )


def reckon(
    skill: BlindApproach, track_of: dict[float, Track | None], seconds: float = 25.0
) -> tuple[Pose2D, SkillStep]:
    """Drive by dead reckoning alone; `track_of` gives the track from each time on."""
    pose, twist = Pose2D(), STOP
    track: Track | None = None
    step = SkillStep(SkillStatus.RUNNING)
    for tick in range(round(seconds / DT)):
        now_s = DT * tick
        track = next((t for since, t in reversed(track_of.items()) if now_s >= since), track)
        seen = view(100.0 + now_s, pose=pose, twist=twist, track=track)
        if tick == 0:
            skill.start(seen)
        step = skill.step(seen)
        if step.status is not SkillStatus.RUNNING:
            break
        twist = step.twist
        pose = compose(pose, Pose2D(twist.vx_mps * DT, twist.vy_mps * DT, twist.wz_radps * DT))
    return pose, step


@pytest.mark.parametrize("drive", ["mecanum", "differential"])
@pytest.mark.parametrize("seed", [1, 2])
def test_it_stops_at_the_stand_off_in_front_of_the_pin(drive: str, seed: int) -> None:
    config = CONFIG.override({"robot.drive": drive})
    world = ToyWorld(pin=(0.75, 0.06), start=Pose2D(0.0, 0.0, 0.05), seed=seed, config=config)
    step = world.run(approach(config), 25.0, near_target=True)
    world.coast()
    assert step.status is SkillStatus.SUCCESS, step.reason
    assert abs(world.stop_error_m(STAND_OFF_M)) < 0.02
    assert world.true_twist.speed_mps < 0.001


def test_when_nothing_measures_the_target_any_more_it_goes_by_dead_reckoning() -> None:
    pose, step = reckon(approach(), {0.0: track_at(0.8, 0.1, 100.0, ranged_ago_s=0.0), 0.2: None})
    assert step.status is SkillStatus.SUCCESS, step.reason
    assert math.hypot(0.8 - pose.x_m, 0.1 - pose.y_m) == pytest.approx(DISTANCE_M, abs=0.015)


def test_a_lateral_miss_is_strafed_out_while_it_faces_the_target() -> None:
    first, then = track_at(0.8, 0.0, 100.0), track_at(0.8, 0.08, 200.0)
    pose, step = reckon(approach(), {0.0: first, 1.0: then})
    assert step.status is SkillStatus.SUCCESS, step.reason
    assert pose.y_m == pytest.approx(0.08, abs=0.016)
    assert abs(pose.yaw_rad) < 0.08, "strafed, not turned"


def test_the_camera_refines_across_the_line_of_sight_but_not_along_it() -> None:
    first = track_at(0.8, 0.0, 100.0)
    wrong_range = track_at(0.9, 0.05, 200.0, ranged_ago_s=500.0)
    pose, step = reckon(approach(), {0.0: first, 1.0: wrong_range})
    assert step.status is SkillStatus.SUCCESS, step.reason
    assert pose.x_m == pytest.approx(0.8 - DISTANCE_M, abs=0.03)
    assert pose.y_m == pytest.approx(0.05, abs=0.02)


def test_it_never_asks_for_a_speed_under_the_dead_band() -> None:
    world = ToyWorld(pin=(0.75, -0.05), start=Pose2D(), seed=5)
    step = world.run(approach(), 25.0, near_target=True)
    assert step.status is SkillStatus.SUCCESS, step.reason
    for twist in world.asked:
        speed, turn = twist.speed_mps, abs(twist.wz_radps)
        assert speed == 0.0 or speed >= CONFIG.robot.min_speed_mps - 1e-9
        assert speed > 0.0 or turn == 0.0 or turn >= CONFIG.robot.min_yaw_rate_radps - 1e-9


@pytest.mark.parametrize("deadband_mps", [0.0, 0.02, 0.03])
def test_it_does_not_stop_short_in_the_motors_dead_band(deadband_mps: float) -> None:
    config = CONFIG.override({"drive_sim.deadband_mps": deadband_mps})
    world = ToyWorld(pin=(0.9, 0.1), start=Pose2D(), seed=6, config=config)
    step = world.run(approach(config), 25.0, near_target=True)
    world.coast()
    assert step.status is SkillStatus.SUCCESS, step.reason
    assert abs(world.stop_error_m(STAND_OFF_M)) < 0.02


def test_it_slows_down_towards_the_end() -> None:
    world = ToyWorld(pin=(0.8, 0.0), start=Pose2D(), noise=0.0, drift=0.0)
    world.run(approach(), 25.0, near_target=True)
    speeds = [twist.vx_mps for twist in world.asked if twist.vx_mps > 0.0]
    assert max(speeds) == pytest.approx(0.1)
    assert speeds[-1] < 0.05


@pytest.mark.parametrize("drive", ["mecanum", "differential"])
def test_too_near_it_backs_off(drive: str) -> None:
    config = CONFIG.override({"robot.drive": drive})
    world = ToyWorld(pin=(0.24, 0.0), start=Pose2D(), config=config)
    step = world.run(approach(config), 25.0, near_target=True)
    assert step.status is SkillStatus.SUCCESS, step.reason
    assert abs(world.stop_error_m(STAND_OFF_M)) < 0.02


def test_beside_a_wall_it_gets_there() -> None:
    pin = (0.6, 0.6)
    wall_behind = room() + box(0.0, 0.87, 4.0, 0.3)
    world = ToyWorld(wall_behind, pin=pin, start=Pose2D(0.25, 0.05, 1.0))
    step = world.run(approach(), 25.0, near_target=True)
    assert step.status is SkillStatus.SUCCESS, step.reason
    assert world.min_clearance_m > 0.02


def test_without_a_track_at_the_start_it_fails_at_once() -> None:
    skill = approach()
    skill.start(view())
    step = skill.step(view())
    assert step.status is SkillStatus.FAILURE
    assert "no target" in step.reason


def test_the_time_limit_holds() -> None:
    _, step = reckon(approach(timeout_s=2.0), {0.0: track_at(0.8, 0.0, 100.0)})
    assert step.status is SkillStatus.FAILURE
    assert "timed out after 2." in step.reason
    assert "m to go" in step.reason


def test_something_in_between_ends_it_but_not_for_a_moment_only() -> None:
    skill = approach()
    between = points((0.4, 0.05), (0.4, 0.0))
    track = track_at(0.8, 0.0, 100.0)
    skill.start(view(100.0, track=track, obstacles=between))
    first = skill.step(view(100.0, track=track, obstacles=between))
    assert first.status is SkillStatus.RUNNING
    assert first.twist.vx_mps == 0.0, "it does not drive at it meanwhile"
    assert skill.step(view(100.5, track=track)).twist.vx_mps > 0.0
    skill.step(view(101.0, track=track, obstacles=between))
    last = skill.step(view(102.1, track=track, obstacles=between))
    assert last.status is SkillStatus.FAILURE
    assert "obstacle in between" in last.reason


def test_what_is_left_of_the_target_itself_is_not_in_between() -> None:
    skill = approach()
    own = points((0.77, 0.02), (0.8, -0.04))
    track = track_at(0.8, 0.0, 100.0)
    skill.start(view(100.0, track=track, obstacles=own))
    for tick in range(40):
        step = skill.step(view(100.0 + tick * DT, track=track, obstacles=own))
        assert step.status is SkillStatus.RUNNING
        assert step.twist.vx_mps > 0.0


def test_a_target_that_jumps_away_was_pushed_aside() -> None:
    skill = approach()
    here, there = track_at(0.6, 0.0, 100.0, ranged_ago_s=0.0), track_at(0.6, 0.3, 102.0, ranged_ago_s=0.0)
    skill.start(view(100.0, track=here))
    skill.step(view(100.05, track=here))
    assert skill.step(view(101.9, track=there)).status is SkillStatus.RUNNING, "once may be a mistake"
    last = skill.step(view(102.5, track=there))
    assert last.status is SkillStatus.FAILURE
    assert "pushed aside" in last.reason


@settings(max_examples=50)
@given(
    st.floats(0.35, 1.2), st.floats(-0.3, 0.3), st.floats(-0.4, 0.4),
    st.builds(Twist2D, st.floats(-0.1, 0.1), st.floats(-0.1, 0.1), st.floats(-0.3, 0.3)),
)  # fmt: skip
def test_a_mirrored_world_is_approached_mirrored(
    ahead: float, left: float, yaw: float, twist: Twist2D
) -> None:
    pose = Pose2D(yaw_rad=yaw)
    seen = view(pose=pose, twist=twist, track=track_at(ahead, left, 100.0, pose))
    one, other = approach(), approach()
    one.start(seen)
    other.start(mirrored(seen))
    assert_mirrored(one.step(seen).twist, other.step(mirrored(seen)).twist)


anything = st.floats(allow_nan=True, allow_infinity=True)


@settings(max_examples=60)
@given(
    st.builds(Pose2D, anything, anything, anything),
    st.builds(Twist2D, anything, anything, anything),
    st.tuples(anything, anything),
    st.lists(st.tuples(anything, anything), max_size=4),
    st.sampled_from(["mecanum", "differential"]),
)
def test_whatever_it_is_told_its_velocity_stays_within_the_limits(
    pose: Pose2D, twist: Twist2D, target: tuple[float, float], cloud: list[tuple[float, float]], drive: str
) -> None:
    robot = CONFIG.override({"robot.drive": drive}).robot
    skill = approach(CONFIG.override({"robot.drive": drive}))
    skill.start(view(track=track_at(0.8, 0.0, 100.0)))
    step = skill.step(
        view(100.05, pose=pose, twist=twist, track=track_at(*target, 100.0), obstacles=points(*cloud))
    )
    assert step.twist.is_finite()
    assert abs(step.twist.vx_mps) <= robot.max_speed_mps
    assert abs(step.twist.vy_mps) <= (0.0 if drive == "differential" else robot.max_lateral_speed_mps)
    assert abs(step.twist.wz_radps) <= robot.max_yaw_rate_radps
