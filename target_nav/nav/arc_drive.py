"""Drives a base that cannot strafe towards a set of spots: a cost field for the way, arcs for the next second.

`Driver` for the same job on a base that strafes. Here a direction is not enough: what such a base can do next depends
on how fast it goes and turns now. So each of some hundred arcs is driven in thought, those that touch something
before the base could stop are dropped, and of the rest the one is taken whose end costs least to go on from.
"""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np

from target_nav.config import Config
from target_nav.nav.arcs import Arcs, clearances_m, roll_out
from target_nav.nav.cost_field import CostField
from target_nav.nav.drive_step import Drive
from target_nav.nav.footprint import Footprint
from target_nav.nav.nearest_point import NearestPoint
from target_nav.nav.route_memory import RouteMemory
from target_nav.nav.skill import View
from target_nav.nav.speed import YawControl, braking_speed_mps, over_dead_band, within_limits
from target_nav.state.types import STOP, Avoidance, FloatArray, Twist2D
from target_nav.utils.frames import points_to_parent

_REPLAN_S = 0.2
_FIELD_HALF_M, _FIELD_CELLS = 3.6, 48
_NEAR_CELL_M = 0.05
_AT_GOAL_M = 0.06
_COMFORT_M = 0.20
_MARGIN_M, _MARGIN_S = 0.010, 0.02
"""Over the stop clearance, at standstill and for each m/s: what one tick, one scan and odometry leave unsure."""
_REACTION_S = 0.15
_BRAKING = 0.7
"""Share of the braking limit that is counted on."""
_SOFT_M = 0.20
_SOFT_COST_M = 0.7
"""Less room than this costs, up to so much."""
_LOOK_M = 0.25
"""The field is read so far ahead of an arc's end, so that the heading there counts too..."""
_LOOK_MOST_M = 0.5
"""...but for no more than this."""
_TURN_COST_M = 0.02
"""For each rad/s that the turning rate changes by: of two equal arcs the steadier one."""


