"""How to hold the body while going somewhere: facing what it looks at and strafing, or turned along the way.

A base that strafes keeps its heading free for the camera. Where the body held so is too wide for the gap, its front is
turned along the way; with some hysteresis, so that it does not swing to and fro. A differential base is always turned.
"""

from __future__ import annotations

import math

import numpy as np

from target_nav.config import Config
from target_nav.nav.footprint import Footprint
from target_nav.nav.skill import View
from target_nav.nav.vfh import Steering, Vfh
from target_nav.state.types import Avoidance, FloatArray, Twist2D

_TURNED_SIGHT_M = 0.5
_STRAFE_SIGHT_M = 0.8
"""More free way is asked for to go back to strafing than to leave it."""
_MOVES_MPS = 0.03
_TURN_SAMPLES = 8
_HEADINGS_RAD = tuple(math.radians(sign * degrees) for degrees in range(5, 95, 5) for sign in (1.0, -1.0))
"""Nearest first. Beyond a right angle a rectangle that strafes gains nothing."""


class BodySteering:
    def __init__(self, config: Config) -> None:
        self._body = Footprint.of(config.robot)
        self._margin_m = config.avoid.margin_m
        self._stop_m = config.avoid.stop_clearance_m
        self._turning_m = self._body.circumscribed_radius_m + self._stop_m
        self._holonomic = config.robot.drive != "differential"
        self._strafing = Vfh(config, turned=False)
        self._turned = Vfh(config, turned=True)
        self.reset()

    def reset(self) -> None:
        self._strafing.reset()
        self._turned.reset()
        self.along_the_way = not self._holonomic
        """The front has to point in the direction of motion."""

    avoidance: Avoidance | None = None
    """What was chosen last, and out of what."""

    def steer(
        self, view: View, points_m: FloatArray, goal_m: tuple[float, float], face_rad: float | None
    ) -> Steering | None:
        """Direction towards `goal_m` past `points_m`, both in base_link; None if there is none.

        `face_rad` is the bearing it would like to look at, None for where it goes.
        """
        away_m, goal_rad = math.hypot(*goal_m), math.atan2(goal_m[1], goal_m[0])
        if self._holonomic:
            self._choose(points_m, goal_rad, away_m, goal_rad if face_rad is None else face_rad)
        twist = view.twist_in_base
        moves = twist.speed_mps > _MOVES_MPS
        vfh = self._turned if self.along_the_way else self._strafing
        chosen = vfh.steer(
            points_m,
            yaw_rad=view.pose_in_odom.yaw_rad,
            goal_rad=goal_rad,
            goal_m=away_m,
            motion_rad=math.atan2(twist.vy_mps, twist.vx_mps) if moves else None,
        )
        free = vfh.free_sectors_m
        if chosen is not None and free is not None:
            self.avoidance = Avoidance(
                chosen.direction_rad, chosen.free_m, self.along_the_way, vfh.directions_rad, free
            )
        return chosen

    def heading_that_fits(self, points_m: FloatArray, goal_m: tuple[float, float]) -> float | None:
        """The nearest heading, in base_link, that it can turn to here and go straight towards `goal_m` from.

        None: there is none. A body that stands askew between walls fits nowhere but where it stands.
        """
        away_m, goal_rad = math.hypot(*goal_m), math.atan2(goal_m[1], goal_m[0])
        wanted_m = min(away_m, _TURNED_SIGHT_M)
        vfh = self._strafing if self._holonomic else self._turned
        for heading in _HEADINGS_RAD if self._holonomic else (goal_rad,):
            c, s = math.cos(heading), math.sin(heading)
            turned = points_m @ np.array([[c, -s], [s, c]])
            if vfh.free_m(turned, goal_rad - heading, self._stop_m) >= wanted_m and self._can_turn_to(
                points_m, heading
            ):
                return heading
        return None

    def _choose(self, points_m: FloatArray, goal_rad: float, goal_m: float, face_rad: float) -> None:
        if not self.along_the_way:
            wanted_m = min(goal_m, _TURNED_SIGHT_M)
            if self._strafing.free_m(points_m, goal_rad) < wanted_m <= self._turned.free_m(
                points_m, goal_rad
            ) and self._can_turn_to(points_m, goal_rad):
                self.along_the_way = True
                self._turned.reset()
            return
        c, s = math.cos(face_rad), math.sin(face_rad)
        faced = points_m @ np.array([[c, -s], [s, c]])
        stands_free = len(faced) == 0 or float(self._body.clearances_m(faced).min()) > self._margin_m
        if stands_free and self._strafing.free_m(faced, goal_rad - face_rad) >= min(goal_m, _STRAFE_SIGHT_M):
            self.along_the_way = False
            self._strafing.reset()

    def _can_turn_to(self, points_m: FloatArray, direction_rad: float) -> bool:
        """Whether no corner comes nearer to anything than the stop clearance on the way round, or than it is."""
        near = points_m[np.hypot(points_m[:, 0], points_m[:, 1]) < self._turning_m]
        if not len(near):
            return True
        angles = np.linspace(0.0, abs(direction_rad), _TURN_SAMPLES)
        turning = Twist2D(0.0, 0.0, math.copysign(1.0, direction_rad))
        room = self._body.clearances_along_m(near, turning, angles)
        return float(room.min()) >= min(self._stop_m, float(room[0].min()))
