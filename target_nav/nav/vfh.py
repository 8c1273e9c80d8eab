"""VFH+: which way to go now, from a polar histogram of how far the body can move in each direction.

After Ulrich and Borenstein, "VFH+: Reliable Obstacle Avoidance for Fast Mobile Robots" (ICRA 1998): a binary
histogram with hysteresis, valleys, and a cost of the target, the present motion and the last choice. The histogram
differs: instead of growing points by a disc, each sector holds the exact distance the rectangular body can translate,
keeping its heading (a base that strafes) or with its front turned that way. So a narrow body passes a narrow
door and a gap narrower than the body is never a valley.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from target_nav.config import Config
from target_nav.nav.footprint import Footprint
from target_nav.state.types import FloatArray
from target_nav.utils.frames import wrap_angle

_NARROW_SECTORS = 5
"""Valleys up to this wide are entered through their middle, wider ones beside their edge."""
_EDGE_SECTORS = 2
_HYSTERESIS = 0.8
"""An open sector stays open down to this share of the distance that opens a closed one."""
_FINE_RAD = np.radians([0.0, 1.5, -1.5, 3.0, -3.0, 4.5, -4.5, 6.0, -6.0, 8.0, -8.0])
"""Beside the goal's direction, nearest first: to a gap with four centimetres to spare, five degrees are blunt."""
_MAX_DETOUR_RAD = math.radians(110.0)
"""Directions that lead away from the goal are the route planner's business; here they would mean circling."""
_SHORTER = (1.0, 0.5, 0.25)
"""If nothing is open as far as the goal, a shorter free way will do."""
_LEAST_FREE_M = 0.04


@dataclass(frozen=True)
class Steering:
    """Direction of motion in base_link, and how far the body can move that way before its margin is touched."""

    direction_rad: float
    free_m: float


