"""Friendly ways to say what the blackboard holds: a track by range and bearing, an input that stops, a box ahead."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from target_nav.config import Config
from target_nav.mission.scenario_values import BadScript, array_of, check_words, number, tuple_of, value_of
from target_nav.state.types import Detection, DetectionFrame, FloatArray, Pose2D, TargetSpec, Track
from target_nav.utils.frames import points_to_child, to_child, to_parent, wrap_angle

SPACING_M = 0.04
"""Of the points that stand for an obstacle's outline: a LiDAR's at 2 m."""
SHAPES = {
    "circle": ("x", "y", "radius"),
    "box": ("x", "y", "length", "width", "yaw"),
    "wall": ("x1", "y1", "x2", "y2"),
}
"""As in an arena, in odom."""


@dataclass(frozen=True)
class AgeScript:
    """An input's age: constant, or growing since `since_s` because the input has stopped."""

    age_s: float
    since_s: float | None = None

    @staticmethod
    def of(data: Any, what: str, present_s: float, now_s: float) -> AgeScript:
        """A number of seconds; `stops`: it grows from now on; `never`: there was none yet."""
        if isinstance(data, str):
            if data == "stops":
                return AgeScript(present_s, now_s)
            if data == "never":
                return AgeScript(math.inf)
            raise BadScript(f"{what} is {data!r}; it must be seconds, `stops` or `never`")
        return AgeScript(value_of(data, float, what))

    def at(self, now_s: float) -> float:
        return self.age_s if self.since_s is None else self.age_s + now_s - self.since_s


TRACK_WORDS = (
    "x_m",
    "y_m",
    "range_m",
    "bearing_rad",
    "seen",
    "ranged",
    "confirmed",
    "hits",
    "sigma_m",
    "facing_rad",
)

FACING_SIGMA_RAD = 0.03


@dataclass(frozen=True)
class TrackScript:
    """A target in odom. While `seen_s` is None the camera sees it in every tick, otherwise it did so last then;
    `ranged_s` is the same for the LiDAR.
    """

    x_m: float
    y_m: float
    seen_s: float | None = None
    ranged_s: float | None = None
    confirmed: bool = True
    hits: int = 10
    sigma_m: float = 0.01
    facing_rad: float | None = None
    """In odom; None: the target has no face, or nobody knows where it looks."""

    @staticmethod
    def changed(before: TrackScript | None, data: Any, now_s: float, pose: Pose2D) -> TrackScript | None:
        """What is not said stays as it was; a position is in odom (`x_m`, `y_m`) or from the robot (`range_m`,
        `bearing_rad`). `seen: false` and `ranged: false` begin now; a new track with `ranged: false` never was.
        An object of type Track is taken as seen now.
        """
        if data is None or (isinstance(data, str) and data == "none"):
            return None
        if isinstance(data, Track):
            data = {"x_m": data.x_m, "y_m": data.y_m, "confirmed": data.confirmed, "hits": data.hits}
        what = "track"
        check_words(data, TRACK_WORDS, what)
        if before is None:
            if not ({"x_m", "y_m"} <= set(data) or "range_m" in data):
                raise BadScript("track is new; it must say where: x_m and y_m, or range_m and bearing_rad")
            ranged = value_of(data.get("ranged", True), bool, "track: ranged")
            before = TrackScript(0.0, 0.0, ranged_s=None if ranged else -math.inf)
        x_m, y_m = before.x_m, before.y_m
        if "range_m" in data or "bearing_rad" in data:
            if "x_m" in data or "y_m" in data:
                raise BadScript("track is placed twice; say x_m and y_m, or range_m and bearing_rad")
            here = to_child(pose, x_m, y_m)
            range_m = number(data, "range_m", what, math.hypot(*here))
            bearing_rad = number(data, "bearing_rad", what, 0.0)
            x_m, y_m = to_parent(pose, range_m * math.cos(bearing_rad), range_m * math.sin(bearing_rad))
        return replace(
            before,
            x_m=number(data, "x_m", what, x_m),
            y_m=number(data, "y_m", what, y_m),
            seen_s=_since(data, "seen", before.seen_s, now_s),
            ranged_s=_since(data, "ranged", before.ranged_s, now_s),
            confirmed=value_of(data.get("confirmed", before.confirmed), bool, "track: confirmed"),
            hits=value_of(data.get("hits", before.hits), int, "track: hits"),
            sigma_m=number(data, "sigma_m", what, before.sigma_m),
            facing_rad=number(data, "facing_rad", what) if "facing_rad" in data else before.facing_rad,
        )

    def at(self, now_s: float, pose: Pose2D) -> Track:
        x, y = to_child(pose, self.x_m, self.y_m)
        return Track(
            stamp_s=now_s,
            x_m=self.x_m,
            y_m=self.y_m,
            covariance_m2=(self.sigma_m**2, 0.0, 0.0, self.sigma_m**2),
            confirmed=self.confirmed,
            hits=self.hits,
            last_seen_s=now_s if self.seen_s is None else self.seen_s,
            last_ranged_s=now_s if self.ranged_s is None else self.ranged_s,
            range_m=math.hypot(x, y),
            bearing_rad=wrap_angle(math.atan2(y, x)),
            facing_in_odom_rad=self.facing_rad,
            facing_sigma_rad=None if self.facing_rad is None else FACING_SIGMA_RAD,
        )


