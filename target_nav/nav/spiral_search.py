"""Drives about within a radius of the place where it began, for a target that is out of sight from there.

Way-points lie on an Archimedean spiral. Of those left, the one is next that promises most new floor for the way to it
(`viewpoints`); one that would show nothing new, is occupied or cannot be reached is passed over at once. While
driving, a base that strafes looks to where most is still unseen; a differential base looks round at the way-points.
"""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np

from target_nav.config import Config
from target_nav.nav.coverage import Coverage
from target_nav.nav.drive import Drive, Driver
from target_nav.nav.glimpse import Glimpse, Sight
from target_nav.nav.guarded import GuardedSkill
from target_nav.nav.progress import Progress
from target_nav.nav.room import Room
from target_nav.nav.skill import SkillStatus, SkillStep, View
from target_nav.nav.speed import YawControl, over_dead_band, within_limits
from target_nav.nav.spiral import spiral, spots_round
from target_nav.nav.viewpoints import Verdict, Viewpoints
from target_nav.state.types import STOP, Avoidance, FloatArray, Pose2D, Twist2D
from target_nav.utils.frames import to_parent, wrap_angle

_LOOK_EVERY_S = 0.25
_ONWARD_S = 0.2
"""So long it goes on as before while the next way-point is chosen; the limiter keeps it off things."""
_LOOK_MAY_WAIT_S = 0.08
"""For a tick that has taken in no scan."""
_SURE_SHARE = 0.9
"""Of the camera's range, in which a target is surely found."""
_LOOKS = ((0.2, math.inf), (0.08, math.inf), (0.4, 2.0))
"""Least new floor worth a way (m^2), and range at which a target counts as found (m): first the large shadows, then
those of small boxes, then all again from nearer, in case the detector missed it."""
_EDGE_RAD = 0.17
"""Left out at the picture's edges when choosing where to look, so that what was looked at is then well inside."""
_GAZE_M2 = 0.1
"""New floor that is worth turning to."""
_FARTHEST_WAY_M = 40.0
"""In cost: tight places count several times."""
_FINENESS = 0.4
"""Way-points lie so much closer than the search may pass things by, for doorways and passages need some in them."""
_NEAR_ENOUGH_M = 0.25
_AS_MUCH = 0.5
_AGAIN = 1
_NO_WAY_S = 0.5
_MOST_IN_VAIN = 10
"""Way-points in a row that could not be driven to: the base is held, or everything is shut."""
_KEEP_GAZE = 1.5
_LOOK_ROUND_SLACK = 1.3


