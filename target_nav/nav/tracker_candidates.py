"""Everything that may be the target: which detection and which cluster belongs to which, and which one is meant.

Detections go to the candidates they fit best, confirmed ones first; what fits none begins a new one. One candidate is
chosen: the nearest confirmed, and another only when it is clearly nearer for some time.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field

from target_nav.config import Config
from target_nav.nav.lidar_clusters import TargetFix
from target_nav.nav.tracker_candidate import Candidate, Travel
from target_nav.nav.tracker_filter import CameraExpectation, CameraMeasurement, TargetFilter
from target_nav.state.types import Pose2D, TargetSpec

MAX_CANDIDATES = 12
"""Bounds the work of a frame full of false boxes."""
TENTATIVE_S = 1.5
"""An unconfirmed candidate without a detection for so long is dropped: 15 frames."""
CONFIRM_SHARE = 0.3
"""Of the frames that had it in the picture. A target is found in half of them even where half of it is hidden; a thing
that is taken for one now and then (5 % in the simulator) never is so often."""
EDGE_RAD = 0.07
"""So near to the picture's edge a missing detection means nothing."""
RANGED_FROM_HITS = 2
"""Before a second look a LiDAR cluster has too much room to fit by chance."""
MISSES_LOST = 20
"""Frames in a row (2 s) in which the camera should have seen the target and did not."""
MISSES_DOUBTED = 10
"""Frames in a row after which a candidate that is being seen is preferred."""
UNCLIPPED_FACTOR, UNCLIPPED_MARGIN_M = 1.5, 0.2
"""A clipped box bounds the range from above; a candidate farther off than this beyond the bound is another object."""
FIX_AGREES_M = 0.08
"""A LiDAR fix counts if the last one was as near as this: one look at a chair leg does not move a target."""
FIX_MEMORY_S = 1.0
"""and not older than this."""
CONTRADICTION = 1.0
"""Where the camera alone prefers another cluster by more (squared Mahalanobis distance), earlier ones may have been
wrong."""
AMBIGUOUS_DISTANCE = 4.0
"""Two clusters whose squared Mahalanobis distances differ by less could be either."""


