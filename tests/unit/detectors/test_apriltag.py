"""AprilTags: the right one is found, its range is right, and of two poses the heading tells the true one."""

from __future__ import annotations

import math

import numpy as np
import pytest

from target_nav.config import Config
from target_nav.detectors.apriltag import AprilTagDetector, AprilTagFinder
from target_nav.detectors.apriltag_pose import TagFacing, tag_poses
from target_nav.detectors.pipeline import DetectionPipeline
from target_nav.errors import ConfigError
from target_nav.state.types import RawDetectionFrame, TargetSpec
from target_nav.utils.frames import wrap_angle
from tests.unit.detectors.drawn_tags import picture_of_tag

CONFIG = Config()
CAMERA = CONFIG.camera
SIDE_M = 0.16
LABEL = "apriltag:7"


@pytest.mark.parametrize(("x_m", "y_m"), [(0.6, 0.0), (1.0, 0.3), (2.0, -0.7)])
@pytest.mark.parametrize("turned_rad", [0.0, 0.5])
def test_range_and_bearing_of_a_tag_are_what_they_are(x_m: float, y_m: float, turned_rad: float) -> None:
    picture = picture_of_tag(CAMERA, 7, SIDE_M, x_m, y_m, math.pi + turned_rad)
    boxes = AprilTagDetector(7, LABEL).detect(picture)
    spec = TargetSpec(LABEL, SIDE_M, SIDE_M)
    (seen,) = DetectionPipeline(CONFIG).process(RawDetectionFrame(0.0, 0, boxes), spec).detections
    assert seen.range_m == pytest.approx(math.hypot(x_m, y_m), rel=0.03)
    assert seen.bearing_rad == pytest.approx(math.atan2(y_m, x_m), abs=0.01)


def test_another_tag_is_not_the_target() -> None:
    picture = picture_of_tag(CAMERA, 8, SIDE_M, 1.0, 0.0, math.pi)
    assert AprilTagDetector(7, LABEL).detect(picture) == ()
    assert [tag.tag_id for tag in AprilTagFinder().find(picture)] == [8]


def test_a_picture_without_a_tag_has_none() -> None:
    assert AprilTagDetector(7, LABEL).detect(np.full((480, 640, 3), 90, np.uint8)) == ()


def test_the_family_ends_at_586() -> None:
    with pytest.raises(ConfigError, match="586"):
        AprilTagDetector(587, "apriltag:587")


@pytest.mark.parametrize("turned_rad", [-0.6, 0.0, 0.4])
def test_one_of_the_poses_is_the_true_one(turned_rad: float) -> None:
    facing_rad = wrap_angle(math.pi + turned_rad)
    (tag,) = AprilTagFinder().find(picture_of_tag(CAMERA, 7, SIDE_M, 1.2, 0.2, facing_rad))
    poses = tag_poses(tag, SIDE_M, CAMERA)
    assert 1 <= len(poses) <= 2
    best = min(poses, key=lambda pose: abs(wrap_angle(pose.facing_rad - facing_rad)))
    assert (best.x_m, best.y_m) == pytest.approx((1.2, 0.2), abs=0.02)
    assert abs(wrap_angle(best.facing_rad - facing_rad)) < 0.12


def test_while_the_robot_moves_only_the_true_pose_keeps_its_direction() -> None:
    """A tag that is turned by 30 degrees hangs 2.5 m away; the robot looks at it from places along an arc.

    Single pictures take the false solution now and then; over all of them the true direction wins.
    """
    true_facing = wrap_angle(math.pi + 0.52)
    belief = TagFacing()
    rng = np.random.default_rng(4)
    taken = []
    for side_m in np.linspace(-0.8, 0.8, 17):
        # The robot stands at (0, side) in odom and looks at the tag at (2.5, 0).
        heading = math.atan2(-side_m, 2.5)
        range_m = math.hypot(2.5, side_m)
        picture = picture_of_tag(CAMERA, 7, SIDE_M, range_m, 0.0, wrap_angle(true_facing - heading))
        noisy = np.clip(picture + rng.normal(0.0, 3.0, picture.shape), 0, 255).astype(np.uint8)
        for tag in AprilTagFinder().find(noisy):
            pose = belief.add(tag_poses(tag, SIDE_M, CAMERA), heading)
            assert pose is not None
            taken.append(abs(wrap_angle(pose.facing_rad + heading - true_facing)))
    assert len(taken) >= 12
    assert belief.facing_rad is not None
    assert abs(wrap_angle(belief.facing_rad - true_facing)) < 0.15
    assert np.median(taken[len(taken) // 2 :]) < 0.2


def test_a_tag_that_was_never_seen_faces_nowhere() -> None:
    belief = TagFacing()
    assert belief.facing_rad is None
    assert belief.add((), 0.0) is None
