"""Where the target is: detections that come late, and LiDAR clusters, fused in odom.

Every measurement is placed with the robot's pose at its own stamp. What the camera sees decides that there is a
target (`confirmed`, `last_seen_s`); the LiDAR says only where it is (`last_ranged_s`). A target that is not seen stays
where it was, less and less surely the farther the robot drives, until it counts as lost.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

from target_nav.config import Config
from target_nav.nav.facing import looks_of
from target_nav.nav.lidar_clusters import PolarView, polar_view, target_fixes
from target_nav.nav.poses import PoseHistory
from target_nav.nav.scan_points import ScanPlacer
from target_nav.nav.tracker_candidate import Candidate, Travel
from target_nav.nav.tracker_candidates import EDGE_RAD, RANGED_FROM_HITS, CandidateSet
from target_nav.nav.tracker_filter import CameraExpectation, CameraMeasurement
from target_nav.state.types import Detection, DetectionFrame, Odometry, Pose2D, Scan, TargetSpec, Track
from target_nav.utils.frames import compose, wrap_angle

SIZE_TOLERANCE = 0.35
"""|ln(height of the box / height the target has at that range)|: another object, or a range meant for another target.
Box jitter of 5 % and a focal length that is 4 % off leave plenty of room."""
MIN_RANGE_SIGMA = 0.01
"""Of the range. No detector's box is steadier than that."""
MIN_BEARING_SIGMA_RAD = 0.003
STAMP_SIGMA_S = 0.02
"""Exposure, rolling shutter and clock mapping: while turning, a stamp's error is a bearing's error."""
FUTURE_S = 0.05
"""A measurement from farther ahead than this has a wrong clock."""
MAX_DETECTIONS = 16
"""Of one frame and the right class, the best by score."""
FULLY_VISIBLE_FROM_M = 0.45
"""Nearer, the picture clips the reference target."""
SURELY_FOUND_SHARE = 0.7
"""Of `camera.max_range_m`: up to here a missing detection means something."""
OCCLUDER_M = 0.20
"""A return so much nearer than the target hides it."""
SCAN_MEMORY_S = 0.6
"""How long a scan tells what hides what."""