@dataclass(eq=False)
class CandidateSet:
    config: Config
    candidates: list[Candidate] = field(default_factory=list)
    _chosen: Candidate | None = None
    _rival: Candidate | None = None
    _rival_since_s: float = 0.0

    def catch_up(self, robot: Pose2D, travel: Travel) -> None:
        for candidate in self.candidates:
            candidate.catch_up(robot, travel)

    def take_frame(
        self,
        stamp_s: float,
        camera_in_odom: Pose2D,
        measurements: Sequence[CameraMeasurement],
        spec: TargetSpec,
        travel: Travel,
        is_expected: Callable[[Candidate, CameraExpectation], bool],
    ) -> int:
        """Give one frame's detections to the candidates; how many fitted none. All filters must have caught up.

        `is_expected` says whether the camera should have found a candidate in this frame.
        """
        free = set(range(len(measurements)))
        confirmed = [candidate for candidate in self.candidates if candidate.confirmed]
        tentative = [candidate for candidate in self.candidates if not candidate.confirmed]
        for group in (confirmed, tentative):
            expected = [(candidate, candidate.camera.expect(camera_in_odom)) for candidate in group]
            rows = [(candidate, what) for candidate, what in expected if what is not None]
            self._assign(stamp_s, camera_in_odom, rows, measurements, free, is_expected)
        for index in sorted(free):
            measurement = measurements[index]
            if len(self.candidates) < MAX_CANDIDATES or self._drop_weakest():
                target_filter = TargetFilter(self.config.track, camera_in_odom, measurement)
                begun = Candidate(target_filter, travel, stamp_s, hits=int(measurement.confirmed), looks=1)
                self._judge(begun)
                self.candidates.append(begun)
        self._merge(spec)
        return len(free)

    def take_fixes(self, fixes: Sequence[TargetFix], robot: Pose2D, travel: Travel) -> None:
        """Give one scan's clusters to the candidates that were seen at least twice."""
        for candidate in self.candidates:
            if candidate.hits >= RANGED_FROM_HITS:
                candidate.catch_up(robot, travel)
                fix = self._fix_for(candidate, fixes)
                if fix is None:
                    continue
                last, candidate.last_fix = candidate.last_fix, fix
                agrees = (
                    last is not None
                    and fix.stamp_s - last.stamp_s <= FIX_MEMORY_S
                    and math.hypot(fix.x_m - last.x_m, fix.y_m - last.y_m) <= FIX_AGREES_M
                )
                if agrees:
                    candidate.take(fix)

    def drop_lost(self, now_s: float, robot: Pose2D) -> None:
        if self.candidates:
            self.candidates = [c for c in self.candidates if not self._is_lost(c, now_s, robot)]
            if self._chosen is not None and self._chosen not in self.candidates:
                self._chosen = None

    def forget_near(self, places_m: Sequence[tuple[float, float]], radius_m: float) -> None:
        """Drop every candidate that is so near to one of the places, in odom."""
        self.candidates = [
            c
            for c in self.candidates
            if all(math.dist((c.filter.x_m, c.filter.y_m), place) >= radius_m for place in places_m)
        ]
        if self._chosen is not None and self._chosen not in self.candidates:
            self._chosen = None

    def choose(self, now_s: float, robot: Pose2D) -> Candidate | None:
        """The candidate that is meant, or None. Confirmed ones first; while there is none, the most often seen."""
        confirmed = [candidate for candidate in self.candidates if candidate.confirmed]
        if not confirmed:
            self._chosen = self._rival = None
            return max(self.candidates, key=lambda c: (c.hits, -c.range_from(robot)), default=None)
        nearest = min(confirmed, key=lambda c: c.range_from(robot))
        if self._chosen is None:
            self._chosen, self._rival = nearest, None
        if len(confirmed) > 1:
            self._prefer(self._rival_of(self._chosen, nearest, confirmed, robot), now_s)
        return self._chosen

    def _assign(
        self,
        stamp_s: float,
        camera_in_odom: Pose2D,
        group: Sequence[tuple[Candidate, CameraExpectation]],
        measurements: Sequence[CameraMeasurement],
        free: set[int],
        is_expected: Callable[[Candidate, CameraExpectation], bool],
    ) -> None:
        """Greedy, likeliest pair first; within the innovation gate only."""
        gate = self.config.track.gate_sigma**2
        pairs: list[tuple[float, int, int]] = []
        for row, (_, expected) in enumerate(group):
            for column in free:
                measurement = measurements[column]
                bound_m = UNCLIPPED_FACTOR * measurement.range_m + UNCLIPPED_MARGIN_M
                if measurement.bearing_only and expected.range_m > bound_m:
                    continue
                squared, cost = expected.distance(measurement)
                if squared <= gate:
                    pairs.append((cost, row, column))
        seen: set[int] = set()
        for _, row, column in sorted(pairs):
            if row in seen or column not in free:
                continue
            seen.add(row)
            free.discard(column)
            candidate, expected = group[row]
            candidate.see(camera_in_odom, expected, measurements[column], gate)
            candidate.last_seen_s = max(candidate.last_seen_s, stamp_s)
            candidate.misses = 0
            candidate.hits += int(measurements[column].confirmed)
            self._judge(candidate)
        for row, (candidate, expected) in enumerate(group):
            if row not in seen and is_expected(candidate, expected):
                candidate.misses += 1
            candidate.looks += int(row in seen or self._in_picture(expected))

    def _in_picture(self, expected: CameraExpectation) -> bool:
        camera = self.config.camera
        inside = abs(expected.bearing_rad) <= camera.half_fov_rad - EDGE_RAD
        return inside and expected.range_m <= camera.max_range_m

    def _judge(self, candidate: Candidate) -> None:
        often = candidate.hits >= self.config.track.confirm_hits
        steadily = candidate.hits >= CONFIRM_SHARE * candidate.looks
        candidate.confirmed = candidate.confirmed or (often and steadily)

    def _drop_weakest(self) -> bool:
        """Make room by dropping the unconfirmed candidate with the fewest hits, the longest unseen of those."""
        tentative = [candidate for candidate in self.candidates if not candidate.confirmed]
        if tentative:
            self.candidates.remove(min(tentative, key=lambda c: (c.hits, c.last_seen_s)))
        return bool(tentative)

    def _merge(self, spec: TargetSpec) -> None:
        """Two candidates closer than a target is wide are one: the one seen more often stays."""
        if len(self.candidates) < 2:
            return
        kept: list[Candidate] = []
        for candidate in sorted(
            self.candidates, key=lambda c: (c is not self._chosen, not c.confirmed, -c.hits)
        ):
            x_m, y_m = candidate.filter.x_m, candidate.filter.y_m
            if all(math.hypot(x_m - k.filter.x_m, y_m - k.filter.y_m) >= spec.width_m for k in kept):
                kept.append(candidate)
        if len(kept) < len(self.candidates):
            self.candidates = [candidate for candidate in self.candidates if candidate in kept]

    def _fix_for(self, candidate: Candidate, fixes: Sequence[TargetFix]) -> TargetFix | None:
        """The one cluster that agrees in range and bearing, or None: there is none, or it could be either of two."""
        gate, gate_m = self.config.track.gate_sigma**2, self.config.track.lidar_range_gate_m
        x_m, y_m = candidate.filter.x_m, candidate.filter.y_m
        near = [fix for fix in fixes if math.hypot(fix.x_m - x_m, fix.y_m - y_m) <= gate_m]
        if not near:
            return None
        found = sorted((*candidate.distances(fix), index) for index, fix in enumerate(near))
        believed, by_camera, index = found[0]
        if by_camera - min(row[1] for row in found) > CONTRADICTION:
            candidate.doubt_lidar()
            return None
        candidate.doubts = 0
        if max(believed, by_camera) > gate or near[index].doubtful:
            return None
        if len(found) > 1 and found[1][0] - believed < AMBIGUOUS_DISTANCE:
            return None
        return near[index]

    def _is_lost(self, candidate: Candidate, now_s: float, robot: Pose2D) -> bool:
        unseen_s = now_s - candidate.last_seen_s
        if not candidate.confirmed:
            return unseen_s > TENTATIVE_S
        if candidate.range_from(robot) <= self.config.approach.blind_from_m:
            # The camera cannot see it here: no detection is no evidence.
            return unseen_s > max(self.config.approach.blind_timeout_s, self.config.track.lost_after_s)
        ranged = now_s - candidate.last_ranged_s <= FIX_MEMORY_S
        return unseen_s > self.config.track.lost_after_s or (candidate.misses >= MISSES_LOST and not ranged)

    def _rival_of(
        self, chosen: Candidate, nearest: Candidate, confirmed: Sequence[Candidate], robot: Pose2D
    ) -> Candidate | None:
        """Who is clearly better than the chosen one at this moment."""
        if nearest is not chosen and nearest.misses < MISSES_DOUBTED:
            nearer_m = chosen.range_from(robot) - nearest.range_from(robot)
            if nearer_m > self.config.track.switch_margin_m:
                return nearest
        if chosen.misses >= MISSES_DOUBTED:
            seen = [candidate for candidate in confirmed if candidate.misses == 0 and candidate is not chosen]
            return min(seen, key=lambda c: c.range_from(robot), default=None)
        return None

    def _prefer(self, rival: Candidate | None, now_s: float) -> None:
        if rival is None or rival is not self._rival:
            self._rival, self._rival_since_s = rival, now_s
        elif now_s - self._rival_since_s >= self.config.track.switch_after_s:
            self._chosen, self._rival = rival, None
