"""Going to straight before a face: where that is, that it is gone to round what stands in the way, and not for ever."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from target_nav.config import Config
from target_nav.nav.face_on import LAST_STRETCH_M, SQUARE_THERE_RAD, face_spots, off_square_rad, straight_onto
from target_nav.nav.footprint import Footprint
from target_nav.nav.navigate import NavigateToTarget
from target_nav.nav.skill import SkillStatus, View
from target_nav.state.types import Pose2D
from target_nav.utils.frames import points_to_parent, to_parent, wrap_angle
from tests.unit.nav.toy_world import Segment, ToyWorld, box, room
from tests.unit.nav.views import points

CONFIG = Config()
BODY = Footprint.of(CONFIG.robot)
NOTHING = np.empty((0, 2))
PIN = (0.8, 0.3)
angles = st.floats(-math.pi, math.pi)
metres = st.floats(-5.0, 5.0)


def spots(target_m: tuple[float, float], facing_rad: float, points_m: np.ndarray = NOTHING) -> np.ndarray:
    return face_spots(
        target_m, points_m, BODY, facing_rad=facing_rad, stand_off_m=0.1, farthest_m=0.68, margin_m=0.05
    )


class FacedWorld(ToyWorld):
    """The target has a face that looks to `facing_rad` in the world; None: the detector does not know."""

    facing_rad: float | None = None

    def view(self) -> View:
        seen = super().view()
        if seen.track is None or self.facing_rad is None:
            return seen
        in_odom = wrap_angle(self.facing_rad - self.true_pose.yaw_rad + self.pose_in_odom.yaw_rad)
        return replace(seen, track=replace(seen.track, facing_in_odom_rad=in_odom, facing_sigma_rad=0.03))


def run(
    facing_rad: float | None,
    walls: Sequence[Segment] = (),
    *,
    from_face: bool = True,
    drive: str = "mecanum",
    lost_after_s: float = 3.0,
) -> tuple[FacedWorld, SkillStatus, str]:
    config = CONFIG.override({"robot.drive": drive})
    world = FacedWorld([*room(), *walls], pin=PIN, start=Pose2D(-1.5, 0.0, 0.1), seed=5, config=config)
    world.facing_rad = facing_rad
    skill = NavigateToTarget(
        config, cruise_speed_mps=0.2, until_range_m=0.8, lost_after_s=lost_after_s, from_face=from_face
    )
    step = world.run(skill, 120.0)
    return world, step.status, step.reason


def off_true(world: FacedWorld, facing_rad: float) -> float:
    return abs(off_square_rad(world.true_pose, PIN, facing_rad))


@pytest.mark.parametrize("aside_deg", [-60, 0, 40])
def test_it_ends_straight_before_the_face(aside_deg: float) -> None:
    facing_rad = wrap_angle(math.pi + math.radians(aside_deg))
    world, status, reason = run(facing_rad)
    assert status is SkillStatus.SUCCESS, reason
    assert off_true(world, facing_rad) < SQUARE_THERE_RAD
    assert "deg from straight before its face" in reason
    assert math.dist((world.true_pose.x_m, world.true_pose.y_m), PIN) < 0.85
    assert world.min_clearance_m > 0.01


def test_a_base_that_cannot_strafe_does_so_too() -> None:
    facing_rad = wrap_angle(math.pi + 0.6)
    world, status, reason = run(facing_rad, drive="differential")
    assert status is SkillStatus.SUCCESS, reason
    assert off_true(world, facing_rad) < SQUARE_THERE_RAD


def test_round_a_box_in_the_way() -> None:
    facing_rad = math.pi - 0.9
    world, status, reason = run(facing_rad, box(-0.1, 0.35, 0.25, 0.25))
    assert status is SkillStatus.SUCCESS, reason
    assert off_true(world, facing_rad) < SQUARE_THERE_RAD
    assert world.min_clearance_m > 0.01


def test_without_a_known_face_it_goes_the_short_way_and_says_so() -> None:
    world, status, reason = run(None)
    plain, plain_status, _ = run(None, from_face=False)
    assert status is plain_status is SkillStatus.SUCCESS
    assert "where its face looks is not known" in reason
    assert world.true_pose == plain.true_pose


def test_a_facing_that_is_no_number_is_none() -> None:
    _, status, reason = run(math.nan)
    assert status is SkillStatus.SUCCESS
    assert "where its face looks is not known" in reason


def test_a_face_nobody_asked_for_changes_nothing() -> None:
    world, status, reason = run(math.pi / 2.0, from_face=False)
    plain, _, plain_reason = run(None, from_face=False)
    assert (world.true_pose, reason) == (plain.true_pose, plain_reason)
    assert "face" not in reason
    assert status is SkillStatus.SUCCESS


def test_a_place_before_the_face_that_cannot_be_reached_is_given_up_with_a_reason() -> None:
    facing_rad = math.pi / 2.0
    # A box fills the place before the face, from the target to where it would have to stand.
    world, status, reason = run(facing_rad, box(PIN[0], PIN[1] + 0.5, 0.5, 0.5), lost_after_s=300.0)
    assert status is SkillStatus.FAILURE
    assert "stuck" in reason
    assert "no way to the place before the target's face" in reason
    assert world.min_clearance_m > 0.01


@given(metres, metres, angles)
def test_spots_lie_on_the_normal_the_farthest_the_cheapest(x_m: float, y_m: float, facing_rad: float) -> None:
    found = spots((x_m, y_m), facing_rad)
    assert len(found) > 1
    for spot_x, spot_y, _ in found:
        assert abs(off_square_rad(Pose2D(spot_x, spot_y), (x_m, y_m), facing_rad)) < 1e-6
    away_m = np.hypot(found[:, 0] - x_m, found[:, 1] - y_m)
    assert (np.diff(found[np.argsort(away_m), 2]) < 0.0).all()
    assert found[:, 2].min() == pytest.approx(0.0, abs=1e-9)


def test_what_stands_on_the_normal_leaves_the_spots_before_it_or_none() -> None:
    assert len(spots((0.0, 0.0), 0.0, points((0.4, 0.0)))) == 0
    behind = spots((0.0, 0.0), 0.0, points((-0.05, 0.0), (-0.05, 0.3)))
    assert len(behind) == len(spots((0.0, 0.0), 0.0))


@given(metres, metres, angles, angles, metres, metres)
def test_being_off_square_does_not_depend_on_the_frame(
    x_m: float, y_m: float, facing_rad: float, yaw_rad: float, robot_x_m: float, robot_y_m: float
) -> None:
    frame = Pose2D(1.0, -2.0, yaw_rad)
    (target_x, target_y), (other_x, other_y) = points_to_parent(
        frame, np.array([(x_m, y_m), (robot_x_m, robot_y_m)])
    )
    here = off_square_rad(Pose2D(robot_x_m, robot_y_m), (x_m, y_m), facing_rad)
    there = off_square_rad(Pose2D(other_x, other_y), (target_x, target_y), facing_rad + yaw_rad)
    if math.dist((x_m, y_m), (robot_x_m, robot_y_m)) > 1e-3:
        assert abs(wrap_angle(here - there)) < 1e-6


@given(angles, st.floats(0.0, 2.0), angles)
def test_the_last_stretch_is_straight_if_it_is_short_and_free(
    yaw_rad: float, way_m: float, direction_rad: float
) -> None:
    pose = Pose2D(0.5, -0.5, yaw_rad)
    spot = to_parent(pose, way_m * math.cos(direction_rad), way_m * math.sin(direction_rad))
    found = straight_onto(pose, spot, NOTHING, BODY, 0.05)
    assert (found is not None) == (math.hypot(*(found or (way_m, 0.0))) <= LAST_STRETCH_M)
    if way_m > LAST_STRETCH_M + 1e-6:
        assert found is None


def test_the_last_stretch_is_not_straight_through_a_box() -> None:
    ahead = (0.3, 0.0)
    blocking = points((BODY.front_m + 0.1, 0.0))
    assert straight_onto(Pose2D(), ahead, blocking, BODY, 0.05) is None
    assert straight_onto(Pose2D(), ahead, points((-1.0, 0.0)), BODY, 0.05) == pytest.approx(ahead)
