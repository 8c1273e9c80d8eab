"""Drives an outward spiral round the place where it began and looks about, for a target that is out of sight there.

Way-points lie on an Archimedean spiral. One that is occupied, behind a wall or not got nearer to is passed over. A base
that strafes turns all the while, so the camera, 60 degrees wide, sees all round; a differential base turns round
now and then.
"""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np

from target_nav.config import Config
from target_nav.nav.drive import Driver
from target_nav.nav.footprint import as_points
from target_nav.nav.glimpse import Glimpse, Sight
from target_nav.nav.progress import Progress
from target_nav.nav.room import Room
from target_nav.nav.skill import SkillStatus, SkillStep, View
from target_nav.nav.speed import over_dead_band, within_limits
from target_nav.state.types import STOP, FloatArray, Pose2D, Twist2D
from target_nav.utils.frames import to_child, to_parent, wrap_angle

_STEP_SHARE = 0.75
"""Way-points are so far apart, as a share of the spiral's spacing."""
_FIRST_SHARE = 0.75
"""The first way-point is so many spacings off: nearer, it sees little that turning on the spot did not."""
_NEAR_ENOUGH_M = 0.25
_WAY_FACTOR, _WAY_EXTRA_M = 2.5, 1.5
"""A way-point may cost so much more than its distance; beyond that it is behind something."""
_NO_WAY_S = 0.5
_SWEEP_EVERY_M = 1.2
"""A differential base turns round once for so much way."""
_SWEEP_SLACK = 1.6
"""A turn that takes so many times longer than it should is blocked."""
_RINGS_M = ((0.0, 1, 0.0), (0.12, 8, 0.2), (0.24, 12, 0.5))
"""Spots that stand for a way-point: radius, how many, extra cost."""


