"""The rotating LiDAR: ranges with the noise, drop-outs, lost turns and skew that were measured on an RPLidar A1.

Each beam starts from the pose the robot had when the beam was taken, so a scan of a turning robot is skewed as a real
one is. Figures: 10,481 scans of real logs (`docs/simulator.md`).
"""

from __future__ import annotations

import math

import numpy as np

from target_nav.config import LidarConfig
from target_nav.sim.history import PoseHistory
from target_nav.sim.world import RayCaster
from target_nav.state.types import FloatArray, Scan

RANGE_EDGES_M = np.array([0.5, 1.0, 1.5, 2.5, 3.5, 4.5])
SIGMA_M = np.array([0.0013, 0.0025, 0.0045, 0.0065, 0.013, 0.020, 0.031])
"""Median noise between the edges; the last one was measured to 6 m and is used beyond."""

SIGMA_SPREAD = math.log(3.0) / 1.2816
"""The measured noise's p90 is three times its median: each beam's sigma is the median times exp(this * normal)."""

DROPOUT = np.array([0.13, 0.15, 0.17, 0.19, 0.235, 0.30, 0.44])
"""Share of beams without a return: measured 13-19 % to 2.5 m, 20-27 % to 3.5 m, 30 % to 4.5 m, 44 % beyond."""

QUANTUM_M = 0.002

PERIOD_SPREAD = 0.02
"""Sigma of a turn's period, of its own: measured 182 ms, p5 178, p95 190."""

LOST_TURNS = (0.8, 0.95)
"""Where turns are lost it is one in 80 %, two in 15 % and three in 5 %: gaps of up to 0.7 s were measured, their
shares were not."""


class Lidar:
    """`advance` gives the scans that were completed by then. Stamps are those of the first beam."""

    def __init__(
        self, config: LidarConfig, caster: RayCaster, rng: np.random.Generator, start_s: float
    ) -> None:
        self._config = config
        self._caster = caster
        self._rng = rng
        full_turn = config.fov_rad >= 2.0 * math.pi - 1e-6
        steps = config.beams if full_turn else config.beams - 1
        self._angle_min_rad = -0.5 * config.fov_rad
        self._angle_increment_rad = config.fov_rad / steps
        self._index = np.arange(config.beams, dtype=np.float64)
        self._angles = self._angle_min_rad + self._angle_increment_rad * self._index + config.yaw_rad
        self._turn_share = config.beams * self._angle_increment_rad / (2.0 * math.pi)
        self._turns_to_lose = 0
        # Where in its turn the head is when the run begins is chance.
        self._begin_s = start_s + float(rng.random()) / config.rate_hz
        self._period_s = 0.0
        self.due_s = 0.0
        self._start_turn(self._begin_s)

    def advance(self, now_s: float, history: PoseHistory) -> list[Scan]:
        """Scans whose last beam was taken by `now_s`, oldest first."""
        scans: list[Scan] = []
        while self.due_s <= now_s:
            scan = self._scan(history)
            if self._survives():
                scans.append(scan)
            self._start_turn(self._begin_s + self._period_s)
        return scans

    def _start_turn(self, begin_s: float) -> None:
        self._begin_s = begin_s
        spread = min(max(float(self._rng.standard_normal()), -3.0), 3.0) * PERIOD_SPREAD
        self._period_s = (1.0 + spread) / self._config.rate_hz
        self.due_s = begin_s + min(self._turn_share, 1.0) * self._period_s

    def _survives(self) -> bool:
        lost, how_many = self._rng.random(2)
        if self._turns_to_lose == 0 and lost < self._config.lost_scan_probability:
            self._turns_to_lose = 1 + sum(how_many > share for share in LOST_TURNS)
        if self._turns_to_lose > 0:
            self._turns_to_lose -= 1
            return False
        return True

    def _scan(self, history: PoseHistory) -> Scan:
        config = self._config
        increment_s = self._period_s * self._angle_increment_rad / (2.0 * math.pi)
        x, y, yaw = history.at_many(self._begin_s + increment_s * self._index)
        if config.x_m or config.y_m:
            c, s = np.cos(yaw), np.sin(yaw)
            x = x + c * config.x_m - s * config.y_m
            y = y + s * config.x_m + c * config.y_m
        # Samples are not locked to the head's angle: a driver that sorts them into even bins is off by up to half a
        # bin, anew each turn. That is why a thin thing is met by one beam more or less from turn to turn.
        phase_rad = (float(self._rng.random()) - 0.5) * self._angle_increment_rad
        if config.noise_scale == 0.0:
            phase_rad = 0.0
        direction = yaw + (self._angles + phase_rad)
        ranges = self._measure(self._caster.cast(x, y, np.cos(direction), np.sin(direction)))
        return Scan(
            stamp_s=self._begin_s,
            angle_min_rad=self._angle_min_rad,
            angle_increment_rad=self._angle_increment_rad,
            time_increment_s=increment_s,
            range_min_m=config.range_min_m,
            range_max_m=config.range_max_m,
            ranges_m=ranges,
        )

    def _measure(self, true_m: FloatArray) -> FloatArray:
        """What the sensor says of true ranges: noise, steps of 2 mm, drop-outs and blind zones as `inf`."""
        config = self._config
        normal = self._rng.standard_normal((2, len(true_m)))
        chance = self._rng.random(len(true_m))
        bin_of = np.searchsorted(RANGE_EDGES_M, true_m)
        sigma = SIGMA_M[bin_of] * np.exp(SIGMA_SPREAD * normal[0])
        with np.errstate(invalid="ignore"):
            measured = true_m + config.range_offset_m + config.noise_scale * sigma * normal[1]
            measured = np.rint(measured / QUANTUM_M) * QUANTUM_M
        blind = (
            (true_m < config.range_min_m) | (measured < config.range_min_m) | (measured > config.range_max_m)
        )
        measured[blind | (chance < config.dropout_scale * DROPOUT[bin_of])] = np.inf
        return measured
