"""What the nav loop would write on the blackboard, said by a script: friendly values that live on from tick to tick.

A track that is seen stays seen, an input that stops grows old, obstacles stay where they are in odom while the robot
drives. Everything else is a value of its key's type. Names are the last part of a key of `target_nav.state.keys`
(`track`, `scan_age_s`), the whole key (`/target/track`), or a key of the mission's own (`/goal`).
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import replace
from typing import Any

from py_trees.blackboard import Blackboard

from target_nav.config import Config
from target_nav.mission.problems import did_you_mean
from target_nav.mission.scenario_constructs import AgeScript, DetectionsScript, ObstacleScript, TrackScript
from target_nav.mission.scenario_values import BadScript, value_of
from target_nav.state import keys
from target_nav.state.keys import Key
from target_nav.state.types import STOP, DetectionFrame, MotionRequest, Pose2D, TargetSpec, Twist2D
from target_nav.utils.frames import compose

FRESH_S = {keys.SCAN_AGE_S.name: 0.1, keys.ODOM_AGE_S.name: 0.02, keys.CAMERA_AGE_S.name: 0.1}

OBSTACLES_IN_ODOM = "obstacles"
_CLOCK = (keys.NOW_S.name, keys.DT_S.name)
_BY_SHORT_NAME = {key.name.rsplit("/", 1)[-1]: key for key in keys.ALL}
_BY_NAME = {key.name: key for key in keys.ALL}


def full_name(name: str) -> str:
    """The blackboard entry that a script or an expectation means.

    Raises:
        BadScript: no such key.
    """
    if name in _BY_SHORT_NAME:
        return _BY_SHORT_NAME[name].name
    if name.startswith("/") and len(name) > 1:
        return name
    raise BadScript(
        f"there is no key {name!r}{did_you_mean(name, names())}; the keys are: {', '.join(names())}; one of the "
        "mission's own begins with /"
    )


def names() -> list[str]:
    return [*_BY_SHORT_NAME, OBSTACLES_IN_ODOM]


def settable(name: str) -> None:
    """
    Raises:
        BadScript: no such key, or one that a script does not write.
    """
    if name == OBSTACLES_IN_ODOM:
        return
    key = _BY_NAME.get(full_name(name))
    if key is None:
        return
    if key.name in _CLOCK:
        raise BadScript(f"{key.name} is the scenario's own clock; say when with `at`")
    if key is keys.CONFIG:
        raise BadScript("the configuration is given by `config`, before the first tick")
    if key.writer != "nav loop":
        raise BadScript(f"{key.name} is written by {key.writer}; a script can only expect it")


class ScriptedWorld:
    """Stands in for the nav loop: `begin_tick` writes what leaves read, `end_tick` reads what they ask for.

    With `drives`, the pose follows the velocity that is asked for, at once and without error.
    """

    def __init__(self, config: Config, drives: bool) -> None:
        self.config, self.drives = config, drives
        self._now_s = 0.0
        self._pose, self._twist = Pose2D(), STOP
        self._ages = {name: AgeScript(age_s) for name, age_s in FRESH_S.items()}
        self._track: TrackScript | None = None
        self._obstacles = ObstacleScript()
        self._detections: DetectionsScript | None = None
        self._requested = False
        for key in keys.ALL:
            if key.optional:
                Blackboard.set(key.name, None)
        Blackboard.set(keys.CONFIG.name, config)
        Blackboard.set(keys.SPEC.name, TargetSpec())

    @property
    def now_s(self) -> float:
        return self._now_s

    @property
    def pose_in_odom(self) -> Pose2D:
        return self._pose

    def request(self) -> MotionRequest | None:
        request: MotionRequest | None = Blackboard.get(keys.REQUEST.name)
        return request

    def set(self, name: str, data: Any) -> None:
        """From now on `name` holds `data`, as a scenario's file would say it (or as an object of the key's own type).

        Raises:
            BadScript: no such key, one that a script does not write, or a value that it cannot hold.
        """
        settable(name)
        if name == OBSTACLES_IN_ODOM:
            self._obstacles = ObstacleScript.in_odom(data)
            return
        path = full_name(name)
        setters: dict[str, Callable[[Any], None]] = {
            keys.TRACK.name: self._set_track,
            keys.DETECTIONS.name: self._set_detections,
            keys.OBSTACLES.name: self._set_obstacles_in_base,
            keys.POSE.name: self._set_pose,
            keys.TWIST.name: self._set_twist,
            keys.REQUESTED.name: self._set_requested,
            **dict.fromkeys(FRESH_S, lambda age: self._set_age(path, age)),
        }
        if path in setters:
            setters[path](data)
        elif path in _BY_NAME:
            Blackboard.set(path, value_of(data, _BY_NAME[path].type, path, _BY_NAME[path].optional))
        else:
            Blackboard.set(path, data)

    def say_go(self, go: bool) -> None:
        if go and not self._requested:
            # as in the nav core: a new mission begins with every target
            Blackboard.set(keys.VISITED.name, None)
            Blackboard.set(keys.SEARCH.name, None)
        self._requested = go

    def begin_tick(self, now_s: float, dt_s: float) -> None:
        self._now_s = now_s
        ages = {name: age.at(now_s) for name, age in self._ages.items()}
        track = self._track.at(now_s, self._pose) if self._track is not None else None
        frame: DetectionFrame | None = None
        if self._detections is not None:
            frame = self._detections.at(now_s - ages[keys.CAMERA_AGE_S.name])
        values: dict[Key, Any] = {
            keys.NOW_S: now_s,
            keys.DT_S: dt_s,
            keys.REQUESTED: self._requested,
            keys.POSE: self._pose,
            keys.TWIST: self._twist,
            keys.TRACK: track,
            keys.DETECTIONS: frame,
            keys.OBSTACLES: self._obstacles.in_base(self._pose),
        }
        for key, value in values.items():
            Blackboard.set(key.name, value)
        for name, age_s in ages.items():
            Blackboard.set(name, age_s)

    def hold(self) -> None:
        """Nobody asks for motion in this tick."""
        Blackboard.set(keys.REQUEST.name, None)

    def end_tick(self, dt_s: float) -> None:
        """Drive for `dt_s` as asked."""
        if not self.drives:
            return
        request = self.request()
        self._twist = request.twist if request is not None and request.twist.is_finite() else STOP
        self._pose = _moved(self._pose, self._twist, dt_s)

    # ------------------------------------------------------------------------------------------------------------------

    def _set_track(self, data: Any) -> None:
        self._track = TrackScript.changed(self._track, data, self._now_s, self._pose)

    def _set_detections(self, data: Any) -> None:
        self._detections = DetectionsScript.of(data, self.config, Blackboard.get(keys.SPEC.name))

    def _set_obstacles_in_base(self, data: Any) -> None:
        self._obstacles = ObstacleScript.fixed_in_base(data)

    def _set_pose(self, data: Any) -> None:
        if isinstance(data, (list, tuple)) and len(data) in (2, 3):
            data = dict(zip(("x_m", "y_m", "yaw_rad"), data))
        if isinstance(data, Mapping):
            # what is not said stays as it was
            data = {**vars(self._pose), **data}
        self._pose = value_of(data, Pose2D, keys.POSE.name)

    def _set_twist(self, data: Any) -> None:
        if self.drives:
            raise BadScript(
                "the robot drives, so its velocity is what is asked for; say `robot: stands` to script it"
            )
        self._twist = value_of(data, Twist2D, keys.TWIST.name)

    def _set_requested(self, data: Any) -> None:
        self._requested = value_of(data, bool, keys.REQUESTED.name)

    def _set_age(self, path: str, data: Any) -> None:
        self._ages[path] = AgeScript.of(data, path, self._ages[path].at(self._now_s), self._now_s)


def _moved(pose: Pose2D, twist: Twist2D, dt_s: float) -> Pose2D:
    turn = twist.wz_radps * dt_s
    # the chord of the arc, as in `nav.odometry`
    half = 0.5 * turn
    c, s = math.cos(half), math.sin(half)
    step = Pose2D(
        (c * twist.vx_mps - s * twist.vy_mps) * dt_s, (s * twist.vx_mps + c * twist.vy_mps) * dt_s, turn
    )
    moved = compose(pose, step)
    return replace(moved, yaw_rad=math.remainder(moved.yaw_rad, math.tau))
