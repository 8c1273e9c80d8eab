"""Targets that have been dealt with: what the camera sees of them is left out before the tracker looks at it.

A visited target stands where it stood, but the camera's range to it is off by a few per cent, more in metres the
farther it is away; so the gate is long along the line of sight and narrow across it.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace

from target_nav.nav.poses import PoseHistory
from target_nav.state.types import Detection, DetectionFrame, Pose2D
from target_nav.utils.frames import compose, to_child, wrap_angle

Places = Sequence[tuple[float, float]]
"""In odom, metres."""

VISITED_RADIUS_M = 0.30
"""Two targets nearer to each other than this count as one."""
RANGE_SHARE = 0.15
"""Three sigma of a monocular range, and a wrong focal length (measured 4.4 %)."""
BEARING_RAD = 0.04
"""Three sigma of a bearing, and the mount's error."""


def without_visited(
    frame: DetectionFrame | None, poses: PoseHistory, camera_in_base: Pose2D, visited: Places
) -> DetectionFrame | None:
    """The frame without the detections that are of a visited target. One that cannot be placed yet stays whole."""
    if frame is None or not visited:
        return frame
    pose = poses.at(frame.stamp_s)
    if pose is None:
        return frame
    camera_in_odom = compose(pose, camera_in_base)
    seen = [to_child(camera_in_odom, *place) for place in visited]
    kept = tuple(d for d in frame.detections if not any(_is_of(d, x, y) for x, y in seen))
    return frame if len(kept) == len(frame.detections) else replace(frame, detections=kept)


def _is_of(detection: Detection, x_m: float, y_m: float) -> bool:
    """Whether a detection may be of the target at (x, y) in the camera's frame."""
    range_m = math.hypot(x_m, y_m)
    off_rad = wrap_angle(detection.bearing_rad - math.atan2(y_m, x_m))
    if (
        abs(off_rad) > math.pi / 2.0
        or abs(range_m * math.sin(off_rad)) > VISITED_RADIUS_M + BEARING_RAD * range_m
    ):
        return False
    # a clipped box's range says nothing, but what is clipped is near
    return detection.clipped or abs(detection.range_m - range_m) <= VISITED_RADIUS_M + RANGE_SHARE * range_m