class SpiralSearch(GuardedSkill):
    def __init__(
        self, config: Config, *, time_limit_s: float, radius_m: float, spacing_m: float, speed_mps: float
    ) -> None:
        """Succeeds with a confirmed track seen just now; fails when all in reach was seen, or the time is over.

        Started again after it has found something, it goes on with what is left of floor and time: what it found was
        something else, or was lost again. After all was seen it looks at everything anew.
        """
        self._config = config
        self._time_limit_s = time_limit_s
        self._radius_m, self._spacing_m, self._speed_mps = radius_m, spacing_m, speed_mps
        self._driver = Driver(config)
        self._room = Room(config)
        self._glimpse = Glimpse(config.robot)
        self._progress = Progress(standing_s=2.5, no_nearer_s=8.0)
        self._yaw_rate_radps = max(config.search.yaw_rate_radps, config.robot.min_yaw_rate_radps)
        self._yaw = YawControl(config.robot, top_radps=self._yaw_rate_radps, rest_rad=0.03)
        self._range_m = min(_SURE_SHARE * config.camera.max_range_m, config.track.max_range_m)
        self._coverage = Coverage(config.camera, self._range_m)
        self._viewpoints = Viewpoints(self._coverage, self._driver, speed_mps, _FARTHEST_WAY_M)
        self._all_was_seen = True
        self._spent_s = self._way_m = 0.0
        self._passed_over = self._visited = 0
        half_picture = config.camera.half_fov_rad - _EDGE_RAD
        around = np.abs(np.remainder(self._coverage.ray_angles_rad + math.pi, 2.0 * math.pi) - math.pi)
        self._window = np.fft.rfft(np.fft.ifftshift((around <= half_picture).astype(np.float64)))

    @property
    def unseen_m2(self) -> float:
        """How much of the grid round the start has not been looked at yet, whether it is floor or not."""
        return self._coverage.unseen_m2

    @property
    def avoidance(self) -> Avoidance | None:
        """What VFH saw and chose when it last drove."""
        return self._driver.avoidance

    def _begin(self, view: View) -> None:
        self._glimpse.reset()
        self._progress.begin()
        self._driver.reset()
        self._started_s = view.now_s - self._spent_s
        self._last_pose: Pose2D = view.pose_in_odom
        self._looked_s = -math.inf
        self._gaze_in_odom_rad: float | None = None
        self._look_round_until_s: float | None = None
        self._no_way_since_s: float | None = None
        self._in_vain = 0
        self._onward, self._drove_s = STOP, -math.inf
        if self._all_was_seen:
            self._centre, self._again_left = view.pose_in_odom, _AGAIN
            self._begin_anew(view)
        self._viewpoints.drop()

    def _begin_anew(self, view: View) -> None:
        self._all_was_seen = False
        # an empty map knows no floor and no way-point: look before choosing
        self._looked_s = -math.inf
        self._driver.forget()
        self._coverage.begin(view.pose_in_odom)
        self._coverage.look_again(self._range_m)
        self._look = 0
        # The first way-point lies where there is most room.
        ahead_rad, _ = self._room.widest(view.obstacles_in_base_m, 0.0)
        begin = replace(self._centre, yaw_rad=view.pose_in_odom.yaw_rad + ahead_rad)
        spacing_m = _FINENESS * self._spacing_m
        spots = [to_parent(begin, x, y) for x, y in spiral(self._radius_m, spacing_m)]
        self._viewpoints.begin(np.array(spots))
        self._viewpoints.look(_LOOKS[0][0])

    def _step(self, view: View) -> SkillStep:
        pose = view.pose_in_odom
        self._way_m += math.hypot(pose.x_m - self._last_pose.x_m, pose.y_m - self._last_pose.y_m)
        self._last_pose = pose
        passed_s = self._spent_s = view.now_s - self._started_s
        sight = self._glimpse.look(view)
        if sight is Sight.FOUND and view.track is not None:
            words = f"found after {passed_s:.1f} s, {self._way_m:.1f} m; {view.track.range_m:.2f} m off"
            return SkillStep(SkillStatus.SUCCESS, STOP, words)
        if passed_s > self._time_limit_s:
            return self._failed(passed_s, f"limit {self._time_limit_s:.1f} s")
        if self._in_vain >= _MOST_IN_VAIN:
            return self._failed(passed_s, f"{self._in_vain} way-points in a row could not be driven to")
        if sight is Sight.LOOKING:
            self._progress.restart()
            return SkillStep(SkillStatus.RUNNING, self._glimpse.twist(view), "something is there, looking")
        waited_s = view.now_s - self._looked_s - _LOOK_EVERY_S
        if waited_s >= 0.0 and (waited_s > _LOOK_MAY_WAIT_S or not view.is_busy):
            self._looked_s = view.now_s
            view = replace(view, is_busy=True)
            self._coverage.update(pose, self._driver.known_points(view), self._driver.reach_m)
            self._choose_gaze(pose)
            self._drop_if_seen()
        if self._look_round_until_s is not None:
            if self._gaze_in_odom_rad is not None and view.now_s < self._look_round_until_s:
                return self._look_round(view)
            self._look_round_until_s = None
            if self._gaze_in_odom_rad is None:
                self._coverage.settle(pose)
            self._viewpoints.finish()
        if self._viewpoints.chosen is None:
            # A choice and a plan are too much for one tick; meanwhile it goes on as before, for a moment.
            if not self._choose_waypoint(view):
                return self._failed(passed_s, "all in reach was seen")
            onward = self._onward if view.now_s - self._drove_s <= _ONWARD_S else STOP
            return SkillStep(SkillStatus.RUNNING, onward, "choosing a way-point")
        return self._drive_on(view, self._viewpoints.place_m)

    def _drive_on(self, view: View, waypoint: tuple[float, float]) -> SkillStep:
        pose = view.pose_in_odom
        away_m = math.dist(waypoint, (pose.x_m, pose.y_m))
        gaze = self._gaze_in_odom_rad
        drive = self._driver.drive(
            view,
            lambda _: self._spots,
            speed_mps=self._speed_mps,
            face_rad=None if gaze is None else wrap_angle(gaze - pose.yaw_rad),
            face_top_radps=self._yaw_rate_radps,
            limit_m=_FARTHEST_WAY_M,
        )
        self._onward, self._drove_s = drive.twist, view.now_s
        if self._gives_up(view, drive):
            self._onward = STOP
            self._passed_over += 1
            self._in_vain += 1
            self._viewpoints.finish(given_up=True)
        elif drive.at_goal or (away_m < _NEAR_ENOUGH_M and self._sees_as_much(pose, waypoint)):
            self._visited += 1
            self._in_vain = 0
            self._onward = STOP
            self._look_round_until_s = view.now_s + _LOOK_ROUND_SLACK * 2.0 * math.pi / self._yaw_rate_radps
        words = f"{self._visited} way-points visited, {self._passed_over} passed over, {self._viewpoints.left} left"
        return SkillStep(SkillStatus.RUNNING, drive.twist, words)

    def _sees_as_much(self, pose: Pose2D, waypoint: tuple[float, float]) -> bool:
        """Whether what the way-point would show is shown from here already; just before a corner it is not."""
        here, there = self._coverage.unseen_by_ray_m2(np.array([(pose.x_m, pose.y_m), waypoint])).sum(axis=1)
        return bool(here >= _AS_MUCH * there)

    def _spots_for(self, waypoint: tuple[float, float]) -> FloatArray:
        """The spots round a way-point that show about as much as it does: where it is itself may be too tight."""
        spots = spots_round(waypoint)
        shown_m2 = self._coverage.unseen_by_ray_m2(spots[:, :2]).sum(axis=1)
        # the way-point itself is the first
        as_good: FloatArray = spots[shown_m2 >= _AS_MUCH * shown_m2[0]]
        return as_good

    def _gives_up(self, view: View, drive: Drive) -> bool:
        stalled = self._progress.stalled(view.now_s, view.pose_in_odom, drive.cost_to_go_m)
        if not math.isinf(drive.cost_to_go_m):
            self._no_way_since_s = None
            return bool(stalled)
        self._no_way_since_s = view.now_s if self._no_way_since_s is None else self._no_way_since_s
        return bool(stalled) or view.now_s - self._no_way_since_s > _NO_WAY_S

    def _look_round(self, view: View) -> SkillStep:
        assert self._gaze_in_odom_rad is not None
        self._progress.restart()
        away = self._room.for_turning(view.obstacles_in_base_m)
        error = wrap_angle(self._gaze_in_odom_rad - view.pose_in_odom.yaw_rad)
        wz = self._yaw.rate_radps(error, view.twist_in_base.wz_radps)
        twist = over_dead_band(Twist2D(away.vx_mps, away.vy_mps, wz), self._config.robot)
        return SkillStep(SkillStatus.RUNNING, within_limits(twist, self._config.robot), "looking round")

    def _choose_waypoint(self, view: View) -> bool:
        """Take the way-point that shows most for its way; False if none shows anything, however closely one looks.

        True without a way-point means that there are more to compare.
        """
        verdict = self._viewpoints.choose(view)
        if verdict is Verdict.CHOSEN:
            self._no_way_since_s = None
            self._spots = self._spots_for(self._viewpoints.place_m)
            self._driver.reset()
            self._progress.begin()
        elif verdict is Verdict.NONE:
            if self._look + 1 >= len(_LOOKS):
                return self._once_more(view)
            self._look += 1
            least_m2, range_m = _LOOKS[self._look]
            if range_m < self._range_m:
                self._coverage.look_again(range_m)
            self._viewpoints.look(least_m2)
        return True

    def _once_more(self, view: View) -> bool:
        """All was seen. With time left, begin with an empty map: odometry's drift smears walls, and shuts passages."""
        if self._again_left == 0:
            self._all_was_seen = True
            return False
        self._again_left -= 1
        self._begin_anew(view)
        return True

    def _drop_if_seen(self) -> None:
        """On the way much is seen already; what the way-point would still show may not be worth it any more."""
        if self._viewpoints.chosen is None or self._look_round_until_s is not None:
            return
        place = np.array([self._viewpoints.place_m])
        if float(self._coverage.unseen_by_ray_m2(place).sum()) < _LOOKS[self._look][0]:
            self._passed_over += 1
            self._viewpoints.finish()

    def _choose_gaze(self, pose: Pose2D) -> None:
        """Where to look: most new floor in the picture for the turn to it; nowhere if nothing new is in sight."""
        by_ray = self._coverage.unseen_by_ray_m2(np.array([[pose.x_m, pose.y_m]]), crumbs=True)[0]
        in_picture = np.fft.irfft(np.fft.rfft(by_ray) * self._window, len(by_ray))
        angles = self._coverage.ray_angles_rad
        turn = np.abs(np.remainder(angles - pose.yaw_rad + math.pi, 2.0 * math.pi) - math.pi)
        value = in_picture / (turn / self._yaw_rate_radps + 1.0)
        if self._gaze_in_odom_rad is not None:
            kept = np.abs(np.remainder(angles - self._gaze_in_odom_rad + math.pi, 2.0 * math.pi) - math.pi)
            value = np.where(kept < 0.1, _KEEP_GAZE * value, value)
        best = int(np.argmax(value))
        self._gaze_in_odom_rad = float(angles[best]) if in_picture[best] >= _GAZE_M2 else None

    def _failed(self, passed_s: float, why: str) -> SkillStep:
        words = (
            f"not found after {passed_s:.1f} s, {self._way_m:.1f} m ({why};"
            f" {self._visited} way-points visited, {self._passed_over} passed over)"
        )
        return SkillStep(SkillStatus.FAILURE, STOP, words)