class TargetTracker:
    """Call `update` once a tick. The newest frame and scan may be handed in again and again: each is used once."""

    def __init__(self, config: Config, placer: ScanPlacer | None = None) -> None:
        """`placer` places scans, one of its own if none is given."""
        self._config = config
        self._placer = placer or ScanPlacer(config.lidar)
        self._camera_in_base = Pose2D(config.camera.x_m, config.camera.y_m, config.camera.yaw_rad)
        self._spec: TargetSpec | None = None
        self._epoch = -1
        self.rejected: dict[str, int] = {
            "non_finite": 0, "negative": 0, "size": 0, "too_far": 0, "stamp": 0, "unplaced": 0, "unmatched": 0,
        }  # fmt: skip
        """Inputs not used, by reason, and detections that fitted no candidate, since the start."""
        self.reset()

    def reset(self) -> None:
        """Forget every target."""
        self._candidates = CandidateSet(self._config)
        self._travel = Travel()
        self._last_odometry: Odometry | None = None
        self._frame_stamp_s = -math.inf
        self._scan_stamp_s = -math.inf
        self._view: PolarView | None = None

    def forget_near(self, places_m: Sequence[tuple[float, float]], radius_m: float) -> None:
        """Forget the targets that are so near to one of the places, in odom."""
        self._candidates.forget_near(places_m, radius_m)

    def update(
        self,
        now_s: float,
        poses: PoseHistory,
        spec: TargetSpec,
        detections: DetectionFrame | None,
        scan: Scan | None,
    ) -> Track | None:
        """Take what is new and say where the target is at `now_s`; None: no idea, or no odometry.

        Another `spec`, or a jump of odometry, forgets every target first.
        """
        if not (math.isfinite(now_s) and now_s >= 0.0):
            self.rejected["non_finite" if not math.isfinite(now_s) else "negative"] += 1
            return None
        if spec != self._spec or poses.epoch != self._epoch:
            self.reset()
            self._spec, self._epoch = spec, poses.epoch
        robot, odometry = poses.predict(now_s), poses.latest
        if robot is None or odometry is None:
            return None
        self._travel_to(now_s, odometry)

        if detections is not None:
            self._take_detections(now_s, poses, odometry, spec, detections)
        if scan is not None:
            self._take_scan(now_s, poses, robot, spec, scan)
        self._candidates.drop_lost(now_s, robot)
        chosen = self._candidates.choose(now_s, robot)
        return None if chosen is None else self._track(now_s, robot, chosen)

    def _travel_to(self, now_s: float, odometry: Odometry) -> None:
        way_m, turned_rad = self._travel.way_m, self._travel.turned_rad
        if self._last_odometry is not None and odometry is not self._last_odometry:
            before, after = self._last_odometry.pose_in_odom, odometry.pose_in_odom
            way_m += math.hypot(after.x_m - before.x_m, after.y_m - before.y_m)
            turned_rad += abs(wrap_angle(after.yaw_rad - before.yaw_rad))
        self._last_odometry = odometry
        self._travel = Travel(now_s, way_m, turned_rad)

    def _take_detections(
        self, now_s: float, poses: PoseHistory, odometry: Odometry, spec: TargetSpec, frame: DetectionFrame
    ) -> None:
        stamp_s = frame.stamp_s
        if stamp_s == self._frame_stamp_s:
            return
        if not self._frame_stamp_s < stamp_s <= now_s + FUTURE_S:
            self.rejected["stamp"] += 1
            return
        pose = poses.at(stamp_s)
        if pose is None:
            self.rejected["unplaced"] += 1
            return  # not taken as used: odometry may catch up
        self._frame_stamp_s = stamp_s
        camera_in_odom = compose(pose, self._camera_in_base)
        yaw_rate_radps = odometry.twist_in_base.wz_radps
        wanted = [detection for detection in frame.detections if detection.class_name == spec.class_name]
        if len(wanted) > MAX_DETECTIONS:
            wanted = sorted(wanted, key=lambda detection: -detection.score)[:MAX_DETECTIONS]
        measurements = [
            measurement
            for measurement in (self._measurement(detection, spec, yaw_rate_radps) for detection in wanted)
            if measurement is not None
        ]
        self._candidates.catch_up(pose, self._travel)
        self.rejected["unmatched"] += self._candidates.take_frame(
            stamp_s,
            camera_in_odom,
            measurements,
            spec,
            self._travel,
            lambda candidate, expected: self._is_expected(stamp_s, spec, candidate, expected),
        )

    def _measurement(
        self, detection: Detection, spec: TargetSpec, yaw_rate_radps: float
    ) -> CameraMeasurement | None:
        """A detection that is a measurement, or None and a count of why not."""
        camera = self._config.camera
        range_m, bearing_rad = detection.range_m, detection.bearing_rad
        sigmas = detection.range_sigma_m, detection.bearing_sigma_rad
        if not all(map(math.isfinite, (range_m, bearing_rad, detection.height_px, *sigmas))):
            self.rejected["non_finite"] += 1
            return None
        if range_m <= 0.0 or min(sigmas) < 0.0 or detection.height_px <= 0.0:
            self.rejected["negative"] += 1
            return None
        if range_m > self._config.track.max_range_m:
            self.rejected["too_far"] += 1
            return None
        height_px = camera.focal_px * spec.height_m / range_m
        if not detection.clipped and abs(math.log(detection.height_px / height_px)) > SIZE_TOLERANCE:
            self.rejected["size"] += 1
            return None
        bearing_sigma_rad = math.hypot(max(sigmas[1], MIN_BEARING_SIGMA_RAD), STAMP_SIGMA_S * yaw_rate_radps)
        half_px = 0.5 * detection.width_px
        border_px = self._config.detector.border_px
        left_px, right_px = detection.u_px - half_px, detection.u_px + half_px
        if detection.clipped and not (border_px < left_px and right_px < camera.width_px - border_px):
            # What is left of the box has its centre beside the target's, by half the target's width at most.
            bearing_sigma_rad += 0.25 * spec.width_m / max(0.5 * range_m, 0.1)
        return CameraMeasurement(
            range_m=range_m,
            range_sigma_m=max(sigmas[0], MIN_RANGE_SIGMA * range_m),
            bearing_rad=bearing_rad,
            bearing_sigma_rad=bearing_sigma_rad,
            bearing_only=detection.clipped,
            confirmed=detection.confirmed,
            looks=looks_of(detection, camera.focal_px),
        )

    def _is_expected(
        self, stamp_s: float, spec: TargetSpec, candidate: Candidate, expected: CameraExpectation
    ) -> bool:
        """Whether the camera should have found the candidate: near enough, in the picture, and nothing in front."""
        camera = self._config.camera
        far_m = min(SURELY_FOUND_SHARE * camera.max_range_m, self._config.track.max_range_m)
        if not FULLY_VISIBLE_FROM_M <= expected.range_m <= far_m:
            return False
        if abs(expected.bearing_rad) > camera.half_fov_rad - EDGE_RAD:
            return False
        view = self._view
        if view is None or abs(stamp_s - view.stamp_s) > SCAN_MEMORY_S:
            return False
        dx, dy = candidate.filter.x_m - view.x_m, candidate.filter.y_m - view.y_m
        range_m = math.hypot(dx, dy)
        half_width_rad = math.atan2(0.5 * spec.width_m, max(range_m, spec.width_m)) + view.beam_rad
        return view.nearest_between_m(math.atan2(dy, dx), half_width_rad) > range_m - OCCLUDER_M

    def _take_scan(
        self, now_s: float, poses: PoseHistory, robot: Pose2D, spec: TargetSpec, scan: Scan
    ) -> None:
        stamp_s = scan.stamp_s
        if stamp_s == self._scan_stamp_s:
            return
        if not self._scan_stamp_s < stamp_s <= now_s + FUTURE_S:
            self.rejected["stamp"] += 1
            return
        points = self._placer.place(scan, poses)
        if points is None:
            self.rejected["unplaced"] += 1
            return  # not taken as used: odometry may catch up
        self._scan_stamp_s = stamp_s
        self._view = polar_view(points)
        near = [
            (c.filter.x_m, c.filter.y_m) for c in self._candidates.candidates if c.hits >= RANGED_FROM_HITS
        ]
        if near:
            # The finest check comes later, by covariance; a cluster's middle is off by up to a target's width.
            gate_m = self._config.track.lidar_range_gate_m + spec.width_m
            fixes = target_fixes(self._view, near, gate_m, spec.width_at_lidar_m)
            self._candidates.take_fixes(fixes, robot, self._travel)

    def _track(self, now_s: float, robot: Pose2D, candidate: Candidate) -> Track:
        xx, xy, yy = candidate.filter.position_covariance
        grown = candidate.growth(robot, self._travel)
        xx, xy, yy = xx + grown[0], xy + grown[1], yy + grown[2]
        dx, dy = candidate.filter.x_m - robot.x_m, candidate.filter.y_m - robot.y_m
        face = candidate.face.estimate
        return Track(
            stamp_s=now_s,
            x_m=candidate.filter.x_m,
            y_m=candidate.filter.y_m,
            covariance_m2=(xx, xy, xy, yy),
            confirmed=candidate.confirmed,
            hits=candidate.hits,
            last_seen_s=candidate.last_seen_s,
            last_ranged_s=candidate.last_ranged_s,
            range_m=math.hypot(dx, dy),
            bearing_rad=wrap_angle(math.atan2(dy, dx) - robot.yaw_rad),
            facing_in_odom_rad=face.facing_in_odom_rad if face is not None else None,
            facing_sigma_rad=face.sigma_rad if face is not None else None,
        )
