"""The RPLidar's samples as scans: one turn each, sorted into equal bins.

The frame is that of rplidar_ros, so that either driver can be used with one mounting: the sensor's zero is at pi, and
its clockwise angle counts down from there. Beams stay in the order in which they were taken, with a negative increment,
so a scan of a turning robot can be deskewed (rplidar_ros turns the order round and keeps the times).
"""

from __future__ import annotations

import math

import numpy as np

from target_nav.config import LidarConfig
from target_nav.hardware.rplidar_protocol import Samples
from target_nav.state.types import FloatArray, Scan

SAMPLE_PERIOD_S = 0.0005
"""The A1 measures 2000 times a second in standard scan (data sheet)."""

MAX_GAP_RAD = math.radians(30.0)
"""A turn in which more than this was not looked at is not a scan: it would be fresh, and blind."""

MIN_PERIOD_S, MAX_PERIOD_S = 0.05, 1.0
"""The A1 turns 2 to 10 times a second."""


class TurnAssembler:
    """Collects samples and gives a scan for each whole turn. What comes before the first turn's begin is left out."""

    def __init__(self, config: LidarConfig) -> None:
        self._config = config
        self._samples: list[Samples] = []
        self._begin_s: float | None = None
        self.dropped_turns = 0

    def add(self, samples: Samples, end_s: float) -> list[Scan]:
        """The scans completed by `samples`, the last of which was taken at `end_s` (monotonic)."""
        scans: list[Scan] = []
        times_s = end_s - SAMPLE_PERIOD_S * np.arange(len(samples) - 1, -1, -1.0)
        begun = 0
        for start in map(int, np.flatnonzero(samples.starts_turn)):
            self._keep(samples, begun, start)
            self._finish(float(times_s[start]), scans)
            begun = start
        self._keep(samples, begun, len(samples))
        if self._begin_s is not None and end_s - self._begin_s > 2.0 * MAX_PERIOD_S:
            # Whatever this is, it must not pile up.
            self.reset()
            self.dropped_turns += 1
        return scans

    def reset(self) -> None:
        """Forget the turn begun, as after a port was opened again."""
        self._samples.clear()
        self._begin_s = None

    def _keep(self, samples: Samples, begin: int, end: int) -> None:
        if self._begin_s is not None and end > begin:
            self._samples.append(_part(samples, begin, end))

    def _finish(self, now_s: float, scans: list[Scan]) -> None:
        if self._begin_s is not None:
            scan = self._scan(self._begin_s, now_s - self._begin_s)
            if scan is not None:
                scans.append(scan)
            else:
                self.dropped_turns += 1
        self._samples.clear()
        self._begin_s = now_s

    def _scan(self, begin_s: float, period_s: float) -> Scan | None:
        angle = np.concatenate([part.angle_rad for part in self._samples])
        range_m = np.concatenate([part.range_m for part in self._samples])
        steps = np.remainder(np.diff(angle) + math.pi, 2.0 * math.pi) - math.pi
        if not MIN_PERIOD_S <= period_s <= MAX_PERIOD_S or steps.sum() > 2.0 * math.pi + MAX_GAP_RAD:
            return None
        if _widest_gap_rad(angle) > MAX_GAP_RAD:
            return None
        config = self._config
        # The first sample lies beside zero, on either side.
        ahead_rad = math.remainder(float(angle[0]), 2.0 * math.pi)
        step_rad = 2.0 * math.pi / config.beams
        return Scan(
            stamp_s=begin_s + period_s * (0.5 * step_rad - ahead_rad) / (2.0 * math.pi),
            angle_min_rad=math.pi - 0.5 * step_rad,
            angle_increment_rad=-step_rad,
            time_increment_s=period_s / config.beams,
            range_min_m=config.range_min_m,
            range_max_m=config.range_max_m,
            ranges_m=_binned(angle, range_m, config),
        )


def _binned(angle_rad: FloatArray, range_m: FloatArray, config: LidarConfig) -> FloatArray:
    """The nearest return in each bin, `inf` where there was none. The first bin begins at the sensor's zero.

    Samples are not locked to the head's angle: a beam is off its bin's middle by up to half a bin, and a bin may be
    left out in one turn. Nothing is interpolated: between two returns there need not be anything.
    """
    index = np.minimum((angle_rad * (config.beams / (2.0 * math.pi))).astype(np.intp), config.beams - 1)
    valid = (range_m >= config.range_min_m) & (range_m <= config.range_max_m)
    bins = np.full(config.beams, math.inf)
    np.minimum.at(bins, index[valid], range_m[valid])
    return bins


def _widest_gap_rad(angle_rad: FloatArray) -> float:
    ordered = np.sort(angle_rad)
    return float(np.diff(ordered, append=ordered[0] + 2.0 * math.pi).max())


def _part(samples: Samples, begin: int, end: int) -> Samples:
    return Samples(
        samples.angle_rad[begin:end],
        samples.range_m[begin:end],
        samples.quality[begin:end],
        samples.starts_turn[begin:end],
    )
