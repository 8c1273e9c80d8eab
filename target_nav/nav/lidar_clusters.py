"""Which returns of a scan may be the target: narrow, free-standing clusters, as seen from one place.

A range is never lent by whatever happens to lie in the right direction. A cluster counts only if it is as narrow as the
target, and if what is seen on either side of it is clearly farther off. A box is too wide, a wall has neighbours
at its own range, and of a target that touches either nothing is said: no range is better than a wrong one.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from enum import Enum
from statistics import median

import numpy as np
from numpy.typing import NDArray

from target_nav.nav.lidar_noise import range_sigma_m
from target_nav.nav.scan_points import ScanPoints
from target_nav.state.types import FloatArray

BRIDGED_BEAMS = 3.5
"""Two drop-outs in a row do not split a cluster: 4 % at 2 m, where one in five beams is lost."""
JUMP_M = 0.05
JUMP_SIGMAS = 4.2
"""A range jump between neighbours is more than the target's own roundness (its edge lies one radius behind its front)
and three sigma of a difference of two ranges."""
BESIDE_BEAMS = 4.5
"""The nearest return within so many beams on either side must be farther off than the cluster."""
MAX_WIDTHS = 1.5
"""No wider than this. Returns span less than the target's width, but nobody measures it to the centimetre."""
BACKGROUND_WIDTHS = 4.0
"""Wider than this it is background: it may be near the target, but it cannot be the target and something beside it."""
MIN_BEAMS = 2.0
"""Where the target would fill fewer (a pin beyond 2.3 m), half a box looks like it; the camera is good enough there."""
MIN_SHARE = 0.3
"""At least this share of the beams that the target would fill: half of it hidden or lost is still an answer."""
MODEL_SIGMA_M = 0.01
"""The target is not quite a cylinder of the given width at the height of the laser, nor stamps quite right."""
OFFSET_SIGMA_M = 0.0075
"""The same along the line of sight, where a constant offset of the LiDAR (some millimetres) is the most of it."""
EDGE_BEAMS_SIGMA = 0.55
"""Two edges, each known to within one beam, and a lost beam now and then: 0.4. More, because to a robot that stands the
same beams meet the target scan after scan, and what they get wrong does not average out; so much makes NEES honest."""


_MOST_RETURNS = 120
"""A fine LiDAR on a target at arm's length; more is a wall."""


class _Side(Enum):
    FREE = "clearly farther off, or nothing"
    NEARER = "clearly nearer"
    JOINED = "at the same range"


@dataclass(frozen=True)
class TargetFix:
    """A cluster that may be the target, as the position of the target's centre in odom."""

    stamp_s: float
    x_m: float
    y_m: float
    covariance_m2: tuple[float, float, float, float]
    returns: int
    bearing_rad: float
    """In odom, from the laser."""
    slack_m: float
    """How far to either side the centre may lie from here, all equally likely: half of what is missing of the width."""
    gate_covariance_m2: tuple[float, float, float, float]
    """Of the position without that: `covariance_m2` is of both."""
    doubtful: bool = False
    """Never to be believed, but where it fits as well as another, the other is not to be believed either: a thing that
    is a little too wide, has something at its own range or nearer right beside it, or is too far off to tell."""

    def nearest_to(self, x_m: float, y_m: float) -> tuple[float, float]:
        """Where within the slack the centre would be nearest to a point."""
        c, s = math.cos(self.bearing_rad), math.sin(self.bearing_rad)
        left_m = (y_m - self.y_m) * c - (x_m - self.x_m) * s
        left_m = min(max(left_m, -self.slack_m), self.slack_m)
        return self.x_m - s * left_m, self.y_m + c * left_m


@dataclass(frozen=True, eq=False)
class PolarView:
    """The returns of a scan as seen from the laser's place at the scan's end, by bearing in odom, ascending."""

    x_m: float
    y_m: float
    stamp_s: float
    beam_rad: float
    ranges_m: FloatArray
    bearings_rad: FloatArray
    """In [-pi, pi]."""

    def nearest_between_m(self, bearing_rad: float, half_width_rad: float) -> float:
        """The nearest return within `half_width_rad` of a bearing; inf if nothing came back from there."""
        off = np.abs(np.remainder(self.bearings_rad - bearing_rad + math.pi, 2.0 * math.pi) - math.pi)
        inside = self.ranges_m[off <= half_width_rad]
        return float(inside.min()) if len(inside) else math.inf


def polar_view(scan: ScanPoints) -> PolarView:
    x_m, y_m = float(scan.laser_in_odom[-1, 0]), float(scan.laser_in_odom[-1, 1])
    dx, dy = scan.points_in_odom_m[:, 0] - x_m, scan.points_in_odom_m[:, 1] - y_m
    bearings = np.arctan2(dy, dx)
    order = np.argsort(bearings)
    ranges = np.sqrt(dx * dx + dy * dy)
    return PolarView(x_m, y_m, scan.end_s, abs(scan.angle_increment_rad), ranges[order], bearings[order])


def find_clusters(view: PolarView) -> NDArray[np.intp]:
    """Runs of returns without a jump in range or a hole in bearing, shape (K, 2): first index into `view`, length.

    The circle has no end: a run that crosses +-pi is one cluster, and its indices go on at 0.
    """
    ranges, bearings = view.ranges_m, view.bearings_rad
    count = len(ranges)
    if count == 0:
        return np.empty((0, 2), dtype=np.intp)
    following = np.roll(ranges, -1)
    turn = np.roll(bearings, -1) - bearings
    turn[-1] += 2.0 * math.pi
    limit = JUMP_M + JUMP_SIGMAS * range_sigma_m(np.minimum(ranges, following))
    ends = np.flatnonzero((np.abs(following - ranges) > limit) | (turn > BRIDGED_BEAMS * view.beam_rad))
    if len(ends) == 0:
        return np.array([[0, count]], dtype=np.intp)
    lengths = np.diff(ends, prepend=ends[-1] - count)
    return np.stack(((ends - lengths + 1) % count, lengths), axis=1)


