"""Drives round obstacles towards the tracked target, until the last metre lies straight ahead and free.

The target's estimate changes with every frame, so the spots to drive to are worked out anew with every plan. Far off,
the estimate is too uncertain to say which point is the target's own and which a box before it; what is near to it
then does not count against a side.
"""

from __future__ import annotations

import math

import numpy as np

from target_nav.config import Config
from target_nav.nav.drive import Drive, Driver
from target_nav.nav.footprint import Footprint
from target_nav.nav.guarded import GuardedSkill
from target_nav.nav.progress import Progress
from target_nav.nav.room import Room
from target_nav.nav.skill import SkillStatus, SkillStep, View
from target_nav.nav.speed import over_dead_band, within_limits
from target_nav.nav.staging import approach_spots, straight_way_clear, without_own
from target_nav.state.types import STOP, FloatArray, Track, Twist2D
from target_nav.utils.frames import points_to_parent, to_child, to_parent

_FACING_RAD = 0.15
_STANDING_S, _NO_NEARER_S = 4.0, 25.0
_RECOVERIES = 3
_BACK_OFF_S, _BACK_OFF_M, _BACK_OFF_MPS = 3.0, 0.25, 0.08
_SHUN_S, _SHUN_RADIUS_M = 12.0, 0.15
"""After backing off, the place where it stuck is kept off for so long: that is what chooses the other side."""
_OWN_RADIUS_M = 0.08
"""The target's own points, where the tracker has left some in."""
_BEFORE_TARGET_M = 0.15
_SEEN_JUST_NOW_S = 0.3
_HIDDEN_S = 12.0
"""So long a target behind something may stay unseen on top of the limit; at 0.15 m/s that is once round a big box."""
_SPOT_SLACK_M = 0.015
_SETTLE_S = 1.0
_MOST_UNSURE_M = 0.35
_INSIDE_M = 0.12
"""Spots lie inside the range that counts, by the grid's cell and what counts as being there."""
_KEEP_OFF = 0.05 * np.column_stack(
    [np.cos(np.arange(8) * math.pi / 4.0), np.sin(np.arange(8) * math.pi / 4.0)]
)


