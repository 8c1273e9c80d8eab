"""Going to places that the mission names, in the frame odom: its origin is where odometry began."""

from __future__ import annotations

from behaviours.leaf import number
from behaviours.motion import REASON_PORT, SPEED_MPS, TIME_S, MotionLeaf
from target_nav.nav.go_to_point import GoToPoint as GoToPointSkill
from target_nav.nav.skill import Skill
from target_nav.state.types import NavState

PLACE_M = (-100.0, 100.0)


class GoToPoint(MotionLeaf):
    """Drives to a place round obstacles, whatever it sees on the way. SUCCESS there.

    What the mission does not say of the place, the configuration does (`goal.*`).
    """

    STATE = NavState.NAVIGATING
    INPUT_PORTS = {
        "x_m": number("in odom: forward of where odometry began"),
        "y_m": number("in odom: to the left of where odometry began"),
        "within_m": number("SUCCESS with base_link as near as this"),
        "speed_mps": number("cruise speed"),
        "time_limit_s": number("FAILURE after so long", default=120.0),
    }
    OUTPUT_PORTS = REASON_PORT
    PORT_LIMITS = {
        "x_m": PLACE_M,
        "y_m": PLACE_M,
        "within_m": (0.03, 5.0),
        "speed_mps": SPEED_MPS,
        "time_limit_s": TIME_S,
    }

    def make_skill(self) -> Skill:
        config = self.config()
        return GoToPointSkill(
            config,
            x_m=self.get_input("x_m", config.goal.x_m),
            y_m=self.get_input("y_m", config.goal.y_m),
            within_m=self.get_input("within_m", config.goal.within_m),
            speed_mps=self.get_input("speed_mps", config.approach.cruise_speed_mps),
            time_limit_s=self.get_input("time_limit_s"),
        )
