"""One thing that may be the target: its filters and its record.

It has two filters once a LiDAR cluster was taken for it: one of everything, and one of the camera alone. The second
judges the first. A cluster must agree with both, and when they no longer agree with each other, the LiDAR was on a
chair leg, and what it said is forgotten.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field

from target_nav.nav.facing import FacingBelief
from target_nav.nav.lidar_clusters import TargetFix
from target_nav.nav.tracker_filter import CameraExpectation, CameraMeasurement, TargetFilter
from target_nav.state.types import Pose2D

DOUBTS = 3
"""So many scans in a row in which the camera alone prefers another cluster: 0.55 s."""
CAMERA_MEMORY_M, LIDAR_MEMORY_M = 0.5, 0.04
"""Over so much way a filter remembers where the target was: over many frames, and over the last scan or two.

Most of odometry's drift is a wrong scale, and so grows with the way as a line and not as its root. As a random walk it
must be as large as it becomes over a filter's memory: its variance for each metre is proportional to the memory."""
TURN_WAY_M = 0.15
"""A radian of turning counts as so much way: it moves a corner of the base by that, and so do the wheels."""
FIX_SLACK_M = 0.01
"""Between what a filter expects and a fix, beyond both covariances: unmodelled shape and timing."""


@dataclass(frozen=True)
class Travel:
    """Time, way and turning so far; the difference of two is what odometry may have drifted in between."""

    time_s: float = 0.0
    way_m: float = 0.0
    turned_rad: float = 0.0


@dataclass(eq=False)
class Candidate:
    camera: TargetFilter
    """What the camera alone says."""
    since: Travel
    """When the filters' covariances were last brought up to date."""
    last_seen_s: float
    hits: int = 0
    looks: int = 0
    """Frames that had it in the picture, found or not."""
    misses: int = 0
    """Frames in a row in which the camera should have found it and did not."""
    confirmed: bool = False
    last_ranged_s: float = -math.inf
    last_fix: TargetFix | None = None
    taken: Travel = Travel()
    """When the last cluster was taken."""
    doubts: int = 0
    """Scans in a row in which the camera alone preferred another cluster."""
    fused: TargetFilter | None = None
    """What camera and LiDAR say together, since the first cluster that was taken."""
    face: FacingBelief = field(default_factory=lambda: FacingBelief())
    """Where its face looks, if it has one. (By name, so that a benchmark can put another belief in its place.)"""

    @property
    def filter(self) -> TargetFilter:
        """What is believed."""
        return self.fused or self.camera

    def growth(self, robot: Pose2D, travel: Travel) -> tuple[float, float, float]:
        """What has come to the position's covariance since the filters were last brought up to date."""
        return self._growth_of(self.filter, robot, travel)

    def _growth_of(
        self, target_filter: TargetFilter, robot: Pose2D, travel: Travel
    ) -> tuple[float, float, float]:
        share = 1.0
        if target_filter is self.fused:
            # A filter whose last fix is farther back remembers by the camera again.
            way_m = travel.way_m - self.taken.way_m + TURN_WAY_M * (travel.turned_rad - self.taken.turned_rad)
            share = min(max(way_m, LIDAR_MEMORY_M) / CAMERA_MEMORY_M, 1.0)
        return target_filter.growth(
            robot,
            max(travel.time_s - self.since.time_s, 0.0),
            travel.way_m - self.since.way_m,
            travel.turned_rad - self.since.turned_rad,
            share,
        )

    def catch_up(self, robot: Pose2D, travel: Travel) -> None:
        """Bring the filters up to date; before any of the methods below."""
        if travel != self.since:
            camera_growth = self._growth_of(self.camera, robot, travel)
            if self.fused is not None:
                self.fused.predict(self._growth_of(self.fused, robot, travel))
            self.camera.predict(camera_growth)
            self.since = travel

    def see(
        self, camera_in_odom: Pose2D, expected: CameraExpectation, measurement: CameraMeasurement, gate: float
    ) -> None:
        """Take a detection that `expected`, which the camera's filter made, lets through."""
        self.camera.update_camera(expected, measurement)
        self.face.add(measurement.looks, camera_in_odom.yaw_rad)
        if self.fused is None:
            return
        fused = self.fused.expect(camera_in_odom)
        if fused is not None and fused.distance(measurement)[0] <= gate:
            self.fused.update_camera(fused, measurement)
        if self.camera.position_distance(self.fused.x_m, self.fused.y_m) > gate:
            self.forget_lidar()

    def distances(self, fix: TargetFix) -> tuple[float, float]:
        """Squared Mahalanobis distance of a fix from what is believed, and from what the camera alone says."""
        xx, xy, yx, yy = fix.gate_covariance_m2
        widened = (xx + FIX_SLACK_M**2, xy, yx, yy + FIX_SLACK_M**2)
        believed, camera = self.filter, self.camera
        return (
            believed.position_distance(*fix.nearest_to(believed.x_m, believed.y_m), widened),
            camera.position_distance(*fix.nearest_to(camera.x_m, camera.y_m), widened),
        )

    def doubt_lidar(self) -> None:
        """There is a cluster that suits the camera better than the one that suits what is believed."""
        self.doubts += 1
        if self.doubts >= DOUBTS:
            self.forget_lidar()

    def forget_lidar(self) -> None:
        """Go back to what the camera alone says."""
        self.fused = self.last_fix = None
        self.last_ranged_s = -math.inf
        self.doubts = 0

    def take(self, fix: TargetFix) -> None:
        """Take a fix that agrees with both filters."""
        self.fused = self.fused or self.camera.copy()
        self.fused.update_position(fix.x_m, fix.y_m, fix.covariance_m2)
        self.last_ranged_s = fix.stamp_s
        self.taken = self.since

    def range_from(self, pose: Pose2D) -> float:
        return math.hypot(self.filter.x_m - pose.x_m, self.filter.y_m - pose.y_m)
