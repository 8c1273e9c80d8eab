"""Where a flat target's face looks in odom, from all pictures of it so far.

A square seen from afar has two poses that fit its corners, one the mirror image of the other about the line of sight
(Collins and Bartoli, *Infinitesimal plane-based pose estimation*, IJCV 109, 2014). Which is true, two things tell: it
fits better, the nearer the more clearly; and in odom it stays where it is while the robot drives round it, where the
false one wanders. A histogram filter over the direction takes both at once (Thrun, Burgard and Fox, *Probabilistic
Robotics*, 8.2): each picture multiplies in what its two poses say. It forgets slowly, for odometry's heading drifts.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from target_nav.state.types import Detection, FloatArray
from target_nav.utils.frames import wrap_angle

CORNER_SIGMA_PX = 0.3
"""A corner's error: noise, blur and what calibration leaves of the lens. In clean pictures it is half of that."""
FORGET = 0.98
"""A picture: what was seen fifty pictures ago counts for a third."""
INDEPENDENT = 0.3
"""Pictures of a robot that stands are wrong in the same way; ten of them count as three."""
OUTLIER = 0.02
"""Share of pictures in which neither pose is true."""
SURE = 0.8
"""Of the belief, within `MODE_RAD` of its peak: less, and nothing is said."""
MODE_RAD = 0.35
LARGEST_SIGMA_RAD = 0.25
FLOOR_RAD = 0.02
"""The camera's mount, and what odometry's heading has drifted since."""

_BINS = 360
_BIN_RAD = 2.0 * math.pi / _BINS
_DIRECTIONS: FloatArray = np.asarray(-math.pi + (np.arange(_BINS) + 0.5) * _BIN_RAD, np.float64)
_LEAST_SIGMA_RAD = 1.5 * _BIN_RAD
"""Narrower, a peak would fall between two bins."""


@dataclass(frozen=True)
class FaceLook:
    """One of the poses of one picture. `facing_rad` is in the camera's frame; the weights of a picture sum to one."""

    facing_rad: float
    sigma_rad: float
    weight: float


@dataclass(frozen=True)
class FaceEstimate:
    """Direction of the outward normal in odom, and the standard deviation of it."""

    facing_in_odom_rad: float
    sigma_rad: float


def looks_of(detection: Detection, focal_px: float) -> tuple[FaceLook, ...]:
    """What a detection says of its face; empty if nothing, or nothing that is finite.

    A pose's weight is the likelihood of its eight residuals. Its sigma is the corners' error over what a turn by an
    angle t changes in the picture of a square that is h pixels high: its width h cos(t), and by h h / f sin(t) the
    difference of its upright edges.
    """
    facings = [facing for facing in (detection.facing, detection.other_facing) if facing is not None]
    facings = [f for f in facings if math.isfinite(f.facing_rad) and 0.0 <= f.error_px < math.inf]
    if not facings:
        return ()
    best_px = min(facing.error_px for facing in facings)
    weights = [math.exp(-4.0 * (f.error_px**2 - best_px**2) / CORNER_SIGMA_PX**2) for f in facings]
    height_px = detection.height_px
    looks = []
    for facing, weight in zip(facings, weights):
        turned_rad = wrap_angle(facing.facing_rad - detection.bearing_rad - math.pi)
        by_width = height_px * math.sin(turned_rad)
        by_edges = 0.5 * height_px * height_px / focal_px * math.cos(turned_rad)
        sigma_rad = CORNER_SIGMA_PX / max(math.hypot(by_width, by_edges), 1e-6)
        looks.append(FaceLook(facing.facing_rad, min(sigma_rad, math.pi), weight / sum(weights)))
    return tuple(looks)


class FacingBelief:
    """`add` once a picture; `estimate` is what is believed then."""

    def __init__(self) -> None:
        self._log: FloatArray | None = None
        self.estimate: FaceEstimate | None = None

    def add(self, looks: Sequence[FaceLook], camera_yaw_in_odom_rad: float) -> None:
        """The poses of one picture, and where the camera looked when it was taken."""
        if not looks or not math.isfinite(camera_yaw_in_odom_rad):
            return
        likelihood = np.full(_BINS, OUTLIER / (2.0 * math.pi))
        for look in looks:
            off = _DIRECTIONS - (look.facing_rad + camera_yaw_in_odom_rad)
            off -= 2.0 * math.pi * np.rint(off / (2.0 * math.pi))
            sigma_rad = max(look.sigma_rad, _LEAST_SIGMA_RAD)
            share = (1.0 - OUTLIER) * look.weight / (math.sqrt(2.0 * math.pi) * sigma_rad)
            likelihood += share * np.exp(-0.5 * (off / sigma_rad) ** 2)
        before = 0.0 if self._log is None else FORGET * self._log
        self._log = before + INDEPENDENT * np.log(likelihood)
        self.estimate = _estimate(self._log)


def _estimate(log_belief: FloatArray) -> FaceEstimate | None:
    """Mean and sigma of the largest mode; None while too much is believed of other directions."""
    peak = int(log_belief.argmax())
    belief = np.exp(log_belief - log_belief[peak])
    off = _DIRECTIONS - _DIRECTIONS[peak]
    off -= 2.0 * math.pi * np.rint(off / (2.0 * math.pi))
    near = np.abs(off) <= MODE_RAD
    mass, off = belief[near], off[near]
    total = float(mass.sum())
    if total < SURE * float(belief.sum()):
        return None
    mean = float(mass @ off) / total
    sigma_rad = math.hypot(math.sqrt(float(mass @ (off - mean) ** 2) / total), FLOOR_RAD)
    if sigma_rad > LARGEST_SIGMA_RAD:
        return None
    return FaceEstimate(wrap_angle(float(_DIRECTIONS[peak]) + mean), sigma_rad)
