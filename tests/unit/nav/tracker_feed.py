"""A tracker to be fed by hand, frame by frame, and the places its tests happen in."""

from __future__ import annotations

import dataclasses
import math

from target_nav.config import Config
from target_nav.nav.tracker import TargetTracker
from target_nav.state.types import Detection, DetectionFrame, Pose2D, TargetSpec, Track, Twist2D
from tests.unit.nav.scripted_world import (
    SPEC,
    STANDING,
    Drive,
    Tick,
    World,
    detection,
    error_m,
)

CONFIG = Config()
CAMERA_X_M = CONFIG.camera.x_m
ROOM = [(-3.0, -3.0, 5.0, -3.0), (5.0, -3.0, 5.0, 3.0), (5.0, 3.0, -3.0, 3.0), (-3.0, 3.0, -3.0, -3.0)]
AHEAD = Drive(Pose2D(), ((8.0, Twist2D(0.15, 0.0, 0.0)),))


class Feed:
    """A tracker on a robot that stands at the origin (or moves as told), fed with frames by hand at 10 Hz."""

    def __init__(self, drive: Drive = STANDING, config: Config = CONFIG) -> None:
        self.world = World(drive=drive, config=config)
        self.tracker = TargetTracker(config)
        self.now_s = drive.begin_s
        self.poses = self.world.poses(self.now_s, since_s=self.now_s - 1.0)

    def frame(self, *detections: Detection) -> DetectionFrame:
        return DetectionFrame(self.now_s - 0.1, 0, detections)

    def step(
        self, *detections: Detection, spec: TargetSpec = SPEC, world: World | None = None
    ) -> Track | None:
        """One frame with these detections, and a scan of `world` if given."""
        for _ in range(2):
            self.now_s += 0.05
            self.poses.add(self.world.odometry(self.now_s))
        scan = None if world is None else world.scan(self.now_s - 0.2)
        return self.tracker.update(self.now_s, self.poses, spec, self.frame(*detections), scan)

    def steps(self, count: int, *detections: Detection) -> Track | None:
        track = None
        for _ in range(count):
            track = self.step(*detections)
        return track

    def wait(self, seconds: float) -> Track | None:
        """No frames at all for so long."""
        track = None
        for _ in range(round(seconds / 0.05)):
            self.now_s += 0.05
            self.poses.add(self.world.odometry(self.now_s))
            track = self.tracker.update(self.now_s, self.poses, SPEC, None, None)
        return track


def pin_at(x_m: float, y_m: float = 0.0, **changes: object) -> Detection:
    """What the camera of a robot at the origin says of a pin there."""
    seen = detection(math.hypot(x_m - CAMERA_X_M, y_m), math.atan2(y_m, x_m - CAMERA_X_M))
    return dataclasses.replace(seen, **changes)


def relative_error_m(world: World, tick: Tick, pin: tuple[float, float]) -> float:
    return error_m(tick.track, world.in_odom(pin, tick.now_s))
