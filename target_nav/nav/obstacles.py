"""What the LiDAR saw a moment ago: a short-lived memory of obstacle points round the robot.

One scan in five loses any given beam, so a single scan is full of holes that are no free space. Points are kept in
5 cm cells of the odom frame, one point a cell, until they are `avoid.memory_s` old or a later scan looks through them.
Only a beam that comes back from clearly farther off clears a point; a drop-out or a nearer hit says nothing.

A return that nothing supports, neither a neighbouring beam, nor an older point beside it, nor a second hit, is an
obstacle at once but is forgotten soon: noise must not block the way.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from target_nav.config import Config
from target_nav.nav.poses import PoseHistory
from target_nav.nav.scan_points import ScanPoints, deskewed_points_in_odom
from target_nav.state.types import FloatArray, Pose2D, Scan, TargetSpec, Track
from target_nav.utils.frames import points_to_child

CELL_M = 0.05
SUPPORT_M = 0.10
"""Two returns this near to each other are two looks at one thing; beams of one degree are 7 cm apart at 4 m."""
UNSUPPORTED_S = 0.5
"""How long a lone return counts: the next two scans have come by then."""
SEE_THROUGH_M = 0.10
"""A beam clears what it passes by this much: four sigma of the LiDAR at 4 m, and odometry."""
CLEARING_SCANS = 2
"""Scans in a row that must look through a supported point: a thin leg hides between two beams for one."""
SELF_INSET_M = 0.01
"""A return this deep inside the footprint is the body itself; less may be an obstacle that touches it."""
EXTRA_RADIUS_M = 0.5
"""Remembered beyond what is handed out, for the robot comes nearer: 0.30 m/s for 1.5 s."""
TARGET_MARGIN_M = 0.05
TARGET_SIGMAS = 2.0

_KEY_STRIDE = 1 << 24
_NO_POINTS: FloatArray = np.empty((0, 2))


class ObstacleMemory:
    """Call `update` each tick, then `points_in_base` as often as needed."""

    def __init__(self, config: Config) -> None:
        self._config = config
        look_m = config.avoid.look_ahead_m + config.avoid.margin_m + config.robot.circumscribed_radius_m
        # Never less than what the avoidance looks at.
        self._reach_m = max(config.avoid.memory_radius_m, look_m)
        self._keep_m = self._reach_m + EXTRA_RADIUS_M
        self._epoch = -1
        self.clear()

    def clear(self) -> None:
        self._keys: NDArray[np.int64] = np.empty(0, dtype=np.int64)  # ascending
        self._points_m = _NO_POINTS
        self._stamps_s: FloatArray = np.empty(0)
        self._looks_through: NDArray[np.int64] = np.empty(0, dtype=np.int64)
        self._supported: NDArray[np.bool_] = np.empty(0, dtype=np.bool_)
        self._scan_stamp_s = -math.inf
        self._next_expiry_s = math.inf

    def update(self, now_s: float, poses: PoseHistory, scan: Scan | None) -> None:
        """Take the newest scan, once; let old points go. A scan that `poses` do not cover yet is tried again."""
        if not math.isfinite(now_s):
            return
        if poses.epoch != self._epoch:
            self.clear()
            self._epoch = poses.epoch
        # "not <=" and not ">", so that a NaN stamp is refused.
        if scan is not None and not scan.stamp_s <= self._scan_stamp_s:
            points = deskewed_points_in_odom(scan, poses, self._config.lidar)
            if points is not None:
                self._scan_stamp_s = scan.stamp_s
                self._merge(points, self._near_laser(points) & self._not_seen_past(points))
        if now_s >= self._next_expiry_s:
            self._expire(now_s)

    def points_in_base(self, pose_in_odom: Pose2D, track: Track | None, spec: TargetSpec) -> FloatArray:
        """Obstacle points in base_link, shape (N, 2), out to `memory_radius_m` from base_link.

        That is farther than avoidance looks: routes out of traps and searches need the walls of a room.

        Left out: what is inside the footprint, and the points of the confirmed target, which lie within its radius
        and what its position is uncertain by (`lidar_range_gate_m` at most), so that a box beside it stays.
        """
        points_m = self._points_m
        if not len(points_m) or not pose_in_odom.is_finite():
            return _NO_POINTS
        if track is not None and track.confirmed and math.isfinite(track.x_m + track.y_m + track.sigma_m):
            gate_m = min(
                TARGET_MARGIN_M + TARGET_SIGMAS * track.sigma_m, self._config.track.lidar_range_gate_m
            )
            dx, dy = points_m[:, 0] - track.x_m, points_m[:, 1] - track.y_m
            points_m = points_m[dx * dx + dy * dy > (0.5 * spec.width_m + gate_m) ** 2]
        in_base = points_to_child(pose_in_odom, points_m)
        x, y = in_base[:, 0], in_base[:, 1]
        near = (x * x + y * y <= self._reach_m**2) & ~self._inside_body(x, y)
        return in_base[near]

    def _inside_body(self, x_m: FloatArray, y_m: FloatArray) -> NDArray[np.bool_]:
        robot = self._config.robot
        ahead = (x_m < robot.front_m - SELF_INSET_M) & (x_m > SELF_INSET_M - robot.rear_m)
        inside: NDArray[np.bool_] = ahead & (np.abs(y_m) < robot.half_width_m - SELF_INSET_M)
        return inside

    def _not_seen_past(self, scan: ScanPoints) -> NDArray[np.bool_]:
        """Which remembered points stay: count the scans in a row that looked past each."""
        count = len(scan.ranges_m)
        nearest_m = _nearest_around(scan.ranges_m, scan.is_closed)
        turn = 2.0 * math.pi / abs(scan.angle_increment_rad)
        beam = np.full(len(self._keys), count // 2)
        # The beam that looks at a point depends on where the laser was when it took that beam: two rounds converge.
        for _ in range(2):
            dx = self._points_m[:, 0] - scan.laser_in_odom[beam, 0]
            dy = self._points_m[:, 1] - scan.laser_in_odom[beam, 1]
            bearing = np.arctan2(dy, dx) - scan.laser_in_odom[beam, 2]
            wanted = np.rint(((bearing - scan.angle_min_rad) / scan.angle_increment_rad) % turn).astype(
                np.intp
            )
            if scan.is_closed:
                wanted %= count
            covered = wanted < count
            beam = np.minimum(wanted, count - 1)
        range_m = np.hypot(dx, dy)
        # The beam itself must have come back: its neighbours pass a thin leg whose own beam is lost.
        returned = np.isfinite(scan.ranges_m[beam])
        seen_past = covered & returned & (nearest_m[beam] > range_m + SEE_THROUGH_M)
        self._looks_through = np.where(seen_past, self._looks_through + 1, 0)
        stays: NDArray[np.bool_] = self._looks_through < np.where(self._supported, CLEARING_SCANS, 1)
        return stays

    def _merge(self, scan: ScanPoints, keep: NDArray[np.bool_]) -> None:
        """Add the scan's points to those of the old ones that stay: one a cell, the newest wins."""
        points_m = scan.points_in_odom_m
        base_x, base_y = scan.points_in_base_m[:, 0], scan.points_in_base_m[:, 1]
        near = (base_x * base_x + base_y * base_y <= self._keep_m**2) & ~self._inside_body(base_x, base_y)
        supported = np.zeros(len(points_m), dtype=np.bool_)
        if len(points_m) > 1:
            steps_m = points_m[1:] - points_m[:-1]
            close = np.einsum("ij,ij->i", steps_m, steps_m) < SUPPORT_M**2
            supported[1:] |= close
            supported[:-1] |= close
        points_m, supported = points_m[near], supported[near]
        turn_s = scan.end_s - scan.stamp_s
        stamps_s = scan.stamp_s + scan.beams[near] * (turn_s / max(len(scan.ranges_m) - 1, 1))

        old_m = self._points_m[keep]
        alone = np.flatnonzero(~supported)
        if len(alone) and len(old_m):
            gaps = points_m[alone, None, :] - old_m[None, :, :]
            supported[alone] = (np.einsum("ijk,ijk->ij", gaps, gaps) < SUPPORT_M**2).any(axis=1)

        cells = np.floor(points_m / CELL_M).astype(np.int64)
        keys = cells[:, 0] * _KEY_STRIDE + cells[:, 1]
        # np.unique keeps the first of equal keys: new points come before old ones.
        self._keys, first = np.unique(np.concatenate((keys, self._keys[keep])), return_index=True)
        self._points_m = np.concatenate((points_m, old_m))[first]
        self._stamps_s = np.concatenate((stamps_s, self._stamps_s[keep]))[first]
        self._supported = np.concatenate((supported, self._supported[keep]))[first]
        looks = np.concatenate((np.zeros(len(points_m), dtype=np.int64), self._looks_through[keep]))
        self._looks_through = looks[first]
        self._schedule_expiry()

    def _near_laser(self, scan: ScanPoints) -> NDArray[np.bool_]:
        x_m, y_m = scan.laser_in_odom[-1, 0], scan.laser_in_odom[-1, 1]
        dx, dy = self._points_m[:, 0] - x_m, self._points_m[:, 1] - y_m
        near: NDArray[np.bool_] = dx * dx + dy * dy <= self._keep_m**2
        return near

    def _lifetimes_s(self) -> FloatArray:
        memory_s = self._config.avoid.memory_s
        return np.where(self._supported, memory_s, min(UNSUPPORTED_S, memory_s))

    def _schedule_expiry(self) -> None:
        ends_s = self._stamps_s + self._lifetimes_s()
        # What the newest scan saw stays until the next one, however short the memory; if none comes, the robot stops.
        older = self._stamps_s < self._scan_stamp_s
        self._next_expiry_s = float(ends_s[older].min()) if older.any() else math.inf

    def _expire(self, now_s: float) -> None:
        of_newest_scan = self._stamps_s >= self._scan_stamp_s
        keep = of_newest_scan | (self._stamps_s + self._lifetimes_s() > now_s)
        self._keys, self._points_m, self._stamps_s = (
            self._keys[keep],
            self._points_m[keep],
            self._stamps_s[keep],
        )
        self._looks_through, self._supported = self._looks_through[keep], self._supported[keep]
        self._schedule_expiry()


def _nearest_around(ranges_m: FloatArray, closed: bool) -> FloatArray:
    """For each beam, the nearest return of it and two beams on either side; inf where none of them came back."""
    count = len(ranges_m)
    before, after = (ranges_m[-2:], ranges_m[:2]) if closed else (np.full(2, np.inf), np.full(2, np.inf))
    padded = np.concatenate((before, ranges_m, after))
    nearest = padded[:count].copy()
    for shift in range(1, 5):
        np.minimum(nearest, padded[shift : shift + count], out=nearest)
    return nearest