def _since(data: Mapping[str, Any], word: str, before_s: float | None, now_s: float) -> float | None:
    """None while it goes on; the time at which it ended otherwise."""
    if word not in data:
        return before_s
    if value_of(data[word], bool, f"track: {word}"):
        return None
    return now_s if before_s is None else before_s


@dataclass(frozen=True, eq=False)
class ObstacleScript:
    """Points, either standing in odom or going along with the robot."""

    points_m: FloatArray = field(default_factory=lambda: np.empty((0, 2)))
    goes_along: bool = False

    @staticmethod
    def fixed_in_base(data: Any) -> ObstacleScript:
        return ObstacleScript(array_of(data, "obstacles_in_base_m"), goes_along=True)

    @staticmethod
    def in_odom(data: Any) -> ObstacleScript:
        """`none`, or a list of `{circle: [x, y, radius]}`, `{box: [x, y, length, width, yaw]}`, `{wall: [x1, y1, x2,
        y2]}`, as in an arena."""
        if data is None or data == "none":
            return ObstacleScript()
        if not isinstance(data, (list, tuple)):
            raise BadScript(f"obstacles is {data!r}; it must be a list of {', '.join(SHAPES)}")
        parts = [_outline(each, f"obstacles[{i}]") for i, each in enumerate(data)]
        return ObstacleScript(np.vstack([np.empty((0, 2)), *parts]))

    def in_base(self, pose: Pose2D) -> FloatArray:
        return self.points_m if self.goes_along else points_to_child(pose, self.points_m)


def _outline(data: Any, what: str) -> FloatArray:
    if not isinstance(data, Mapping) or len(data) != 1 or next(iter(data)) not in SHAPES:
        raise BadScript(f"{what} is {data!r}; it must be one of {', '.join(SHAPES)}")
    shape, values = next(iter(data.items()))
    numbers = tuple_of(values, (float,) * len(SHAPES[shape]), f"{what}: {shape} ({', '.join(SHAPES[shape])})")
    if shape == "wall":
        return _line((numbers[0], numbers[1]), (numbers[2], numbers[3]))
    if shape == "circle":
        count = max(8, math.ceil(math.tau * numbers[2] / SPACING_M))
        angles = np.arange(count) * math.tau / count
        return np.column_stack(
            [numbers[0] + numbers[2] * np.cos(angles), numbers[1] + numbers[2] * np.sin(angles)]
        )
    x, y, length, width, yaw = numbers
    pose = Pose2D(x, y, yaw)
    corners = [
        to_parent(pose, 0.5 * a * length, 0.5 * b * width) for a, b in ((1, 1), (-1, 1), (-1, -1), (1, -1))
    ]
    return np.vstack([_line(a, b) for a, b in zip(corners, [*corners[1:], corners[0]])])


def _line(a: tuple[float, float], b: tuple[float, float]) -> FloatArray:
    count = max(2, math.ceil(math.dist(a, b) / SPACING_M) + 1)
    return np.linspace(a, b, count)


DETECTION_WORDS = ("range_m", "bearing_rad", "class", "score", "clipped", "confirmed")


@dataclass(frozen=True)
class DetectionsScript:
    """What the camera shows in every frame, with boxes as large as the target would have."""

    detections: tuple[Detection, ...] = ()

    @staticmethod
    def of(data: Any, config: Config, spec: TargetSpec) -> DetectionsScript | None:
        """`none`: no frame ever; otherwise a list, empty or of `{range_m, bearing_rad, class, ...}`."""
        if data is None or data == "none":
            return None
        if isinstance(data, DetectionFrame):
            return DetectionsScript(data.detections)
        if not isinstance(data, Sequence) or isinstance(data, str):
            raise BadScript(f"detections is {data!r}; it must be a list of {{{', '.join(DETECTION_WORDS)}}}")
        return DetectionsScript(tuple(_detection(each, i, config, spec) for i, each in enumerate(data)))

    def at(self, stamp_s: float) -> DetectionFrame:
        return DetectionFrame(stamp_s, round(stamp_s * 1000.0), self.detections)


def _detection(data: Any, index: int, config: Config, spec: TargetSpec) -> Detection:
    what = f"detections[{index}]"
    check_words(data, DETECTION_WORDS, what)
    camera = config.camera
    range_m = number(data, "range_m", what)
    if not range_m > 0.0:
        raise BadScript(f"{what}: range_m is {range_m:g}; it must be more than 0")
    bearing_rad = number(data, "bearing_rad", what, 0.0)
    return Detection(
        class_name=value_of(data.get("class", spec.class_name), str, f"{what}: class"),
        score=number(data, "score", what, 0.9),
        track_id=index + 1,
        u_px=camera.width_px / 2.0 - camera.focal_px * math.tan(bearing_rad),
        v_px=camera.height_px / 2.0,
        width_px=camera.focal_px * spec.width_m / range_m,
        height_px=camera.focal_px * spec.height_m / range_m,
        range_m=range_m,
        range_sigma_m=config.detector.range_sigma * range_m,
        bearing_rad=bearing_rad,
        bearing_sigma_rad=config.detector.bearing_sigma_rad,
        clipped=value_of(data.get("clipped", False), bool, f"{what}: clipped"),
        confirmed=value_of(data.get("confirmed", True), bool, f"{what}: confirmed"),
    )
