"""Drives round obstacles towards the tracked target, until the last metre lies straight ahead and free.

The target's estimate changes with every frame, so the spots to drive to are worked out anew with every plan. Far off,
the estimate is too uncertain to say which point is the target's own and which a box before it; what is near to it
then does not count against a side.
"""

from __future__ import annotations

import math
from functools import partial

import numpy as np

from target_nav.config import Config
from target_nav.nav.drive import Drive, Driver
from target_nav.nav.face_on import (
    AT_SPOT_M,
    SQUARE_RAD,
    SQUARE_THERE_RAD,
    face_spots,
    off_square_rad,
    straight_onto,
)
from target_nav.nav.footprint import Footprint
from target_nav.nav.guarded import GuardedSkill
from target_nav.nav.last_seen import LastSeen
from target_nav.nav.progress import Progress
from target_nav.nav.recovery import Recovery
from target_nav.nav.skill import SkillStatus, SkillStep, View
from target_nav.nav.staging import approach_spots, straight_way_clear, without_own
from target_nav.state.types import STOP, Avoidance, FloatArray, Track
from target_nav.utils.frames import to_child

_FACING_RAD = 0.15
_STANDING_S, _NO_NEARER_S = 4.0, 15.0
_RECOVERIES = 3
_OWN_RADIUS_M = 0.08
"""The target's own points, where the tracker has left some in."""
_MOST_UNSURE_M = 0.35
_INSIDE_M = 0.12
"""Spots lie inside the range that counts, by the grid's cell and what counts as being there."""
_COMFORT_M, _SPOT_SLACK_M = 0.03, 0.015
_FAR_SIDE_M = 6.0
"""Where no side looks free, the side away from the robot costs so much more."""
_SETTLE_S = 3.0
"""So long it tries for a way in with comfortable room beside the body; then just enough will do."""
_MOVED_M = 0.5
"""What was known of another place's face does not hold here."""
_KEEP_OFF = 0.05 * np.column_stack(
    [np.cos(np.arange(8) * math.pi / 4.0), np.sin(np.arange(8) * math.pi / 4.0)]
)
"""Outline of the target, which is left out of the obstacles but must not be run over."""