class SpiralSearch:
    def __init__(
        self, config: Config, *, time_limit_s: float, radius_m: float, spacing_m: float, speed_mps: float
    ) -> None:
        """Succeeds with a confirmed track seen just now; fails when the spiral is driven or the time is over."""
        self._config = config
        self._time_limit_s = time_limit_s
        self._radius_m, self._spacing_m, self._speed_mps = radius_m, spacing_m, speed_mps
        self._holonomic = config.robot.drive != "differential"
        self._driver = Driver(config)
        self._room = Room(config)
        self._glimpse = Glimpse(config.robot)
        self._progress = Progress(standing_s=2.5, no_nearer_s=8.0)
        self._yaw_rate_radps = max(config.search.yaw_rate_radps, config.robot.min_yaw_rate_radps)

    def start(self, view: View) -> None:
        self._driver.forget()
        self._glimpse.reset()
        self._progress.restart()
        self._started_s = view.now_s
        self._last_pose = view.pose_in_odom
        self._way_m = self._since_sweep_m = 0.0
        self._swept_rad = 2.0 * math.pi
        self._sweep_until_s = -math.inf
        self._no_way_since_s: float | None = None
        self._skipped = 0
        self._next = 0
        # The first way-point lies where there is most room.
        ahead_rad, _ = self._room.widest(as_points(view.obstacles_in_base_m), 0.0)
        begin = replace(view.pose_in_odom, yaw_rad=view.pose_in_odom.yaw_rad + ahead_rad)
        self.waypoints_m = [to_parent(begin, x, y) for x, y in spiral(self._radius_m, self._spacing_m)]

    def step(self, view: View) -> SkillStep:
        self._measure_way(view)
        passed_s = view.now_s - self._started_s
        sight = self._glimpse.look(view)
        if sight is Sight.FOUND and view.track is not None:
            words = f"found after {passed_s:.1f} s, {self._way_m:.1f} m; {view.track.range_m:.2f} m off"
            return SkillStep(SkillStatus.SUCCESS, STOP, words)
        if passed_s > self._time_limit_s:
            return self._failed(passed_s)
        if sight is Sight.LOOKING:
            self._progress.restart()
            return SkillStep(SkillStatus.RUNNING, self._glimpse.twist(view), "something is there, looking")
        if self._swept_rad < 2.0 * math.pi and view.now_s < self._sweep_until_s:
            return self._sweep(view)
        self._pass_reached(view)
        if self._next >= len(self.waypoints_m):
            return self._failed(passed_s)
        return self._drive_on(view)

    def _drive_on(self, view: View) -> SkillStep:
        waypoint = self.waypoints_m[self._next]
        away_m = math.dist(waypoint, (view.pose_in_odom.x_m, view.pose_in_odom.y_m))
        drive = self._driver.drive(
            view,
            lambda: _spots(waypoint),
            speed_mps=self._speed_mps,
            spin_radps=self._yaw_rate_radps if self._holonomic else 0.0,
            limit_m=_WAY_FACTOR * away_m + _WAY_EXTRA_M,
        )
        stalled = self._progress.stalled(view.now_s, view.pose_in_odom, drive.cost_to_go_m)
        if math.isinf(drive.cost_to_go_m):
            self._no_way_since_s = view.now_s if self._no_way_since_s is None else self._no_way_since_s
            stalled = stalled or ("no way" if view.now_s - self._no_way_since_s > _NO_WAY_S else "")
        else:
            self._no_way_since_s = None
        if stalled or drive.at_goal:
            self._skipped += not drive.at_goal
            self._go_on_to_next(view.now_s)
        words = f"way-point {self._next + 1} of {len(self.waypoints_m)}, {self._skipped} passed over"
        return SkillStep(SkillStatus.RUNNING, drive.twist, words)

    def _pass_reached(self, view: View) -> None:
        while self._next < len(self.waypoints_m):
            x, y = to_child(view.pose_in_odom, *self.waypoints_m[self._next])
            if math.hypot(x, y) > _NEAR_ENOUGH_M:
                return
            self._go_on_to_next(view.now_s)

    def _go_on_to_next(self, now_s: float) -> None:
        self._next += 1
        self._no_way_since_s = None
        self._driver.reset()
        self._progress.restart()
        if not self._holonomic and self._since_sweep_m >= _SWEEP_EVERY_M:
            self._since_sweep_m = self._swept_rad = 0.0
            self._sweep_until_s = now_s + 2.0 * _SWEEP_SLACK * math.pi / self._yaw_rate_radps

    def _sweep(self, view: View) -> SkillStep:
        away = self._room.for_turning(as_points(view.obstacles_in_base_m))
        twist = over_dead_band(Twist2D(away.vx_mps, away.vy_mps, self._yaw_rate_radps), self._config.robot)
        self._progress.restart()
        return SkillStep(SkillStatus.RUNNING, within_limits(twist, self._config.robot), "looking round")

    def _measure_way(self, view: View) -> None:
        pose, last = view.pose_in_odom, self._last_pose
        step_m = math.hypot(pose.x_m - last.x_m, pose.y_m - last.y_m)
        self._way_m += step_m
        self._since_sweep_m += step_m
        self._swept_rad += max(wrap_angle(pose.yaw_rad - last.yaw_rad), 0.0)
        self._last_pose: Pose2D = pose

    def _failed(self, passed_s: float) -> SkillStep:
        done = min(self._next, len(self.waypoints_m))
        words = (
            f"not found after {passed_s:.1f} s, {self._way_m:.1f} m"
            f" ({done} of {len(self.waypoints_m)} way-points, {self._skipped} of them passed over)"
        )
        return SkillStep(SkillStatus.FAILURE, STOP, words)


def spiral(radius_m: float, spacing_m: float) -> list[tuple[float, float]]:
    """Way-points of r = spacing * angle / 2 pi, out to `radius_m`; the first straight ahead."""
    points: list[tuple[float, float]] = []
    per_rad = spacing_m / (2.0 * math.pi)
    start = angle = 2.0 * math.pi * _FIRST_SHARE
    while (r := per_rad * angle) <= radius_m + 1e-9:
        points.append((r * math.cos(angle - start), r * math.sin(angle - start)))
        angle += _STEP_SHARE * spacing_m / math.hypot(r, per_rad)
    return points or [(radius_m, 0.0)]


def _spots(waypoint_m: tuple[float, float]) -> FloatArray:
    rows = [
        (waypoint_m[0] + r * math.cos(2.0 * math.pi * i / n), waypoint_m[1] + r * math.sin(2.0 * math.pi * i / n), extra)
        for r, n, extra in _RINGS_M
        for i in range(n)
    ]
    return np.array(rows)