class ArcDriver:
    """`drive` is called each tick, as with `Driver`."""

    def __init__(self, config: Config) -> None:
        self._config, self._robot = config, config.robot
        self._body = Footprint.of(config.robot)
        self._memory = RouteMemory(config.avoid.look_ahead_m, config.avoid.memory_radius_m)
        self._yaw = YawControl(config.robot)
        avoid = config.avoid
        self._fits_m = config.robot.half_width_m + avoid.stop_clearance_m
        self._turns_m = self._body.circumscribed_radius_m + avoid.stop_clearance_m
        self._comfort_m = self._turns_m + _COMFORT_M
        self.reset()

    def forget(self) -> None:
        """`reset`, and forget the obstacles that are out of view too."""
        self._memory.clear()
        self.reset()

    def reset(self) -> None:
        """Plan anew from what is known."""
        self._field: CostField | None = None
        self._planned_s = -math.inf
        self._spots: FloatArray = np.empty((0, 3))

    @property
    def next_m(self) -> tuple[float, float] | None:
        """Where it is heading for in odom, to be kept off when it stuck there: an arc has no such place."""
        return None

    avoidance: Avoidance | None = None
    """It chooses arcs, not one of VFH's directions: there is none to look at."""

    @property
    def reach_m(self) -> float:
        """How far off the view is known to show obstacles."""
        return self._memory.reach_m

    def known_points(self, view: View) -> FloatArray:
        """Obstacles in odom, shape (N, 2): those in view, and those that were and are hidden now."""
        pose = view.pose_in_odom
        in_odom = points_to_parent(pose, view.obstacles_in_base_m)
        target = (view.track.x_m, view.track.y_m) if view.track is not None else None
        return self._memory.update(view.now_s, (pose.x_m, pose.y_m), in_odom, target)

    def drive(
        self,
        view: View,
        goals: Callable[[FloatArray], FloatArray],
        *,
        speed_mps: float,
        extra_points_m: FloatArray | None = None,
        at_goal_m: float = _AT_GOAL_M,
    ) -> Drive:
        """One tick towards the goals: spots in odom, shape (M, 3): x, y, extra cost.

        `goals` is called with the known obstacles (in odom) when a plan is due; no spots at all is no way.
        `extra_points_m` are further things to keep off, in base_link.
        """
        pose = view.pose_in_odom
        known = self.known_points(view)
        spots = goals(known) if view.now_s - self._planned_s >= _REPLAN_S else self._spots
        if extra_points_m is not None and len(extra_points_m):
            known = np.vstack([known, points_to_parent(pose, extra_points_m)])
        if view.now_s - self._planned_s >= _REPLAN_S:
            self._plan(view, known, spots)
        field = self._field
        if field is None or not len(self._spots):
            return Drive(STOP, math.inf, False, "no way")
        end_m = float(np.hypot(self._spots[:, 0] - pose.x_m, self._spots[:, 1] - pose.y_m).min())
        if end_m < at_goal_m:
            return Drive(STOP, 0.0, True, "there")
        to_go_m = float(field.at(np.array([pose.x_m]), np.array([pose.y_m]))[0])
        if not field.has_way:
            to_go_m = math.inf
        decel = 0.5 * self._robot.max_decel_mps2
        top = min(speed_mps, self._robot.max_speed_mps)
        top = min(top, max(braking_speed_mps(end_m, decel, 0.1), self._robot.min_speed_mps))
        twist = self._best(view, known, field, top, min(_LOOK_M, 0.5 * end_m))
        if twist is None:
            return Drive(STOP, to_go_m, False, "way blocked")
        return Drive(twist, to_go_m, False, "")

    def _plan(self, view: View, known: FloatArray, spots: FloatArray) -> None:
        pose = view.pose_in_odom
        self._planned_s, self._spots = view.now_s, spots
        self._field = None
        if len(spots):
            self._field = CostField(
                known,
                (pose.x_m, pose.y_m),
                spots,
                half_m=_FIELD_HALF_M,
                cell_m=_FIELD_HALF_M / _FIELD_CELLS,
                fits_m=self._fits_m,
                turns_m=self._turns_m,
                comfort_m=self._comfort_m,
            )

    def _best(
        self, view: View, known: FloatArray, field: CostField, top_mps: float, look_m: float
    ) -> Twist2D | None:
        """The velocity of the best arc; None when none is safe."""
        robot, pose = self._robot, view.pose_in_odom
        arcs = roll_out(pose, view.twist_in_base, robot, top_mps)
        half_m = float(arcs.way_m.max()) + self._body.circumscribed_radius_m + _SOFT_M
        near = NearestPoint(known, (pose.x_m, pose.y_m), half_m, _NEAR_CELL_M)
        room = clearances_m(arcs, near, self._body)
        least = self._config.avoid.stop_clearance_m + _MARGIN_M + _MARGIN_S * arcs.speeds_mps
        # nearer already than it should be: no nearer still, but away from it
        least = np.minimum(least, np.maximum(room[0] - 0.003, 0.002))
        touches = room < least
        first = np.where(touches.any(axis=0), touches.argmax(axis=0), len(room))
        index = np.arange(room.shape[1])
        last = np.maximum(first - 1, 0)
        speed = arcs.speeds_mps
        needs_m = _REACTION_S * speed + speed * speed / (2.0 * _BRAKING * robot.max_decel_mps2)
        safe = (first == len(room)) | (arcs.way_m[last, index] >= needs_m)
        safe &= first > 0
        if not safe.any():
            return None
        cost = self._costs(arcs, room, last, field, look_m, first < len(room))
        cost = cost + _TURN_COST_M * np.abs(arcs.rates_radps - view.twist_in_base.wz_radps)
        cost[~safe] = math.inf
        best = int(cost.argmin())
        if not math.isfinite(cost[best]):
            return None
        twist = Twist2D(float(speed[best]), 0.0, float(arcs.rates_radps[best]))
        return within_limits(over_dead_band(twist, robot), robot)

    def _costs(
        self,
        arcs: Arcs,
        room: FloatArray,
        last: np.ndarray,
        field: CostField,
        look_m: float,
        cut_short: np.ndarray,
    ) -> FloatArray:
        """Cost to go from where each arc ends, or where it would first touch something; room on the way counts."""
        index = np.arange(room.shape[1])
        x, y, yaw = arcs.x_m[last, index], arcs.y_m[last, index], arcs.yaw_rad[last, index]
        at_end = field.at(x, y)
        ahead = field.at(x + look_m * np.cos(yaw), y + look_m * np.sin(yaw))
        cost = np.minimum(ahead + look_m, at_end + _LOOK_MOST_M)
        lack = np.clip((_SOFT_M - room) / _SOFT_M, 0.0, 1.0) ** 2
        counted = np.arange(len(room))[:, None] <= last
        cost = cost + _SOFT_COST_M * (lack * counted).sum(axis=0) / (last + 1)
        result: FloatArray = cost + 0.2 * cut_short
        return result
