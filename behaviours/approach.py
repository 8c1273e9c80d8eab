"""Going to the target: drive there round obstacles, close the last metre by odometry, make sure, stay."""

from __future__ import annotations

from enum import Enum

import py_trees
from py_trees.common import Status
from py_trees.ports import PortInformation

from behaviours.leaf import MissionLeaf, number
from behaviours.motion import DISTANCE_M, REASON_PORT, SPEED_MPS, TIME_S, MotionLeaf
from target_nav.config import Config
from target_nav.nav.arrival import ConfirmArrival as ConfirmArrivalSkill
from target_nav.nav.blind_approach import BlindApproach as BlindApproachSkill
from target_nav.nav.navigate import NavigateToTarget as NavigateToTargetSkill
from target_nav.nav.skill import Skill
from target_nav.state import keys
from target_nav.state.target_label import surface_m
from target_nav.state.types import NavState


class ApproachFrom(str, Enum):
    """Named as a mission's author writes them."""

    anywhere = "anywhere"
    face = "face"


class TargetTracked(MissionLeaf):
    """SUCCESS while there is a confirmed track that the camera saw within `max_age_s`."""

    INPUT_PORTS = {"max_age_s": number("how long ago the camera may have seen it", default=1.0)}
    OUTPUT_PORTS = {}
    PORT_LIMITS = {"max_age_s": TIME_S}
    READS = (keys.TRACK, keys.NOW_S)

    def update(self) -> Status:
        track = self.read(keys.TRACK)
        if track is None:
            return self.say("there is no track", Status.FAILURE)
        if not track.confirmed:
            return self.say(f"seen {track.hits} times, not yet confirmed", Status.FAILURE)
        age_s = self.read(keys.NOW_S) - track.last_seen_s
        limit_s = self.get_input("max_age_s")
        if age_s > limit_s:
            return self.say(f"last seen {age_s:.1f} s ago (limit {limit_s:.1f} s)", Status.FAILURE)
        return self.say(f"{track.range_m:.2f} m away", Status.SUCCESS)


class NavigateToTarget(MotionLeaf):
    """Drives towards the track, round obstacles, until base_link is `until_range_m` from the target's centre."""

    STATE = NavState.NAVIGATING
    INPUT_PORTS = {
        "speed_mps": number("cruise speed"),
        "until_range_m": number("base_link to the target's centre: hand over to the blind approach"),
        "lost_after_s": number("FAILURE when the camera has not seen it for so long"),
        "from": PortInformation(
            ApproachFrom,
            required=False,
            description="face: to straight before the face of a flat target, if its detector knows where that looks",
            default_value=ApproachFrom.anywhere,
        ),
    }
    OUTPUT_PORTS = REASON_PORT
    PORT_LIMITS = {"speed_mps": SPEED_MPS, "until_range_m": DISTANCE_M, "lost_after_s": TIME_S}

    def make_skill(self) -> Skill:
        config = self.config()
        return NavigateToTargetSkill(
            config,
            cruise_speed_mps=self.get_input("speed_mps", config.approach.cruise_speed_mps),
            until_range_m=self.get_input("until_range_m", config.approach.blind_from_m),
            lost_after_s=self.get_input("lost_after_s", config.track.lost_after_s),
            from_face=self.get_input("from") is ApproachFrom.face,
        )


class BlindApproach(MotionLeaf):
    """Closes the last metre, where camera and LiDAR go blind, by odometry; stops at the stand-off."""

    STATE = NavState.BLIND_APPROACH
    NEAR_TARGET = True
    INPUT_PORTS = {
        "stand_off_m": number("front edge to the target's surface at the end"),
        "speed_mps": number("top speed of the last metre"),
        "timeout_s": number("FAILURE after so long"),
    }
    OUTPUT_PORTS = REASON_PORT
    PORT_LIMITS = {"stand_off_m": (0.0, 2.0), "speed_mps": (0.01, 1.0), "timeout_s": TIME_S}

    def make_skill(self) -> Skill:
        config, spec = self.config(), self.spec()
        return BlindApproachSkill(
            config,
            stand_off_m=self.get_input("stand_off_m", config.approach.stand_off_m),
            speed_mps=self.get_input("speed_mps", config.approach.blind_speed_mps),
            timeout_s=self.get_input("timeout_s", config.approach.blind_timeout_s),
            target_radius_m=surface_m(spec.class_name, spec.width_m),
        )


class ConfirmArrival(MotionLeaf):
    """Stands and looks: SUCCESS when several independent signals agree for a while that the target is there."""

    STATE = NavState.BLIND_APPROACH
    NEAR_TARGET = True
    INPUT_PORTS = {
        "stand_off_m": number("the stand-off that was asked for"),
        "confirm_s": number("signals must agree for so long"),
        "timeout_s": number("FAILURE when they have not agreed after so long", default=5.0),
    }
    OUTPUT_PORTS = REASON_PORT
    PORT_LIMITS = {"stand_off_m": (0.0, 2.0), "confirm_s": (0.0, 60.0), "timeout_s": TIME_S}

    def make_skill(self) -> Skill:
        config, spec = self.config(), self.spec()
        return ConfirmArrivalSkill(
            config,
            stand_off_m=self.get_input("stand_off_m", config.approach.stand_off_m),
            confirm_s=self.get_input("confirm_s", config.arrival.confirm_s),
            timeout_s=self.get_input("timeout_s"),
            target_radius_m=surface_m(spec.class_name, spec.width_m),
            target_width_m=spec.width_m,
        )


def stand_off_of(root: py_trees.behaviour.Behaviour, config: Config) -> float:
    """The stand-off in metres that a tree asks for: that of its blind approach, or the configuration's."""
    for node in root.iterate():
        if isinstance(node, BlindApproach):
            return float(node.get_input("stand_off_m", config.approach.stand_off_m))
    return config.approach.stand_off_m
