"""Drives towards a set of spots round obstacles: a route for the way, VFH+ for the next step, a heading to hold.

A base that strafes keeps facing what it is told to look at and moves in any direction; where that is too wide for
the gap it turns its front along the way first. A differential base always does.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from target_nav.config import Config
from target_nav.nav.drive_step import Drive
from target_nav.nav.footprint import FAR_M, Footprint
from target_nav.nav.room import Room
from target_nav.nav.route import Route, RoutePlanner
from target_nav.nav.route_memory import RouteMemory
from target_nav.nav.skill import View
from target_nav.nav.speed import (
    YawControl,
    braking_speed_mps,
    clearance_speed_mps,
    over_dead_band,
    within_limits,
)
from target_nav.nav.steering import BodySteering
from target_nav.nav.vfh import Steering
from target_nav.state.types import STOP, Avoidance, FloatArray, Twist2D
from target_nav.utils.frames import points_to_parent, to_child, to_parent, wrap_angle

_REPLAN_S = 0.3
_MAY_WAIT_S = 0.1
"""So much later at most, for a tick that has nothing else that is heavy. Avoidance and limiter never wait."""
_REACHED_M = 0.12
_AT_GOAL_M = 0.06
_REACTION_S = 0.25
"""Scan, tick and drivetrain together."""
_GENTLE = 0.4
"""Share of the braking limit that is planned with."""
_TURN_FIRST_RAD = math.radians(40.0)
_TURNS_RAD, _HAS_TURNED_RAD, _IN_VAIN_S = math.radians(15.0), 0.08, 0.6
_CREEP_MPS = 0.06


@dataclass(frozen=True)
class _Leg:
    """Where to steer for now, in base_link; how far the last spot is (`FAR_M`: out of sight); the cost to it."""

    next_m: tuple[float, float]
    end_m: float
    cost_to_go_m: float


__all__ = ["Drive", "Driver"]


class Driver:
    def __init__(self, config: Config) -> None:
        self._config = config
        self._body = Footprint.of(config.robot)
        self._holonomic = config.robot.drive != "differential"
        self._planner = RoutePlanner(config)
        self._memory = RouteMemory(config.avoid.look_ahead_m, config.avoid.memory_radius_m)
        self._steering = BodySteering(config)
        self._yaw = YawControl(config.robot)
        self._room = Room(config)
        self.reset()

    @property
    def reach_m(self) -> float:
        """How far off the view is known to show obstacles."""
        return self._memory.reach_m

    @property
    def next_m(self) -> tuple[float, float] | None:
        """Where it is heading for in odom; None without a way."""
        return None if self.route is None else self.route.next_m

    @property
    def avoidance(self) -> Avoidance | None:
        """What the last `drive` chose, for a person to look at; None when it chose nothing."""
        return self._steering.avoidance

    @property
    def route(self) -> Route | None:
        return self._planner.route

    def forget(self) -> None:
        """`reset`, and forget the obstacles that are out of view too."""
        self._memory.clear()
        self.reset()

    def reset(self) -> None:
        """Plan anew from what is known."""
        self._planner.reset()
        self._steering.reset()
        self._yaw.reset()
        self._planned_s = -math.inf
        self._straight_in_odom_m: tuple[float, float] | None = None
        self._turned_to_rad, self._turned_at_s = -10.0, math.inf

    def drive(
        self,
        view: View,
        goals: Callable[[FloatArray], FloatArray],
        *,
        speed_mps: float,
        face_rad: float | None = None,
        face_top_radps: float = 0.8,
        straight_to_m: tuple[float, float] | None = None,
        extra_points_m: FloatArray | None = None,
        at_goal_m: float = _AT_GOAL_M,
        limit_m: float = 15.0,
    ) -> Drive:
        """One tick towards the goals: spots in odom, shape (M, 3): x, y, extra cost.

        `goals` is called with the known obstacles (in odom) when a plan is due; no spots at all is no way.
        `face_rad` is the bearing to look at, None to look where it goes, turning no faster than `face_top_radps`.
        `straight_to_m` (in base_link) needs no route: the caller has seen that the way there is free.
        `extra_points_m` are further things to keep off, in base_link. `limit_m` bounds the cost of a way.
        """
        points = view.obstacles_in_base_m
        self._steering.avoidance = None
        leg = self._leg(view, goals, straight_to_m, extra_points_m, limit_m)
        if leg is None:
            return Drive(self._look(view, face_rad), math.inf, False, "no way")
        if leg.end_m < at_goal_m:
            return Drive(self._look(view, face_rad), 0.0, True, "there")
        if extra_points_m is not None and len(extra_points_m):
            points = np.vstack([points, extra_points_m])
        steering = self._steering.steer(view, points, leg.next_m, face_rad)
        if steering is None:
            self._planned_s = min(self._planned_s, view.now_s - 0.5 * _REPLAN_S)
            return Drive(self._unwedge(view, points, leg.next_m), leg.cost_to_go_m, False, "way blocked")
        top = self._speed(points, steering, speed_mps, leg.end_m)
        twist = self._twist(view, points, steering, top, face_rad, face_top_radps)
        return Drive(
            twist, leg.cost_to_go_m, False, "turned along the way" if self._steering.along_the_way else ""
        )

    def costs_to(self, view: View, spots_m: FloatArray, limit_m: float) -> FloatArray:
        """Cost of the way to each spot in odom, shape (K,) for (K, 2); infinite without one."""
        pose = view.pose_in_odom
        return self._planner.costs_to(self.known_points(view), (pose.x_m, pose.y_m), spots_m, limit_m)

    def known_points(self, view: View) -> FloatArray:
        """Obstacles in odom, shape (N, 2): those in view, and those that were and are hidden now."""
        pose = view.pose_in_odom
        in_odom = points_to_parent(pose, view.obstacles_in_base_m)
        target = (view.track.x_m, view.track.y_m) if view.track is not None else None
        return self._memory.update(view.now_s, (pose.x_m, pose.y_m), in_odom, target)

    def _leg(
        self,
        view: View,
        goals: Callable[[FloatArray], FloatArray],
        straight_to_m: tuple[float, float] | None,
        extra_points_m: FloatArray | None,
        limit_m: float,
    ) -> _Leg | None:
        pose = view.pose_in_odom
        last_m, self._straight_in_odom_m = self._straight_in_odom_m, None
        if straight_to_m is None and last_m is not None and view.is_busy:
            # The straight way has just been closed, and a plan may wait a tick: avoidance looks after that long.
            straight_to_m = to_child(pose, *last_m)
        elif straight_to_m is not None:
            self._straight_in_odom_m = to_parent(pose, *straight_to_m)
        if straight_to_m is not None:
            self._planner.reset()
            self._planned_s = -math.inf
            way_m = math.hypot(*straight_to_m)
            return _Leg(straight_to_m, way_m, way_m)
        route = self._route(view, goals, extra_points_m, limit_m)
        if route is None:
            return None
        in_sight = route.sight >= len(route.points_m) - 1
        last = to_child(pose, float(route.points_m[-1, 0]), float(route.points_m[-1, 1]))
        # What is left counts from here, not from where the plan was made.
        gone_m = math.hypot(pose.x_m - route.points_m[0, 0], pose.y_m - route.points_m[0, 1])
        return _Leg(
            to_child(pose, *route.next_m),
            math.hypot(*last) if in_sight else FAR_M,
            max(route.cost_m - gone_m, 0.0),
        )

    def _route(
        self,
        view: View,
        goals: Callable[[FloatArray], FloatArray],
        extra_points_m: FloatArray | None,
        limit_m: float,
    ) -> Route | None:
        pose = view.pose_in_odom
        route = self._planner.route
        waited_s = view.now_s - self._planned_s - _REPLAN_S
        due = waited_s >= 0.0
        if route is not None and not due:
            x, y = to_child(pose, *route.next_m)
            due = math.hypot(x, y) < _REACHED_M and route.sight < len(route.points_m) - 1
        if view.is_busy and route is not None and waited_s < _MAY_WAIT_S:
            due = False
        if due:
            self._planned_s = view.now_s
            known = self.known_points(view)
            spots = goals(known)
            if extra_points_m is not None and len(extra_points_m):
                known = np.vstack([known, points_to_parent(pose, extra_points_m)])
            route = self._planner.plan(known, (pose.x_m, pose.y_m), spots, limit_m) if len(spots) else None
        return route

    def _speed(self, points: FloatArray, steering: Steering, top_mps: float, end_m: float) -> float:
        avoid, robot = self._config.avoid, self._config.robot
        decel = _GENTLE * robot.max_decel_mps2
        top = min(top_mps, braking_speed_mps(steering.free_m, decel, _REACTION_S))
        top = min(top, max(braking_speed_mps(end_m, decel, _REACTION_S), robot.min_speed_mps))
        if len(points):
            ahead = (
                math.cos(steering.direction_rad) * points[:, 0]
                + math.sin(steering.direction_rad) * points[:, 1]
            )
            front = points[ahead > 0.0]
            if len(front):
                clearance = float(self._body.clearances_m(front).min())
                top = clearance_speed_mps(
                    clearance, top, _CREEP_MPS, avoid.stop_clearance_m, avoid.slow_clearance_m
                )
        return top

    def _twist(
        self,
        view: View,
        points: FloatArray,
        steering: Steering,
        top_mps: float,
        face_rad: float | None,
        face_top_radps: float,
    ) -> Twist2D:
        robot = self._config.robot
        direction = steering.direction_rad
        heading = direction if self._steering.along_the_way or face_rad is None else face_rad
        wz = self._yaw.rate_radps(heading, view.twist_in_base.wz_radps)
        if not self._steering.along_the_way:
            wz = max(-face_top_radps, min(face_top_radps, wz))
        speed = top_mps
        if self._steering.along_the_way:
            # It only fits turned: turn first, then go.
            speed *= max(0.0, 1.0 - abs(direction) / _TURN_FIRST_RAD)
        vx, vy = speed * math.cos(direction), speed * math.sin(direction)
        if not self._holonomic:
            vx, vy = max(vx, 0.0), 0.0
        if self._steering.along_the_way and self._turns_in_vain(view, direction):
            # In a bend a corner of the body would touch: make room for it.
            away = self._room.for_turning(points)
            if away != STOP:
                vx, vy = away.vx_mps, away.vy_mps
        return within_limits(over_dead_band(Twist2D(vx, vy, wz), robot), robot)

    def _unwedge(self, view: View, points: FloatArray, next_m: tuple[float, float]) -> Twist2D:
        """Askew in a bend no direction is open: turn to where the body fits, after making room for it to turn."""
        heading = self._steering.heading_that_fits(points, next_m)
        if heading is None:
            return over_dead_band(self._room.for_turning(points), self._config.robot)
        wz = self._yaw.rate_radps(heading, view.twist_in_base.wz_radps)
        return over_dead_band(Twist2D(0.0, 0.0, wz), self._config.robot)

    def _turns_in_vain(self, view: View, direction_rad: float) -> bool:
        """Whether it has tried to turn for a while, and something keeps it from it."""
        yaw_rad = view.pose_in_odom.yaw_rad
        if (
            abs(direction_rad) < _TURNS_RAD
            or abs(wrap_angle(yaw_rad - self._turned_to_rad)) > _HAS_TURNED_RAD
        ):
            self._turned_to_rad, self._turned_at_s = yaw_rad, view.now_s
        return view.now_s - self._turned_at_s > _IN_VAIN_S

    def _look(self, view: View, face_rad: float | None) -> Twist2D:
        if face_rad is None:
            return STOP
        wz = self._yaw.rate_radps(face_rad, view.twist_in_base.wz_radps)
        return over_dead_band(Twist2D(0.0, 0.0, wz), self._config.robot)
