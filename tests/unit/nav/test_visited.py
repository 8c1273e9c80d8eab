"""What the camera sees of a visited target is left out, and nothing else."""

from __future__ import annotations

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from target_nav.nav.poses import PoseHistory
from target_nav.nav.visited import without_visited
from target_nav.state.types import STOP, Detection, DetectionFrame, Odometry, Pose2D

CAMERA = Pose2D(0.12, 0.0, 0.0)
ORIGIN = Pose2D()
STAMP_S = 10.0


def poses(pose: Pose2D) -> PoseHistory:
    history = PoseHistory()
    for stamp_s in (STAMP_S - 0.1, STAMP_S, STAMP_S + 0.1):
        history.add(Odometry(stamp_s, pose, STOP))
    return history


def seen(range_m: float, bearing_rad: float = 0.0, clipped: bool = False) -> Detection:
    return Detection(
        "bowling_pin", 0.9, 1, 320.0, 240.0, 40.0, 140.0, range_m, 0.04 * range_m, bearing_rad, 0.01, clipped, True
    )  # fmt: skip


def kept(*detections: Detection, visited: list[tuple[float, float]], pose: Pose2D = ORIGIN) -> int:
    frame = without_visited(DetectionFrame(STAMP_S, 1, detections), poses(pose), CAMERA, visited)
    assert frame is not None
    return len(frame.detections)


def test_a_visited_target_is_left_out_from_wherever_it_is_seen() -> None:
    for pose, bearing in ((Pose2D(), 0.0), (Pose2D(0.0, 0.0, 0.3), -0.3), (Pose2D(4.12, 0.0, math.pi), 0.0)):
        range_m = math.hypot(2.0 - pose.x_m, pose.y_m) - 0.12 * math.cos(bearing)
        assert kept(seen(range_m, bearing), visited=[(2.0, 0.0)], pose=pose) == 0


@given(st.floats(0.5, 4.0), st.floats(-3.0, 3.0), st.floats(-0.4, 0.4))
def test_it_is_left_out_with_the_errors_that_a_camera_has(
    range_m: float, sigmas: float, bearing: float
) -> None:
    place = (0.12 + range_m * math.cos(bearing), range_m * math.sin(bearing))
    measured = seen(range_m * (1.0 + 0.04 * sigmas), bearing + 0.01 * sigmas)
    assert kept(measured, visited=[place]) == 0


@pytest.mark.parametrize("other", [(2.9, 0.0), (2.0, 0.6), (2.0, -0.6), (1.0, 0.0), (1.2, 0.7)])
def test_another_target_stays(other: tuple[float, float]) -> None:
    range_m, bearing = math.hypot(other[0] - 0.12, other[1]), math.atan2(other[1], other[0] - 0.12)
    assert kept(seen(range_m, bearing), visited=[(2.0, 0.0)]) == 1


def test_a_clipped_box_in_that_direction_is_left_out_whatever_range_it_claims() -> None:
    assert kept(seen(1.5, 0.0, clipped=True), visited=[(0.4, 0.0)]) == 0
    assert kept(seen(1.5, 0.9, clipped=True), visited=[(2.0, 0.0)]) == 1


def test_what_stands_behind_the_robot_is_not_what_it_sees_ahead() -> None:
    assert kept(seen(2.0), visited=[(-2.0, 0.0)]) == 1


def test_nothing_visited_or_no_pose_leaves_the_frame_as_it_is() -> None:
    frame = DetectionFrame(STAMP_S, 1, (seen(1.0),))
    assert without_visited(frame, poses(Pose2D()), CAMERA, []) is frame
    assert without_visited(frame, PoseHistory(), CAMERA, [(1.12, 0.0)]) is frame
    assert without_visited(None, poses(Pose2D()), CAMERA, [(1.0, 0.0)]) is None