class NavigateToTarget(GuardedSkill):
    def __init__(
        self,
        config: Config,
        *,
        cruise_speed_mps: float,
        until_range_m: float,
        lost_after_s: float,
        from_face: bool = False,
    ) -> None:
        """Succeeds within `until_range_m` (base_link to the target's centre), facing it, with a free way ahead; with
        `from_face` squarely before the target's face besides, once the track says where that looks.

        Fails when the target was not seen for `lost_after_s` though it should have been, or when nothing comes of
        the driving.
        """
        self._config = config
        self._body = Footprint.of(config.robot)
        self._speed_mps = cruise_speed_mps
        self._until_m = until_range_m
        self._from_face = from_face
        self._stand_off_m = config.approach.stand_off_m
        self._driver = Driver(config)
        self._last_seen = LastSeen(config, lost_after_s)
        self._recovery = Recovery(config, _RECOVERIES)
        self._progress = Progress(standing_s=_STANDING_S, no_nearer_s=_NO_NEARER_S)
        self._least_margin_m = config.avoid.stop_clearance_m + _SPOT_SLACK_M + 0.005

    @property
    def avoidance(self) -> Avoidance | None:
        """What VFH saw and chose when it last drove."""
        return self._driver.avoidance

    def _begin(self, view: View) -> None:
        self._driver.forget()
        self._progress.begin()
        self._recovery.begin()
        self._last_seen.begin(view.now_s)
        self._is_straight = False
        self._margin_m = max(self._config.avoid.margin_m + _COMFORT_M, self._least_margin_m)
        self._in_range_since_s: float | None = None
        # Points round the target that may be its own. Not seeing it for a while does not make a box beside it its own.
        self._unsure_m = _MOST_UNSURE_M
        self._facing_rad: float | None = None
        self._faced_m = (math.inf, math.inf)
        self._is_on_spot = False

    def _step(self, view: View) -> SkillStep:
        lost = self._last_seen.lost(view)
        if lost:
            return SkillStep(SkillStatus.FAILURE, STOP, lost)
        track = self._last_seen.track
        if track is None:
            self._progress.restart()
            return SkillStep(SkillStatus.RUNNING, STOP, "waiting for a confirmed track")
        target = to_child(view.pose_in_odom, track.x_m, track.y_m)
        range_m, bearing_rad = math.hypot(*target), math.atan2(target[1], target[0])
        self._settle_for_less(view, range_m)
        self._unsure_m = min(self._unsure_m, _OWN_RADIUS_M + 2.0 * track.sigma_m)
        if self._from_face:
            self._take_facing(track)
        off_rad = self._off_square(view, track)
        in_place = range_m <= self._until_m and abs(bearing_rad) < _FACING_RAD
        if in_place and off_rad <= self._square_rad and self._is_clear(view, target):
            return SkillStep(
                SkillStatus.SUCCESS, STOP, f"target {range_m:.2f} m ahead{self._of_face(off_rad)}"
            )
        back = self._recovery.step(view)
        if back is not None:
            self._progress.restart()
            return SkillStep(SkillStatus.RUNNING, back, "backing off")
        drive = self._drive(view, track, target, bearing_rad)
        self._is_on_spot = drive.at_goal
        stalled = self._progress.stalled(view.now_s, view.pose_in_odom, drive.cost_to_go_m)
        if stalled:
            return self._recover(view, drive, stalled, range_m)
        words = f"target {range_m:.2f} m off{self._of_face(off_rad)}"
        words += f", {drive.reason}" if drive.reason else ""
        return SkillStep(SkillStatus.RUNNING, drive.twist, words)

    def _take_facing(self, track: Track) -> None:
        """The newest answer is kept while there is none, unless the target is not where it was."""
        if track.facing_in_odom_rad is not None and math.isfinite(track.facing_in_odom_rad):
            self._facing_rad, self._faced_m = track.facing_in_odom_rad, (track.x_m, track.y_m)
        elif math.dist(self._faced_m, (track.x_m, track.y_m)) > _MOVED_M:
            self._facing_rad = None

    def _off_square(self, view: View, track: Track) -> float:
        """How far from straight before the face; 0 where that does not matter or is not known."""
        if self._facing_rad is None:
            return 0.0
        return abs(off_square_rad(view.pose_in_odom, (track.x_m, track.y_m), self._facing_rad))

    @property
    def _square_rad(self) -> float:
        return SQUARE_THERE_RAD if self._is_on_spot else SQUARE_RAD

    def _of_face(self, off_rad: float) -> str:
        if not self._from_face:
            return ""
        if self._facing_rad is None:
            return ", where its face looks is not known"
        return f", {math.degrees(off_rad):.0f} deg from straight before its face"

    def _is_clear(self, view: View, target_m: tuple[float, float]) -> bool:
        # A little less room than its spot was chosen with, for it never stands on the spot exactly.
        return straight_way_clear(
            target_m,
            without_own(view.obstacles_in_base_m, target_m, _OWN_RADIUS_M),
            self._body,
            stand_off_m=self._stand_off_m,
            margin_m=self._margin_m - _SPOT_SLACK_M,
        )

    def _settle_for_less(self, view: View, range_m: float) -> None:
        if range_m > self._until_m:
            self._in_range_since_s = None
        elif self._in_range_since_s is None:
            self._in_range_since_s = view.now_s
        elif view.now_s - self._in_range_since_s > _SETTLE_S:
            self._margin_m = self._least_margin_m

    def _drive(self, view: View, track: Track, target_m: tuple[float, float], bearing_rad: float) -> Drive:
        return self._driver.drive(
            view,
            lambda known_m: self._spots(known_m, track, view),
            speed_mps=self._speed_mps,
            face_rad=bearing_rad,
            straight_to_m=self._straight(view, track, target_m),
            extra_points_m=np.vstack([_KEEP_OFF + np.array(target_m), self._recovery.shunned(view)]),
            **({} if self._facing_rad is None else {"at_goal_m": AT_SPOT_M}),
        )

    def _straight(
        self, view: View, track: Track, target_m: tuple[float, float]
    ) -> tuple[float, float] | None:
        """The end of the straight way to the target, in base_link, if all that is in view leaves it free."""
        range_m = math.hypot(*target_m)
        left_m = range_m - self._until_m + _INSIDE_M
        was_straight, self._is_straight = self._is_straight, False
        if len(self._recovery.shunned(view)):
            return None
        if self._facing_rad is not None and self._off_square(view, track) > SQUARE_RAD:
            spot_m = (
                track.x_m + (self._until_m - _INSIDE_M) * math.cos(self._facing_rad),
                track.y_m + (self._until_m - _INSIDE_M) * math.sin(self._facing_rad),
            )
            return straight_onto(
                view.pose_in_odom, spot_m, view.obstacles_in_base_m, self._body, self._least_margin_m
            )
        if left_m < _INSIDE_M:
            return None
        self._is_straight = straight_way_clear(
            target_m,
            without_own(view.obstacles_in_base_m, target_m, self._unsure_m),
            self._body,
            stand_off_m=self._stand_off_m,
            margin_m=self._config.avoid.margin_m + (0.01 if was_straight else 0.04),
        )
        share = left_m / range_m
        return (target_m[0] * share, target_m[1] * share) if self._is_straight else None

    def _spots(self, known_in_odom_m: FloatArray, track: Track, view: View) -> FloatArray:
        """Where the last metre can begin, in odom. With as much room beside it as can be had."""
        target_m = (track.x_m, track.y_m)
        points = without_own(known_in_odom_m, target_m, self._unsure_m)
        farthest_m = self._until_m - _INSIDE_M
        for margin_m in dict.fromkeys((self._margin_m, self._least_margin_m)):
            spots = self._free_spots(target_m, points, farthest_m, margin_m)
            if len(spots):
                self._margin_m = margin_m
                return spots
        # No side looks free from here. Going nearer shows more; success still asks for a free way. This side first:
        # the estimate may lie in a wall, and behind that there is no floor at all.
        spots = self._free_spots(target_m, points[:0], farthest_m, 0.0)
        out = spots[:, :2] - np.array(target_m)
        back = np.array([view.pose_in_odom.x_m - track.x_m, view.pose_in_odom.y_m - track.y_m])
        facing = out @ back / np.maximum(np.hypot(*out.T) * math.hypot(*back), 1e-9)
        spots[:, 2] += _FAR_SIDE_M * 0.5 * (1.0 - facing)
        return spots

    def _free_spots(
        self, target_m: tuple[float, float], points_m: FloatArray, farthest_m: float, margin_m: float
    ) -> FloatArray:
        spots_of = (
            approach_spots if self._facing_rad is None else partial(face_spots, facing_rad=self._facing_rad)
        )
        return spots_of(
            target_m,
            points_m,
            self._body,
            stand_off_m=self._stand_off_m,
            farthest_m=farthest_m,
            margin_m=margin_m,
        )

    def _recover(self, view: View, drive: Drive, stalled: str, range_m: float) -> SkillStep:
        if self._recovery.is_used_up:
            place = "the target" if self._facing_rad is None else "the place before the target's face"
            why = f"no way to {place}" if math.isinf(drive.cost_to_go_m) else stalled
            words = (
                f"stuck {range_m:.2f} m from the target: {why}, {self._recovery.used} recoveries did not help"
            )
            return SkillStep(SkillStatus.FAILURE, STOP, words)
        route = self._driver.route
        self._recovery.start(view, None if route is None else route.next_m)
        # What is remembered only goes when it leaves no way: it may be what was never there.
        if math.isinf(drive.cost_to_go_m):
            self._driver.forget()
        else:
            self._driver.reset()
        self._progress.restart()
        words = f"{stalled}: recovery {self._recovery.used} of {self._recovery.attempts}"
        return SkillStep(SkillStatus.RUNNING, STOP, words)