class Vfh:
    """One histogram and its memory. A skill that may turn the body keeps one for each way of holding it."""

    def __init__(self, config: Config, *, turned: bool) -> None:
        """`turned`: the body faces the direction it moves in; otherwise it keeps its heading."""
        self._avoid = config.avoid
        self._footprint = Footprint.of(config.robot)
        self._turned = turned
        self._step_rad = 2.0 * math.pi / config.avoid.sectors
        half = config.avoid.sectors // 2
        sectors: FloatArray = np.arange(config.avoid.sectors, dtype=np.float64)
        self._angles: FloatArray = (sectors - half) * self._step_rad
        # Never less than what the limiter keeps free, or it would stop what was chosen here.
        self._margins = (
            max(config.avoid.margin_m, config.avoid.stop_clearance_m + 0.005),
            config.avoid.stop_clearance_m + 0.005,
        )
        self.reset()

    def reset(self) -> None:
        self.free_sectors_m: FloatArray | None = None
        """The last histogram, for whoever wants to show it; its directions are `directions_rad`."""
        self._open: NDArray[np.bool_] | None = None
        self._open_yaw_rad = 0.0
        self._last_in_odom_rad: float | None = None

    def steer(
        self,
        points_m: FloatArray,
        *,
        yaw_rad: float,
        goal_rad: float,
        goal_m: float,
        motion_rad: float | None,
    ) -> Steering | None:
        """Choose a direction towards a goal at bearing `goal_rad`, `goal_m` away; None if there is none.

        `points_m` are obstacles in base_link, finite, shape (N, 2). `yaw_rad` is the heading in odom, in which the
        memory is kept while the body turns. `motion_rad` is the direction it moves in now, None when it stands.
        """
        wanted_m = min(self._avoid.look_ahead_m, goal_m)
        reach = self._footprint.circumscribed_radius_m + self._avoid.look_ahead_m
        near = points_m[np.hypot(points_m[:, 0], points_m[:, 1]) < reach] if len(points_m) else points_m
        # Mirrored with the goal, so that a mirrored world gives the mirrored choice.
        fine = goal_rad + math.copysign(1.0, goal_rad) * _FINE_RAD
        directions = np.concatenate([self._angles, fine])
        for margin_m in dict.fromkeys(self._margins):
            free = self._free(near, directions, margin_m)
            self.free_sectors_m = free[: len(self._angles)]
            for share in _SHORTER:
                need_m = max(share * wanted_m, min(wanted_m, _LEAST_FREE_M))
                chosen = self._choose(directions, free, need_m, yaw_rad, goal_rad, motion_rad)
                if chosen is not None:
                    return chosen
        self._last_in_odom_rad = None
        return None

    @property
    def directions_rad(self) -> FloatArray:
        """The middle of each sector in base_link, shape (S,)."""
        return self._angles

    def free_m(self, points_m: FloatArray, direction_rad: float, margin_m: float | None = None) -> float:
        """How far the body can go in one direction with its preferred margin (or another one)."""
        margin = self._margins[0] if margin_m is None else margin_m
        return float(self._free(points_m, np.array([direction_rad]), margin)[0])

    def _free(self, points_m: FloatArray, directions_rad: FloatArray, margin_m: float) -> FloatArray:
        body = self._footprint
        measure = body.free_distances_turned_m if self._turned else body.free_distances_m
        return measure(points_m, directions_rad, margin_m)

    def _choose(
        self,
        directions_rad: FloatArray,
        free: FloatArray,
        need_m: float,
        yaw_rad: float,
        goal_rad: float,
        motion_rad: float | None,
    ) -> Steering | None:
        sectors, fine_m = free[: len(self._angles)], free[len(self._angles) :]
        is_open = sectors >= np.where(self._was_open(yaw_rad), _HYSTERESIS * need_m, need_m)
        goal_sector = round(goal_rad / self._step_rad) + len(sectors) // 2
        need_fine_m = need_m * (_HYSTERESIS if is_open[goal_sector % len(sectors)] else 1.0)
        open_fine = np.flatnonzero(fine_m >= need_fine_m)
        straight = len(sectors) + int(open_fine[0]) if len(open_fine) else None
        towards_goal = float(directions_rad[straight]) if straight is not None else math.nan
        candidates = [towards_goal] if straight is not None else []
        candidates += self._edges(is_open, goal_rad)
        best: float | None = None
        best_cost = math.inf
        for direction in candidates:
            if abs(wrap_angle(direction - goal_rad)) > _MAX_DETOUR_RAD:
                continue
            cost = self._cost(direction, goal_rad, motion_rad, yaw_rad)
            if cost < best_cost - 1e-9:
                best, best_cost = direction, cost
        if best is None:
            return None
        self._open, self._open_yaw_rad = is_open, yaw_rad
        self._last_in_odom_rad = wrap_angle(best + yaw_rad)
        index = (round(best / self._step_rad) + len(sectors) // 2) % len(sectors)
        return Steering(best, float(free[straight] if best == towards_goal and straight else sectors[index]))

    def _was_open(self, yaw_rad: float) -> NDArray[np.bool_]:
        """Last time's open sectors, as seen from today's heading."""
        if self._open is None:
            return np.zeros(len(self._angles), dtype=np.bool_)
        return np.roll(self._open, -round(wrap_angle(yaw_rad - self._open_yaw_rad) / self._step_rad))

    def _edges(self, is_open: NDArray[np.bool_], goal_rad: float) -> list[float]:
        """VFH+'s candidates: the middle of a narrow valley, both edges of a wide one, offset to the inside."""
        if is_open.all():
            return [goal_rad]
        count = len(is_open)
        starts = np.flatnonzero(is_open & ~np.roll(is_open, 1))
        ends = np.flatnonzero(is_open & ~np.roll(is_open, -1))
        found: list[float] = []
        for first in starts.tolist():
            last = next(
                (end for end in ends.tolist() if end >= first), int(ends[0]) + count if len(ends) else first
            )
            if last - first < _NARROW_SECTORS:
                found.append(self._angle(0.5 * (first + last)))
            else:
                found += [self._angle(first + _EDGE_SECTORS), self._angle(last - _EDGE_SECTORS)]
        return found

    def _angle(self, sector: float) -> float:
        return wrap_angle((sector - len(self._angles) // 2) * self._step_rad)

    def _cost(self, direction: float, goal_rad: float, motion_rad: float | None, yaw_rad: float) -> float:
        cost = self._avoid.cost_target * abs(wrap_angle(direction - goal_rad))
        if motion_rad is not None:
            cost += self._avoid.cost_heading * abs(wrap_angle(direction - motion_rad))
        if self._last_in_odom_rad is not None:
            cost += self._avoid.cost_previous * abs(wrap_angle(direction + yaw_rad - self._last_in_odom_rad))
        return cost
