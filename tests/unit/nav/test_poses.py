"""The buffer of poses: interpolates, extrapolates a little, and never invents."""

from __future__ import annotations

import dataclasses
import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from target_nav.nav.poses import PoseHistory, moved_by
from target_nav.state.types import STOP, Odometry, Pose2D, Twist2D
from target_nav.utils.frames import wrap_angle
from tests.unit.nav.scripted_world import Drive, World

TURNING = World(drive=Drive(Pose2D(1.0, 2.0, 3.0), ((5.0, Twist2D(0.2, -0.1, 0.5)),)))


def odometry(stamp_s: float, x_m: float = 0.0, yaw_rad: float = 0.0, twist: Twist2D = STOP) -> Odometry:
    return Odometry(stamp_s, Pose2D(x_m, 0.0, yaw_rad), twist)


def assert_same(first: Pose2D | None, second: Pose2D, tolerance: float = 1e-9) -> None:
    assert first is not None
    assert math.hypot(first.x_m - second.x_m, first.y_m - second.y_m) <= tolerance
    assert abs(wrap_angle(first.yaw_rad - second.yaw_rad)) <= tolerance


@given(st.floats(10.0, 13.0))
def test_a_pose_between_two_samples_is_within_a_millimetre_of_the_true_one(stamp_s: float) -> None:
    assert_same(TURNING.poses(13.0, since_s=9.0).at(stamp_s), TURNING.drive.pose(stamp_s), 1e-3)


def test_a_sample_is_given_back_as_it_was() -> None:
    history = TURNING.poses(11.0, since_s=9.0)
    assert_same(history.at(10.5), TURNING.odometry(10.5).pose_in_odom)


def test_yaw_is_interpolated_the_short_way_round() -> None:
    history = PoseHistory()
    history.add(odometry(1.0, yaw_rad=math.pi - 0.05, twist=Twist2D(0.0, 0.0, 2.0)))
    history.add(odometry(1.05, yaw_rad=-math.pi + 0.05, twist=Twist2D(0.0, 0.0, 2.0)))
    assert_same(history.at(1.025), Pose2D(0.0, 0.0, math.pi))
    rows = history.at_each(np.array([1.0, 1.025, 1.05]))
    assert rows is not None
    assert np.diff(rows[:, 2]) == pytest.approx([0.05, 0.05])


def test_beyond_both_ends_it_goes_on_with_the_twist_for_a_tenth_of_a_second_and_no_longer() -> None:
    history = TURNING.poses(12.0, since_s=11.0)
    assert_same(history.at(12.09), TURNING.drive.pose(12.09), 1e-4)
    assert_same(history.at(10.91), TURNING.drive.pose(10.91), 1e-4)
    assert history.at(12.11) is None
    assert history.at(10.89) is None


def test_nothing_is_known_inside_a_gap_of_odometry() -> None:
    history = PoseHistory()
    history.add(odometry(1.0))
    history.add(odometry(1.6, x_m=0.1))
    assert history.at(1.3) is None
    assert history.at_each(np.array([0.99, 1.3, 1.6])) is None
    assert_same(history.at(1.6), Pose2D(0.1, 0.0, 0.0))


def test_it_remembers_three_seconds() -> None:
    history = TURNING.poses(13.0, since_s=5.0)
    assert history.at(10.05) is not None
    assert history.at(9.8) is None


@given(st.lists(st.floats(9.95, 13.05), min_size=1, max_size=20))
def test_many_poses_at_once_are_the_single_ones(stamps: list[float]) -> None:
    history = TURNING.poses(13.0, since_s=10.0)
    rows = history.at_each(np.array(sorted(stamps)))
    assert rows is not None
    for stamp_s, (x_m, y_m, yaw_rad) in zip(sorted(stamps), rows):
        # A single pose beyond an end turns while it moves; many at once go straight to the last one.
        assert_same(history.at(stamp_s), Pose2D(x_m, y_m, yaw_rad), 1e-4)