def target_fixes(
    view: PolarView, near: Sequence[tuple[float, float]], gate_m: float, width_m: float
) -> list[TargetFix]:
    """The narrow clusters, doubtful ones too, within `gate_m` of one of the points `near` (odom)."""
    clusters = find_clusters(view)
    if len(clusters) == 0:
        return []
    count = len(view.ranges_m)
    middles = (clusters[:, 0] + clusters[:, 1] // 2) % count
    centres_m = view.ranges_m[middles] + 0.5 * width_m
    x_m = view.x_m + centres_m * np.cos(view.bearings_rad[middles])
    y_m = view.y_m + centres_m * np.sin(view.bearings_rad[middles])
    within = np.zeros(len(clusters), dtype=np.bool_)
    for px_m, py_m in near:
        within |= (x_m - px_m) ** 2 + (y_m - py_m) ** 2 <= gate_m**2
    runs = ((start + np.arange(length)) % count for start, length in clusters[within])
    return [fix for run in runs for fix in _fixes(view, run, width_m)]


def _fixes(view: PolarView, run: NDArray[np.intp], width_m: float) -> list[TargetFix]:
    """One for a cluster as narrow as the target; a doubtful one for each return of what may hide it in itself."""
    if len(run) > _MOST_RETURNS:
        return []
    # A handful of returns: plain floats are quicker than arrays.
    first, last = int(run[0]), int(run[-1])
    ranges: list[float] = view.ranges_m[run].tolist()
    bearings: list[float] = view.bearings_rad[run].tolist()
    spread_rad = (bearings[-1] - bearings[0]) % (2.0 * math.pi)
    near_m, deep_m = min(ranges), max(ranges) - min(ranges)
    pitch_m = near_m * view.beam_rad
    span_m = near_m * spread_rad
    sigma_m = float(range_sigma_m(near_m))
    filled = width_m / pitch_m
    if len(ranges) < MIN_SHARE * filled or max(span_m, deep_m) > BACKGROUND_WIDTHS * width_m:
        return []
    radius_m = 0.5 * width_m
    along = (JUMP_SIGMAS / 3.0 * sigma_m) ** 2
    across = (EDGE_BEAMS_SIGMA * pitch_m) ** 2 + MODEL_SIGMA_M**2
    sides = _beside(view, first, -1), _beside(view, last, +1)
    narrow = span_m <= MAX_WIDTHS * width_m and deep_m <= width_m + 2.0 * JUMP_SIGMAS * sigma_m
    if not narrow or _Side.JOINED in sides:
        along += OFFSET_SIGMA_M**2
        return [
            _fix(view, range_m + radius_m, bearing_rad, along, across, radius_m, returns=1, doubtful=True)
            for range_m, bearing_rad in zip(ranges, bearings)
        ]

    # Law of cosines: a ray that meets a circle of radius R at range r, delta off its centre, puts the centre at
    # r cos(delta) + sqrt(R^2 - r^2 sin^2(delta)). The median shrugs off a mixed return at an edge.
    middle_rad = bearings[0] + 0.5 * spread_rad
    centres = []
    for range_m, bearing_rad in zip(ranges, bearings):
        off_m = range_m * math.sin(bearing_rad - middle_rad)
        ahead_m = range_m * math.cos(bearing_rad - middle_rad)
        centres.append(ahead_m + math.sqrt(max(radius_m**2 - off_m * off_m, 0.0)))
    along = along / len(ranges) + OFFSET_SIGMA_M**2
    slack_m = max(radius_m - 0.5 * span_m, 0.0)
    doubtful = _Side.NEARER in sides or filled < MIN_BEAMS
    return [_fix(view, median(centres), middle_rad, along, across, slack_m, len(ranges), doubtful)]


def _fix(
    view: PolarView,
    range_m: float,
    bearing_rad: float,
    along_m2: float,
    across_m2: float,
    slack_m: float,
    returns: int,
    doubtful: bool,
) -> TargetFix:
    c, s = math.cos(bearing_rad), math.sin(bearing_rad)

    def in_odom(along: float, across: float) -> tuple[float, float, float, float]:
        cross = (along - across) * c * s
        return along * c * c + across * s * s, cross, cross, along * s * s + across * c * c

    return TargetFix(
        stamp_s=view.stamp_s,
        x_m=view.x_m + range_m * c,
        y_m=view.y_m + range_m * s,
        covariance_m2=in_odom(along_m2, across_m2 + slack_m**2 / 3.0),
        returns=returns,
        bearing_rad=bearing_rad,
        slack_m=slack_m,
        gate_covariance_m2=in_odom(along_m2, across_m2),
        doubtful=doubtful,
    )


def _beside(view: PolarView, edge: int, side: int) -> _Side:
    """What the next return on this side of a cluster's edge is."""
    other = (edge + side) % len(view.ranges_m)
    aside_rad = (side * float(view.bearings_rad[other] - view.bearings_rad[edge])) % (2.0 * math.pi)
    if other == edge or aside_rad > BESIDE_BEAMS * view.beam_rad:
        return _Side.FREE
    edge_m = float(view.ranges_m[edge])
    behind_m = float(view.ranges_m[other]) - edge_m
    jump_m = JUMP_M + JUMP_SIGMAS * float(range_sigma_m(edge_m))
    if behind_m < -jump_m:
        return _Side.NEARER
    return _Side.JOINED if behind_m < jump_m else _Side.FREE
