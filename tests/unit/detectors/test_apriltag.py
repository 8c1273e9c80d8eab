"""AprilTags: the right one is found, its range is right, and of two poses the heading tells the true one."""

from __future__ import annotations

import dataclasses
import math

import numpy as np
import pytest

from target_nav.config import Config
from target_nav.detectors.apriltag import AprilTagDetector, AprilTagFinder
from target_nav.detectors.apriltag_pose import tag_facings, tag_poses
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
    poses = tag_poses(tag.corners_px, SIDE_M, CAMERA)
    assert 1 <= len(poses) <= 2
    best = min(poses, key=lambda pose: abs(wrap_angle(pose.facing_rad - facing_rad)))
    assert (best.x_m, best.y_m) == pytest.approx((1.2, 0.2), abs=0.02)
    assert abs(wrap_angle(best.facing_rad - facing_rad)) < 0.12


def test_both_poses_travel_with_the_box_to_the_nav_process() -> None:
    facing_rad = wrap_angle(math.pi + 0.4)
    picture = picture_of_tag(CAMERA, 7, SIDE_M, 1.2, 0.2, facing_rad)
    boxes = AprilTagDetector(7, LABEL, CAMERA).detect(picture)
    spec = TargetSpec(LABEL, SIDE_M, SIDE_M)
    (seen,) = DetectionPipeline(CONFIG).process(RawDetectionFrame(0.0, 0, boxes), spec).detections
    assert seen.facing is not None
    assert seen.other_facing is not None
    assert seen.facing.error_px <= seen.other_facing.error_px
    assert abs(wrap_angle(seen.facing.facing_rad - facing_rad)) < 0.1
    # The other is about the mirror image of the first: turned as far to the other side of the line of sight.
    middle = wrap_angle(seen.bearing_rad + math.pi)
    assert wrap_angle(seen.other_facing.facing_rad - middle) * wrap_angle(facing_rad - middle) < 0.0


def test_where_the_face_looks_does_not_depend_on_the_size_of_the_tag() -> None:
    (tag,) = AprilTagFinder().find(picture_of_tag(CAMERA, 7, SIDE_M, 1.2, 0.2, math.pi + 0.4))
    small, large = (tag_poses(tag.corners_px, side_m, CAMERA)[0] for side_m in (0.05, 1.0))
    assert small.facing_rad == pytest.approx(large.facing_rad, abs=1e-6)


@pytest.mark.parametrize("aspect", [0.9, 1.1])
def test_pixels_that_are_not_square_and_a_middle_that_is_not_the_middle(aspect: float) -> None:
    camera = dataclasses.replace(CAMERA, pixel_aspect=aspect, center_right_px=12.0, center_down_px=-9.0)
    (tag,) = AprilTagFinder().find(picture_of_tag(CAMERA, 7, SIDE_M, 1.2, 0.2, math.pi + 0.4))
    middle = np.array([CAMERA.center_u_px, CAMERA.center_v_px])
    corners = (tag.corners_px - middle) * (1.0, aspect) + (camera.center_u_px, camera.center_v_px)
    plain, other = (tag_facings(c, k)[0] for c, k in ((tag.corners_px, CAMERA), (corners, camera)))
    assert other.facing_rad == pytest.approx(plain.facing_rad, abs=1e-6)
