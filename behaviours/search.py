"""Finding the target: turn on the spot, then drive a spiral; or look round to know all that there are."""

from __future__ import annotations

from typing import ClassVar

from behaviours.leaf import number
from behaviours.motion import DISTANCE_M, REASON_PORT, SPEED_MPS, TIME_S, MotionLeaf
from target_nav.nav.look_round import LookRound as LookRoundSkill
from target_nav.nav.skill import Skill
from target_nav.nav.spiral_search import SpiralSearch as SpiralSearchSkill
from target_nav.nav.turn_search import TurnSearch as TurnSearchSkill
from target_nav.state import keys
from target_nav.state.types import NavState


class TurningLeaf(MotionLeaf):
    """Turns on the spot to see."""

    STATE = NavState.SEARCHING
    SKILL: ClassVar[type[TurnSearchSkill] | type[LookRoundSkill]]
    INPUT_PORTS = {
        "time_limit_s": number("FAILURE after so long"),
        "yaw_rate_radps": number("turning speed"),
    }
    OUTPUT_PORTS = REASON_PORT
    PORT_LIMITS = {"time_limit_s": TIME_S, "yaw_rate_radps": (0.05, 3.0)}

    def make_skill(self) -> Skill:
        config = self.config()
        return self.SKILL(
            config,
            time_limit_s=self.get_input("time_limit_s", config.search.time_limit_s),
            yaw_rate_radps=self.get_input("yaw_rate_radps", config.search.yaw_rate_radps),
        )


class TurnSearch(TurningLeaf):
    """Turns towards where the target was last seen, then all the way round. SUCCESS when a track is confirmed."""

    SKILL = TurnSearchSkill


class SpiralSearch(MotionLeaf):
    """Drives outwards in a spiral and looks round on the way. SUCCESS when a track is confirmed.

    Until the next GO all leaves that ask for the same search share it: none looks where another has looked.
    """

    STATE = NavState.SPIRAL_SEARCH
    READS = (*MotionLeaf.READS, keys.SEARCH)
    WRITES = (keys.REQUEST, keys.SEARCH)
    INPUT_PORTS = {
        "time_limit_s": number("FAILURE after so long"),
        "radius_m": number("how far out"),
        "spacing_m": number("from one turn of the spiral to the next"),
        "speed_mps": number("speed along the spiral"),
    }
    OUTPUT_PORTS = REASON_PORT
    PORT_LIMITS = {
        "time_limit_s": TIME_S,
        "radius_m": DISTANCE_M,
        "spacing_m": (0.1, 5.0),
        "speed_mps": SPEED_MPS,
    }

    def make_skill(self) -> Skill:
        config = self.config()
        asked = {
            "time_limit_s": self.get_input("time_limit_s", config.search.spiral_time_limit_s),
            "radius_m": self.get_input("radius_m", config.search.spiral_radius_m),
            "spacing_m": self.get_input("spacing_m", config.search.spiral_spacing_m),
            "speed_mps": self.get_input("speed_mps", config.search.spiral_speed_mps),
        }
        begun = self.read(keys.SEARCH)
        if begun is None or begun[0] != asked:
            begun = (asked, SpiralSearchSkill(config, **asked))
            self.write(keys.SEARCH, begun)
        skill: Skill = begun[1]
        return skill


class LookRound(TurningLeaf):
    """Turns once all the way round, then faces the nearest target that it saw. FAILURE if there was none."""

    SKILL = LookRoundSkill
