"""Where a face looks: of the two poses of every picture the true one wins, and the sigma is what it is worth."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from target_nav.nav.facing import FaceLook, FacingBelief, looks_of
from target_nav.state.types import Detection, Facing, TargetSpec
from target_nav.utils.frames import wrap_angle
from tests.unit.nav.scripted_world import detection
from tests.unit.nav.tracker_feed import Feed, pin_at

FOCAL_PX = 554.0
angles = st.floats(-math.pi, math.pi)


def seen(height_px: float = 60.0, bearing_rad: float = 0.0, *facings: Facing) -> Detection:
    box = replace(detection(1.5, bearing_rad), height_px=height_px)
    return replace(box, **dict(zip(("facing", "other_facing"), facings)))


def look(facing_rad: float, other_rad: float, error_px: float = 0.2, other_px: float = 0.2) -> list[FaceLook]:
    return list(
        looks_of(seen(60.0, 0.0, Facing(facing_rad, error_px), Facing(other_rad, other_px)), FOCAL_PX)
    )


def off(belief: FacingBelief, true_rad: float) -> float:
    assert belief.estimate is not None
    return abs(wrap_angle(belief.estimate.facing_in_odom_rad - true_rad))


@settings(max_examples=60, deadline=None)
@given(true_rad=angles, first_rad=angles, turned_rad=st.floats(0.35, 1.0))
def test_of_two_poses_that_fit_alike_driving_round_tells_the_true_one(
    true_rad: float, first_rad: float, turned_rad: float
) -> None:
    """The robot sees the face from an arc of 60 degrees; the false pose is the mirror image each time."""
    belief = FacingBelief()
    for step in range(40):
        # Direction from the target to the robot, and where the camera looks: at the target.
        to_robot_rad = true_rad - turned_rad + math.radians(1.5) * step
        camera_yaw_rad = wrap_angle(to_robot_rad + math.pi)
        in_camera_rad = wrap_angle(true_rad - camera_yaw_rad)
        mirrored_rad = wrap_angle(2.0 * math.pi - in_camera_rad)
        pair = (in_camera_rad, mirrored_rad) if step % 2 else (mirrored_rad, in_camera_rad)
        belief.add(look(*pair), camera_yaw_rad)
    assert off(belief, true_rad) < 0.06


def test_from_one_place_alone_two_poses_that_fit_alike_stay_undecided() -> None:
    belief = FacingBelief()
    for _ in range(50):
        belief.add(look(math.pi - 0.6, math.pi + 0.6), 0.0)
    assert belief.estimate is None


def test_from_one_place_the_pose_that_fits_clearly_better_is_the_true_one() -> None:
    belief = FacingBelief()
    for _ in range(5):
        belief.add(look(math.pi - 0.6, math.pi + 0.6, 0.1, 1.0), 0.0)
    assert off(belief, math.pi - 0.6) < 0.02


def test_two_poses_close_together_are_told_as_their_middle_with_the_sigma_of_both() -> None:
    belief = FacingBelief()
    for _ in range(20):
        belief.add(look(math.pi - 0.15, math.pi + 0.15), 0.0)
    assert off(belief, math.pi) < 0.03
    assert belief.estimate is not None
    assert belief.estimate.sigma_rad > 0.1


@settings(max_examples=40, deadline=None)
@given(facing_rad=angles, yaw_rad=angles)
def test_turning_everything_turns_the_answer(facing_rad: float, yaw_rad: float) -> None:
    straight, turned = FacingBelief(), FacingBelief()
    looks = [FaceLook(facing_rad, 0.05, 0.9), FaceLook(-facing_rad + 1.0, 0.05, 0.1)]
    for _ in range(3):
        straight.add(looks, 0.0)
        turned.add(looks, yaw_rad)
    if straight.estimate is not None and turned.estimate is not None:
        # A bin is one degree; a peak that falls between two of them is off by a part of it.
        assert off(turned, straight.estimate.facing_in_odom_rad + yaw_rad) < 0.02


def test_sigma_is_honest_for_noise_as_large_as_said() -> None:
    """Normalised error squared over many runs of eight pictures, all independent: one, or less as it is careful."""
    rng = np.random.default_rng(3)
    squares = []
    for _ in range(300):
        belief = FacingBelief()
        for _ in range(8):
            belief.add([FaceLook(0.7 + 0.08 * rng.standard_normal(), 0.08, 1.0)], 0.2)
        assert belief.estimate is not None
        squares.append((off(belief, 0.9) / belief.estimate.sigma_rad) ** 2)
    assert 0.1 < np.mean(squares) < 1.2


def test_it_follows_a_heading_that_drifts() -> None:
    belief = FacingBelief()
    for step in range(400):
        belief.add([FaceLook(math.pi, 0.05, 1.0)], 0.001 * step)
    assert off(belief, math.pi + 0.4) < 0.08


def test_nothing_said_is_nothing_known() -> None:
    belief = FacingBelief()
    belief.add((), 0.0)
    belief.add([FaceLook(1.0, 0.1, 1.0)], math.nan)
    assert belief.estimate is None
    assert looks_of(seen(), FOCAL_PX) == ()
    assert looks_of(seen(60.0, 0.0, Facing(math.nan, 0.1), Facing(1.0, math.inf)), FOCAL_PX) == ()


@given(
    st.floats(1.0, 2000.0), st.floats(-0.5, 0.5), angles, angles, st.floats(0.0, 50.0), st.floats(0.0, 50.0)
)
def test_weights_sum_to_one_and_the_better_fit_weighs_more(
    height_px: float, bearing_rad: float, one_rad: float, other_rad: float, one_px: float, other_px: float
) -> None:
    looks = looks_of(
        seen(height_px, bearing_rad, Facing(one_rad, one_px), Facing(other_rad, other_px)), FOCAL_PX
    )
    assert sum(each.weight for each in looks) == pytest.approx(1.0)
    assert (looks[0].weight >= looks[1].weight) == (one_px <= other_px) or one_px == other_px
    assert all(0.0 < each.sigma_rad <= math.pi for each in looks)


def test_nearer_and_more_aslant_is_more_exact() -> None:
    def sigma_rad(height_px: float, turned_rad: float) -> float:
        return looks_of(seen(height_px, 0.0, Facing(math.pi + turned_rad, 0.1)), FOCAL_PX)[0].sigma_rad

    assert sigma_rad(120.0, 0.0) < sigma_rad(60.0, 0.0) < sigma_rad(30.0, 0.0)
    assert sigma_rad(60.0, 0.7) < sigma_rad(60.0, 0.2) < sigma_rad(60.0, 0.0)


def faced(*facings: Facing) -> Detection:
    return replace(pin_at(2.0), **dict(zip(("facing", "other_facing"), facings)))


def test_the_track_says_where_the_face_looks_and_of_a_pin_nothing() -> None:
    feed = Feed()
    track = feed.steps(8, faced(Facing(math.pi - 0.5, 0.05), Facing(math.pi + 0.5, 1.2)))
    assert track is not None
    assert track.facing_in_odom_rad is not None
    assert track.facing_sigma_rad is not None
    assert abs(wrap_angle(track.facing_in_odom_rad - (math.pi - 0.5))) < 0.05
    plain = Feed().steps(8, pin_at(2.0))
    assert plain is not None
    assert plain.facing_in_odom_rad is None
    assert plain.facing_sigma_rad is None


def test_another_target_and_a_long_absence_forget_the_face() -> None:
    known = Facing(math.pi - 0.5, 0.05)
    for forget in ("target", "time"):
        feed = Feed()
        feed.steps(8, faced(known))
        if forget == "time":
            feed.wait(30.0)
            track = feed.steps(8, pin_at(2.0))
        else:
            feed.step(spec=TargetSpec("bowling_pin", 0.30, 0.09))
            track = feed.steps(8, pin_at(2.0))
        assert track is not None
        assert track.facing_in_odom_rad is None, forget
