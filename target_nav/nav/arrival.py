"""Confirms that the robot stands in front of the target: several signals, for some time, never one alone.

- LiDAR: the track was ranged just now, at the stand-off, straight ahead.
- Odometry: dead reckoning to where the target was known when confirming began, and standing still.
- Camera: a box of the target that is ahead and as large as it must be from here, or clipped by the picture's border.

A wall can give the first, a wrong start the second, a poster the third; none of them gives two.
"""

from __future__ import annotations

import math
from collections.abc import Callable

from target_nav.config import Config
from target_nav.nav.guarded import GuardedSkill
from target_nav.nav.skill import SkillStatus, SkillStep, View
from target_nav.state.types import STOP, Detection
from target_nav.utils.frames import to_child

_RANGED_RECENTLY_S = 0.6
_PICTURE_RECENT_S = 0.6
_KEEPS = 1.5
"""Hysteresis: a signal that holds is kept up to so many times its tolerance."""
_STILL_MPS, _STILL_RADPS = 0.02, 0.08
_BOX_SHARE = 0.6
"""A box must have this share of the size that the target has from here; boxes jitter and clip."""
_DRIFT = 1.3
"""Dead reckoning is given so much more tolerance than the LiDAR."""


class ConfirmArrival(GuardedSkill):
    def __init__(
        self,
        config: Config,
        *,
        stand_off_m: float,
        confirm_s: float,
        target_radius_m: float,
        timeout_s: float,
        target_width_m: float | None = None,
    ) -> None:
        """Succeeds when `arrival.min_signals` (two at least) agree for `confirm_s`; fails after `timeout_s`.

        `target_width_m` is what the camera sees of it; default: twice the radius.
        """
        self._config = config
        self._confirm_s, self._timeout_s = confirm_s, timeout_s
        self._width_m = 2.0 * target_radius_m if target_width_m is None else target_width_m
        self._distance_m = config.robot.front_m + stand_off_m + target_radius_m
        self._needed = max(config.arrival.min_signals, 2)
        self._signals: dict[str, Callable[[View, float], bool]] = {
            "lidar": self._lidar,
            "odometry": self._odometry,
            "camera": self._camera,
        }
        # Three signals are all there are.
        self._needed = min(self._needed, len(self._signals))

    def _begin(self, view: View) -> None:
        self._started_s = view.now_s
        self._agreed_since_s: float | None = None
        self._holds = dict.fromkeys(self._signals, False)
        track = view.track
        self._target_m = (track.x_m, track.y_m) if track is not None and track.confirmed else None

    def _step(self, view: View) -> SkillStep:
        for name, signal in self._signals.items():
            self._holds[name] = signal(view, _KEEPS if self._holds[name] else 1.0)
        agree = [name for name, holds in self._holds.items() if holds]
        words = f"{len(agree)} of {len(self._signals)} signals" + (f" ({', '.join(agree)})" if agree else "")
        if len(agree) >= self._needed:
            self._agreed_since_s = view.now_s if self._agreed_since_s is None else self._agreed_since_s
            if view.now_s - self._agreed_since_s >= self._confirm_s:
                return SkillStep(SkillStatus.SUCCESS, STOP, f"arrived: {words}")
        else:
            self._agreed_since_s = None
        if view.now_s - self._started_s > self._timeout_s:
            why = f"{words} after {self._timeout_s:.1f} s, {self._needed} needed; {self._distances(view)}"
            return SkillStep(SkillStatus.FAILURE, STOP, f"not confirmed: {why}")
        return SkillStep(SkillStatus.RUNNING, STOP, words)

    def _lidar(self, view: View, factor: float) -> bool:
        track = view.track
        if track is None or not track.confirmed or not view.now_s - track.last_ranged_s <= _RANGED_RECENTLY_S:
            return False
        return self._in_place(view, (track.x_m, track.y_m), factor)

    def _odometry(self, view: View, factor: float) -> bool:
        moved = view.twist_in_base
        still = moved.speed_mps < factor * _STILL_MPS and abs(moved.wz_radps) < factor * _STILL_RADPS
        return still and self._target_m is not None and self._in_place(view, self._target_m, _DRIFT * factor)

    def _camera(self, view: View, factor: float) -> bool:
        frame = view.detections
        if frame is None or not view.now_s - frame.stamp_s <= _PICTURE_RECENT_S:
            return False
        return any(self._box_fits(detection, factor) for detection in frame.detections)

    def _box_fits(self, box: Detection, factor: float) -> bool:
        camera = self._config.camera
        away_m = max(self._distance_m - camera.x_m, 0.05)
        if not abs(box.bearing_rad + camera.yaw_rad) <= factor * self._config.arrival.bearing_tolerance_rad:
            return False
        width_px = min(camera.focal_px * self._width_m / away_m, float(camera.width_px))
        share = _BOX_SHARE / factor
        fills = box.clipped and box.height_px >= share * camera.height_px
        return fills or share * width_px <= box.width_px <= width_px / share

    def _in_place(self, view: View, target_m: tuple[float, float], factor: float) -> bool:
        arrival = self._config.arrival
        x, y = to_child(view.pose_in_odom, *target_m)
        range_ok = abs(math.hypot(x, y) - self._distance_m) <= factor * arrival.range_tolerance_m
        return range_ok and abs(math.atan2(y, x)) <= factor * arrival.bearing_tolerance_rad

    def _distances(self, view: View) -> str:
        """For the message: where the target is by track and by dead reckoning."""
        places = {"dead reckoning": self._target_m}
        if view.track is not None:
            places["track"] = (view.track.x_m, view.track.y_m)
        told = [
            f"{name} {math.hypot(*to_child(view.pose_in_odom, *place)):.2f} m"
            for name, place in places.items()
            if place is not None
        ]
        return ", ".join([*told, f"expected {self._distance_m:.2f} m"])
