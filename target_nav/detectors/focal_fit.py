"""The focal length and the mount's yaw from a pin at distances that were measured with a tape.

A thing of height H at depth d is f H / d pixels tall, so H / pixels over d is a straight line of slope 1 / f through
the origin. If it misses that, somebody measured from another point than the lens: that is told, not believed.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from target_nav.errors import DeviceError

SPREAD_MAX = 0.1
"""Relative spread of the boxes' heights at one distance; more is not one thing standing still."""
MISFIT_MAX = 0.05
"""Relative: a distance whose focal length is off the common one by more was measured or typed wrongly."""
BOXES_MIN = 5


@dataclass(frozen=True)
class Sighting:
    """A target of `height_m` at `depth_m` before the lens: heights and middle columns of many boxes of it, pixels."""

    depth_m: float
    height_m: float
    heights_px: tuple[float, ...]
    columns_px: tuple[float, ...]


@dataclass(frozen=True)
class FocalFit:
    """`focal_sigma_px` is the standard error; `offset_m` how much longer the distances look than they were given (None:
    all at one distance); `residuals` the relative misfit of each sighting; `bearing_rad` of the target, left positive.
    """

    focal_px: float
    focal_sigma_px: float
    offset_m: float | None
    residuals: tuple[float, ...]
    bearing_rad: float


def fit_focal(sightings: Sequence[Sighting], center_u_px: float) -> FocalFit:
    """Weighted least squares over all sightings, each as sure as its boxes are many and alike.

    `focal_px` is the upright one, for heights were measured; divide by the pixel aspect for the sideways one. The
    bearing is taken with it, too, which for a target near the axis makes no difference.

    Raises:
        DeviceError: too few boxes, boxes that are not alike, or a distance that does not fit the others.
    """
    if not sightings:
        raise DeviceError("no sighting; put the target before the camera and give its distance")
    focal, variance = zip(*(_focal_of(sighting) for sighting in sightings))
    weights = 1.0 / np.array(variance)
    mean = float(np.sum(weights * np.array(focal)) / np.sum(weights))
    residuals = tuple(float(each / mean - 1.0) for each in focal)
    worst = int(np.argmax(np.abs(residuals)))
    if abs(residuals[worst]) > MISFIT_MAX:
        raise DeviceError(
            f"the sighting at {sightings[worst].depth_m:g} m is {100 * residuals[worst]:+.1f} % off the common focal "
            f"length {mean:.0f} px (limit {100 * MISFIT_MAX:g} %); measure that distance again, from the lens to the "
            "target's axis"
        )
    # What the sightings differ by counts, too, when they are more than one: the tape's error is in no box.
    statistical = math.sqrt(1.0 / float(np.sum(weights)))
    scatter = float(np.std(focal, ddof=1)) / math.sqrt(len(focal)) if len(focal) > 1 else 0.0
    columns = np.concatenate([np.array(s.columns_px) for s in sightings])
    bearing = math.atan2(center_u_px - float(np.median(columns)), mean)
    return FocalFit(mean, max(statistical, scatter), _offset(sightings), residuals, bearing)


def _focal_of(sighting: Sighting) -> tuple[float, float]:
    """(focal length, its variance) by one sighting: the median box, and how sure it is."""
    heights = np.array(sighting.heights_px)
    if heights.size < BOXES_MIN:
        raise DeviceError(
            f"only {heights.size} boxes at {sighting.depth_m:g} m (at least {BOXES_MIN}); is the target seen?"
        )
    if not (sighting.depth_m > 0.0 and sighting.height_m > 0.0 and bool((heights > 0.0).all())):
        raise DeviceError(
            f"distance {sighting.depth_m} m, height {sighting.height_m} m: both must be greater than 0"
        )
    middle = float(np.median(heights))
    # A normal distribution's sigma is 1.4826 times its median deviation.
    spread = 1.4826 * float(np.median(np.abs(heights - middle)))
    if spread > SPREAD_MAX * middle:
        raise DeviceError(
            f"boxes at {sighting.depth_m:g} m vary by {100 * spread / middle:.0f} % (limit {100 * SPREAD_MAX:g} %); is "
            "there more than one target, or does it move?"
        )
    scale = sighting.depth_m / sighting.height_m
    # A quarter of a pixel at least: many equal boxes are not sure beyond the detector's own grid.
    sigma_px = max(spread / math.sqrt(heights.size), 0.25)
    return middle * scale, (sigma_px * scale) ** 2


def _offset(sightings: Sequence[Sighting]) -> float | None:
    """Where the straight line of 1 / pixels over depth begins, metres behind the point that was measured from."""
    depths = np.array([s.depth_m for s in sightings])
    if np.ptp(depths) < 0.25 * float(depths.min()):
        return None
    inverse = np.array([s.height_m / float(np.median(s.heights_px)) for s in sightings])
    slope, begin = np.polyfit(depths, inverse, 1)
    return float(begin / slope)