class NavigateToTarget(GuardedSkill):
    def __init__(
        self, config: Config, *, cruise_speed_mps: float, until_range_m: float, lost_after_s: float
    ) -> None:
        """Succeeds within `until_range_m` (base_link to the target's centre), facing it, with a free way ahead.

        Fails when the target was not seen for `lost_after_s`, or when nothing comes of the driving.
        """
        self._config = config
        self._body = Footprint.of(config.robot)
        self._speed_mps = cruise_speed_mps
        self._until_m = until_range_m
        self._lost_after_s = lost_after_s
        self._driver = Driver(config)
        self._room = Room(config)
        self._progress = Progress(standing_s=_STANDING_S, no_nearer_s=_NO_NEARER_S)

    def _begin(self, view: View) -> None:
        self._driver.forget()
        self._progress.restart()
        self._started_s = view.now_s
        self._known: Track | None = None
        self._hidden_s = 0.0
        self._at_goal_since_s = view.now_s
        self._margin_m = self._config.avoid.margin_m + 0.03
        self._least_margin_m = self._config.avoid.stop_clearance_m + _SPOT_SLACK_M + 0.005
        self._recoveries = 0
        self._backing_until_s = -math.inf
        self._back_from = (0.0, 0.0)
        self._back_in_odom_rad = 0.0
        self._shunned: tuple[float, float] | None = None
        self._shun_until_s = -math.inf
        self._is_straight = False

    def _step(self, view: View) -> SkillStep:
        lost = self._lost(view)
        if lost:
            return SkillStep(SkillStatus.FAILURE, STOP, lost)
        track = self._known
        if track is None:
            self._progress.restart()
            return SkillStep(SkillStatus.RUNNING, STOP, "waiting for a confirmed track")
        target = to_child(view.pose_in_odom, track.x_m, track.y_m)
        range_m, bearing_rad = math.hypot(*target), math.atan2(target[1], target[0])
        points = view.obstacles_in_base_m
        if range_m <= self._until_m and abs(bearing_rad) < _FACING_RAD and self._clear(target, points):
            return SkillStep(SkillStatus.SUCCESS, STOP, f"target {range_m:.2f} m ahead")
        if view.now_s < self._backing_until_s:
            back = self._back_off(view)
            if back is not None:
                return back
        drive = self._drive(view, track, target, bearing_rad)
        self._settle_for_less(view, drive)
        stalled = self._progress.stalled(view.now_s, view.pose_in_odom, drive.cost_to_go_m)
        if stalled:
            return self._recover(view, drive, stalled, range_m)
        words = f"target {range_m:.2f} m off" + (f", {drive.reason}" if drive.reason else "")
        return SkillStep(SkillStatus.RUNNING, drive.twist, words)

    def _lost(self, view: View) -> str:
        """Why the target counts as lost, or nothing.

        A target that nobody can see just now, for it is behind something or out of the picture, is not missed for a while:
        that is what driving round a box looks like.
        """
        track = view.track
        if track is not None and track.confirmed:
            if self._known is None or track.last_seen_s > self._known.last_seen_s:
                self._hidden_s = 0.0
            self._known = track
        since_s = view.now_s - (self._started_s if self._known is None else self._known.last_seen_s)
        if self._known is not None and since_s > _SEEN_JUST_NOW_S and self._hidden_s < _HIDDEN_S:
            target = to_child(view.pose_in_odom, self._known.x_m, self._known.y_m)
            if self._is_hidden(target, view.obstacles_in_base_m):
                self._hidden_s += min(max(view.dt_s, 0.0), 0.2)
        if since_s - self._hidden_s <= self._lost_after_s:
            return ""
        what = "target lost: no track" if track is None else "target lost"
        hidden = f", hidden for {self._hidden_s:.1f} s of it" if self._hidden_s else ""
        return f"{what}, not seen for {min(since_s, 999.0):.1f} s{hidden} (limit {self._lost_after_s:.1f} s)"

    def _is_hidden(self, target: tuple[float, float], points: FloatArray) -> bool:
        range_m = math.hypot(*target)
        if abs(math.atan2(target[1], target[0])) > self._config.camera.half_fov_rad:
            return True
        if len(points) == 0 or range_m < 2.0 * _BEFORE_TARGET_M:
            return False
        c, s = target[0] / range_m, target[1] / range_m
        along = c * points[:, 0] + s * points[:, 1]
        across = np.abs(c * points[:, 1] - s * points[:, 0])
        return bool(((along > 0.0) & (along < range_m - _BEFORE_TARGET_M) & (across < _OWN_RADIUS_M)).any())

    def _clear(self, target: tuple[float, float], points: FloatArray) -> bool:
        others = without_own(points, target, _OWN_RADIUS_M)
        return straight_way_clear(
            target,
            others,
            self._body,
            stand_off_m=self._config.approach.stand_off_m,
            # A little less than its spot was chosen with, for it never stands on the spot exactly.
            margin_m=self._margin_m - _SPOT_SLACK_M,
        )

    def _settle_for_less(self, view: View, drive: Drive) -> None:
        """Where it should be and the way in still not free enough: a narrower one will do."""
        if not drive.at_goal:
            self._at_goal_since_s = view.now_s
        elif view.now_s - self._at_goal_since_s > _SETTLE_S:
            self._margin_m = self._least_margin_m

    def _drive(self, view: View, track: Track, target: tuple[float, float], bearing_rad: float) -> Drive:
        keep_off = _KEEP_OFF + np.array(target)
        if view.now_s < self._shun_until_s and self._shunned is not None:
            shunned = np.array(to_child(view.pose_in_odom, *self._shunned))
            keep_off = np.vstack([keep_off, shunned, shunned + 2.0 * _KEEP_OFF])
        return self._driver.drive(
            view,
            lambda: self._spots(view, track, target),
            speed_mps=self._speed_mps,
            face_rad=bearing_rad,
            straight_to_m=self._straight(view, track, target),
            extra_points_m=keep_off,
        )

    def _straight(self, view: View, track: Track, target: tuple[float, float]) -> tuple[float, float] | None:
        """The end of the straight way to the target, in base_link, if all that is in view leaves it free."""
        range_m = math.hypot(*target)
        left_m = range_m - self._until_m + _INSIDE_M
        if left_m < _INSIDE_M or view.now_s < self._shun_until_s:
            self._is_straight = False
            return None
        points = without_own(view.obstacles_in_base_m, target, self._unsure_m(track))
        margin_m = self._config.avoid.margin_m + (0.01 if self._is_straight else 0.04)
        self._is_straight = straight_way_clear(
            target, points, self._body, stand_off_m=self._config.approach.stand_off_m, margin_m=margin_m
        )
        return (target[0] * left_m / range_m, target[1] * left_m / range_m) if self._is_straight else None

    def _unsure_m(self, track: Track) -> float:
        return min(_OWN_RADIUS_M + 2.0 * track.sigma_m, _MOST_UNSURE_M)

    def _spots(self, view: View, track: Track, target: tuple[float, float]) -> FloatArray:
        points = without_own(view.obstacles_in_base_m, target, self._unsure_m(track))
        in_odom = points_to_parent(view.pose_in_odom, points)
        for margin_m in dict.fromkeys((self._margin_m, self._least_margin_m)):
            spots = approach_spots(
                (track.x_m, track.y_m),
                in_odom,
                self._body,
                stand_off_m=self._config.approach.stand_off_m,
                farthest_m=self._until_m - _INSIDE_M,
                margin_m=margin_m,
            )
            if len(spots):
                self._margin_m = margin_m
                return spots
        # No side looks free from here. Going nearer shows more; success still asks for a free way.
        return approach_spots(
            (track.x_m, track.y_m),
            in_odom[:0],
            self._body,
            stand_off_m=self._config.approach.stand_off_m,
            farthest_m=self._until_m - _INSIDE_M,
            margin_m=0.0,
        )

    def _recover(self, view: View, drive: Drive, stalled: str, range_m: float) -> SkillStep:
        if self._recoveries >= _RECOVERIES:
            why = "no way to the target" if math.isinf(drive.cost_to_go_m) else stalled
            words = (
                f"stuck {range_m:.2f} m from the target: {why}, {self._recoveries} recoveries did not help"
            )
            return SkillStep(SkillStatus.FAILURE, STOP, words)
        self._recoveries += 1
        route = self._driver.route
        pose = view.pose_in_odom
        ahead = to_child(pose, *route.next_m) if route is not None else (1.0, 0.0)
        ahead_rad = math.atan2(ahead[1], ahead[0])
        direction, _ = self._room.widest(view.obstacles_in_base_m, ahead_rad + math.pi)
        self._back_in_odom_rad = direction + pose.yaw_rad
        self._back_from = (pose.x_m, pose.y_m)
        self._backing_until_s = view.now_s + _BACK_OFF_S
        if route is not None:
            off_m = min(math.hypot(*ahead), self._body.front_m + 0.15)
            self._shunned = to_parent(pose, off_m * math.cos(ahead_rad), off_m * math.sin(ahead_rad))
            self._shun_until_s = view.now_s + _BACK_OFF_S + _SHUN_S
        self._driver.forget()
        self._progress.restart()
        return SkillStep(
            SkillStatus.RUNNING, STOP, f"{stalled}: recovery {self._recoveries} of {_RECOVERIES}"
        )

    def _back_off(self, view: View) -> SkillStep | None:
        """The next step of backing off; None when it is done."""
        pose = view.pose_in_odom
        gone = math.hypot(pose.x_m - self._back_from[0], pose.y_m - self._back_from[1])
        if gone >= _BACK_OFF_M:
            self._backing_until_s = -math.inf
            self._progress.restart()
            return None
        direction = self._back_in_odom_rad - pose.yaw_rad
        twist = Twist2D(_BACK_OFF_MPS * math.cos(direction), _BACK_OFF_MPS * math.sin(direction), 0.0)
        robot = self._config.robot
        return SkillStep(
            SkillStatus.RUNNING, within_limits(over_dead_band(twist, robot), robot), "backing off"
        )