@pytest.mark.parametrize("stamps", [[8.0, 9.5], [9.5, 13.2], [math.nan, math.nan], [9.0, math.inf]])
def test_many_poses_are_none_when_one_is_not_covered(stamps: list[float]) -> None:
    assert TURNING.poses(13.0, since_s=10.0).at_each(np.array(stamps)) is None


def test_an_empty_buffer_knows_nothing() -> None:
    history = PoseHistory()
    assert history.latest is None
    assert history.at(1.0) is None
    assert history.at_each(np.array([1.0])) is None
    assert history.predict(1.0) is None


@pytest.mark.parametrize(
    "bad",
    [
        odometry(math.nan),
        odometry(math.inf),
        odometry(2.0, x_m=math.nan),
        odometry(2.0, yaw_rad=math.inf),
        odometry(2.0, twist=Twist2D(0.0, math.nan, 0.0)),
    ],
)
def test_what_is_not_finite_is_ignored_and_counted(bad: Odometry) -> None:
    history = PoseHistory()
    history.add(odometry(1.0))
    history.add(bad)
    assert history.latest == odometry(1.0)
    assert history.rejected["non_finite"] == 1


def test_what_is_out_of_order_is_ignored_and_counted() -> None:
    history = PoseHistory()
    for stamp_s in (1.0, 1.05, 1.05, 1.0):
        history.add(odometry(stamp_s))
    assert history.latest is not None
    assert history.latest.stamp_s == 1.05
    assert history.rejected["out_of_order"] == 2


def test_one_wrong_stamp_far_ahead_does_not_blind_it_for_ever() -> None:
    history = TURNING.poses(10.0, since_s=9.0)
    history.add(odometry(5000.0))
    for index in range(1, 21):
        history.add(TURNING.odometry(10.0 + 0.05 * index))
    assert_same(history.at(11.0), TURNING.drive.pose(11.0))


def test_a_jump_starts_the_buffer_and_its_epoch_anew() -> None:
    history = TURNING.poses(12.0, since_s=10.0)
    epoch = history.epoch
    history.add(dataclasses.replace(TURNING.odometry(12.05), pose_in_odom=Pose2D()))
    assert history.epoch != epoch
    assert history.at(12.0) is not None  # extrapolated from the new origin, not interpolated across the jump
    assert_same(history.at(12.05), Pose2D())
    assert history.at(11.9) is None
    assert history.rejected["jump"] == 1


def test_the_fastest_start_the_robot_is_capable_of_is_no_jump_even_when_messages_are_lost() -> None:
    history = PoseHistory()
    history.add(odometry(1.0))
    epoch = history.epoch
    history.add(odometry(1.3, x_m=0.5 * 1.2 * 0.3**2, twist=Twist2D(0.36, 0.0, 0.0)))
    assert history.epoch == epoch


def test_clearing_changes_the_epoch() -> None:
    history = TURNING.poses(10.0, since_s=9.0)
    epoch = history.epoch
    history.clear()
    assert history.latest is None
    assert history.epoch != epoch


def test_prediction_moves_the_newest_pose_on_but_not_for_ever() -> None:
    history = TURNING.poses(12.0, since_s=10.0)
    assert_same(history.predict(12.1), TURNING.drive.pose(12.1), 1e-4)
    assert_same(history.predict(100.0), TURNING.drive.pose(12.25), 1e-3)
    assert_same(history.predict(11.52), TURNING.drive.pose(11.52), 1e-3)
    assert history.predict(math.nan) is None


@given(st.floats(-1.0, 1.0), st.floats(-1.0, 1.0), st.floats(-2.0, 2.0), st.floats(-0.25, 0.25))
def test_moving_by_a_twist_and_back_ends_where_it_began(vx: float, vy: float, wz: float, dt_s: float) -> None:
    pose, twist = Pose2D(0.3, -0.2, 1.0), Twist2D(vx, vy, wz)
    assert_same(moved_by(moved_by(pose, twist, dt_s), twist, -dt_s), pose)
