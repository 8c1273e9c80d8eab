"""What is asked before the robot may do anything: is it wanted, can it see, what is it looking for?"""

from __future__ import annotations

import math

from py_trees.common import Status
from py_trees.ports import PortInformation

from behaviours.leaf import MissionLeaf, number, text
from behaviours.motion import TIME_S
from target_nav.errors import ConfigError
from target_nav.state import keys
from target_nav.state.target_label import TargetDetector, make_label
from target_nav.state.types import TargetSpec


class SetTarget(MissionLeaf):
    """Says what the mission looks for, unless the operator chose something else. SUCCESS at once."""

    INPUT_PORTS = {
        "class": text("what to look for: the detector's class, a colour, a tag's number", required=True),
        "height_m": PortInformation(float, required=True, description="scales the distance from the camera"),
        "width_m": PortInformation(
            float, required=True, description="checks shapes, and is twice the radius"
        ),
        "lidar_width_m": number("width at the LiDAR's height, if that is less", default=0.0),
        "detector": PortInformation(
            TargetDetector,
            required=False,
            description="what finds it in the picture",
            default_value=TargetDetector.network,
        ),
    }
    OUTPUT_PORTS = {}
    PORT_LIMITS = {"height_m": (0.01, 5.0), "width_m": (0.01, 5.0), "lidar_width_m": (0.0, 5.0)}
    READS = (keys.TARGET_CHOICE,)
    WRITES = (keys.SPEC,)

    def update(self) -> Status:
        chosen: TargetSpec | None = self.read(keys.TARGET_CHOICE)
        try:
            spec = chosen or self._spec_of_the_mission()
        except ConfigError as error:
            return self.say(str(error), Status.FAILURE)
        self.write(keys.SPEC, spec)
        return self.say(f"{spec.class_name}, {spec.height_m:.2f} m x {spec.width_m:.2f} m", Status.SUCCESS)

    def _spec_of_the_mission(self) -> TargetSpec:
        label = make_label(self.get_input("detector"), self.get_input("class"))
        sizes_m = (self.get_input(port) for port in ("height_m", "width_m", "lidar_width_m"))
        return TargetSpec(label, *sizes_m)


class MissionRequested(MissionLeaf):
    """SUCCESS while the operator's last word was GO."""

    INPUT_PORTS = {}
    OUTPUT_PORTS = {}
    READS = (keys.REQUESTED,)

    def update(self) -> Status:
        if self.read(keys.REQUESTED):
            return self.say("GO", Status.SUCCESS)
        return self.say("waiting for GO", Status.FAILURE)


class InputsFresh(MissionLeaf):
    """SUCCESS while LiDAR, odometry and camera are younger than their limits; otherwise says which is not.

    A mission that looks for nothing needs no camera: `camera_needed="false"`.
    """

    INPUT_PORTS = {
        "scan_max_age_s": number("LiDAR"),
        "odom_max_age_s": number("odometry"),
        "camera_max_age_s": number("detections, empty ones included"),
        "camera_needed": PortInformation(
            bool, required=False, description="whether detections are looked at at all", default_value=True
        ),
    }
    OUTPUT_PORTS = {"reason": text("what is missing, in words")}
    PORT_LIMITS = {"scan_max_age_s": TIME_S, "odom_max_age_s": TIME_S, "camera_max_age_s": TIME_S}
    READS = (keys.SCAN_AGE_S, keys.ODOM_AGE_S, keys.CAMERA_AGE_S, keys.CONFIG)

    def update(self) -> Status:
        loop = self.config().loop
        checks: tuple[tuple[str, keys.Key, str, float, str], ...] = (
            ("scan", keys.SCAN_AGE_S, "scan_max_age_s", loop.scan_max_age_s, "is the LiDAR running?"),
            (
                "odometry",
                keys.ODOM_AGE_S,
                "odom_max_age_s",
                loop.odom_max_age_s,
                "are arduino and odometry running?",
            ),
            (
                "camera",
                keys.CAMERA_AGE_S,
                "camera_max_age_s",
                loop.camera_max_age_s,
                "are detector and camera running?",
            ),
        )
        if not self.get_input("camera_needed"):
            checks = checks[:-1]
        stale = []
        for what, key, port, configured_s, question in checks:
            age_s, limit_s = self.read(key), self.get_input(port, configured_s)
            # written so that a NaN age counts as stale
            if not age_s <= limit_s:
                old = f"{age_s:.2f} s old" if math.isfinite(age_s) else "has not come yet"
                stale.append(f"{what} {old} (limit {limit_s:.2f} s); {question}")
        if not stale:
            return self.say("all inputs fresh", Status.SUCCESS)
        message = " ".join(stale)
        self._set_output("reason", message)
        return self.say(message, Status.FAILURE)
