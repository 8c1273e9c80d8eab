"""A scan as points in odom, each beam placed with the pose the robot had when that beam was taken.

One turn of the LiDAR takes 182 ms; at 0.5 rad/s its last beam is 5.2 degrees away from where a rigid scan would put it.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from target_nav.config import LidarConfig
from target_nav.nav.poses import PoseHistory
from target_nav.state.types import FloatArray, Odometry, Scan


@dataclass(frozen=True, eq=False)
class ScanPoints:
    """N beams, M of them with a return, in the order they were taken."""

    stamp_s: float
    """When beam 0 was taken."""
    end_s: float
    """When beam N - 1 was taken."""
    angle_min_rad: float
    angle_increment_rad: float
    ranges_m: FloatArray
    """(N,) as measured; `inf` where there was no valid return."""
    laser_in_odom: FloatArray
    """(N, 3): x_m, y_m, yaw_rad of the laser when each beam was taken; the yaw does not wrap."""
    beams: NDArray[np.intp]
    """(M,) which beams had a return."""
    points_in_base_m: FloatArray
    """(M, 2) in base_link as it was at each beam's own time."""
    points_in_odom_m: FloatArray
    """(M, 2)"""

    @property
    def is_closed(self) -> bool:
        """Whether the last beam is the first one's neighbour."""
        step_rad = abs(self.angle_increment_rad)
        return len(self.ranges_m) * step_rad >= 2.0 * math.pi - 0.5 * step_rad


class ScanPlacer:
    """`deskewed_points_in_odom` for all who need the same scan in the same tick: done once, and handed out again."""

    def __init__(self, lidar: LidarConfig) -> None:
        self._lidar = lidar
        self._of: tuple[Scan, PoseHistory, Odometry | None, int] | None = None
        self._placed: ScanPoints | None = None

    def place(self, scan: Scan, poses: PoseHistory) -> ScanPoints | None:
        # The end of a scan may be extrapolated, so a newer odometry places it anew.
        of = (scan, poses, poses.latest, poses.epoch)
        last = self._of
        if last is None or any(one is not other for one, other in zip(of[:3], last[:3])) or of[3] != last[3]:
            self._of, self._placed = of, deskewed_points_in_odom(scan, poses, self._lidar)
        return self._placed


def deskewed_points_in_odom(scan: Scan, poses: PoseHistory, lidar: LidarConfig) -> ScanPoints | None:
    """The scan's valid returns (finite, range_min <= r <= range_max) in odom.

    None when `poses` do not cover all of the scan, or when its geometry is no geometry (no beams, not finite).
    """
    count = len(scan.ranges_m)
    geometry = (scan.stamp_s, scan.angle_min_rad, scan.angle_increment_rad, scan.time_increment_s)
    if count == 0 or not all(map(math.isfinite, geometry)) or scan.time_increment_s < 0.0:
        return None
    if scan.angle_increment_rad == 0.0:
        return None
    index: FloatArray = np.arange(count, dtype=np.float64)
    base = poses.at_each(scan.stamp_s + index * scan.time_increment_s)
    if base is None:
        return None

    measured = np.asarray(scan.ranges_m, dtype=np.float64)
    with np.errstate(invalid="ignore"):
        valid = (measured >= max(scan.range_min_m, 0.0)) & (measured <= scan.range_max_m) & (measured > 0.0)
    valid &= np.isfinite(measured)
    beams = np.flatnonzero(valid)
    c, s = np.cos(base[:, 2]), np.sin(base[:, 2])
    laser = np.empty_like(base)
    laser[:, 0] = base[:, 0] + c * lidar.x_m - s * lidar.y_m
    laser[:, 1] = base[:, 1] + s * lidar.x_m + c * lidar.y_m
    laser[:, 2] = base[:, 2] + lidar.yaw_rad

    angles_rad = scan.angle_min_rad + lidar.yaw_rad + beams * scan.angle_increment_rad
    hit_m = measured[beams]
    in_base = np.empty((len(beams), 2))
    in_base[:, 0] = lidar.x_m + hit_m * np.cos(angles_rad)
    in_base[:, 1] = lidar.y_m + hit_m * np.sin(angles_rad)
    in_odom = np.empty_like(in_base)
    c, s = c[beams], s[beams]
    in_odom[:, 0] = base[beams, 0] + c * in_base[:, 0] - s * in_base[:, 1]
    in_odom[:, 1] = base[beams, 1] + s * in_base[:, 0] + c * in_base[:, 1]
    return ScanPoints(
        stamp_s=scan.stamp_s,
        end_s=scan.stamp_s + (count - 1) * scan.time_increment_s,
        angle_min_rad=scan.angle_min_rad,
        angle_increment_rad=scan.angle_increment_rad,
        ranges_m=np.where(valid, measured, np.inf),
        laser_in_odom=laser,
        beams=beams,
        points_in_base_m=in_base,
        points_in_odom_m=in_odom,
    )
