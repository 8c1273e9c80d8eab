"""Every transition of the reference mission has a scenario.

A transition is a leaf that decides a tick after which another one decides. Which there can be is found out, not listed:
the real tree is ticked with leaves that end as they like, with targets and inputs that come and go, and an operator
who says anything. A mission that is changed so that it does something new fails here until there is a scenario for it.
"""

from __future__ import annotations

import random
from collections.abc import Iterable
from functools import cache
from itertools import pairwise

import pytest
from py_trees.behaviour import Behaviour
from py_trees.common import Status

from behaviours.motion import MotionLeaf
from target_nav.app.paths import REFERENCE_MISSION, mission_path
from target_nav.config import Config
from target_nav.mission.mocks import Mock, MockSpec
from target_nav.mission.scenario_file import read_scenarios
from target_nav.mission.scenario_find import find_scenario_files
from target_nav.mission.scenario_run import run_scenario
from target_nav.mission.scripted_mission import ScriptedMission

pytestmark = pytest.mark.slow

MISSION = mission_path(REFERENCE_MISSION)
SKILLS = ("TurnSearch", "SpiralSearch", "NavigateToTarget", "BlindApproach", "ConfirmArrival")
STANDING = ("Idle", "HoldStill", "Arrived", "GiveUp")
ENDS_AT_ONCE = "NavigateToTarget"
"""With SUCCESS, when the target is near already. All other results take a tick at least."""
RUNS, TICKS = 40, 400
TWICE_A_SECOND = Config().override({"loop.rate_hz": 2.0})
"""The real mission waits for ten seconds; that is 20 ticks here."""

Transition = tuple[str, str]


class AnyResult(Mock):
    """RUNNING for some ticks, then SUCCESS or FAILURE, as the dice fall."""

    def __init__(self, behaviour: Behaviour, rng: random.Random) -> None:
        super().__init__(behaviour, MockSpec(behaviour.name))
        self._rng, self._least = rng, int(behaviour.name != ENDS_AT_ONCE)
        self._left, self._result = 0, Status.SUCCESS

    def _initialise(self) -> None:
        super()._initialise()
        self._left = self._rng.randint(self._least, 3)
        self._result = Status.FAILURE if self._left and self._rng.random() < 0.5 else Status.SUCCESS

    def _update(self) -> Status:
        self._left -= 1
        if self._left < 0:
            return self._result
        assert isinstance(self.behaviour, MotionLeaf)
        self._ask_for_motion(self.behaviour)
        return Status.RUNNING


def transitions(leaves: Iterable[str]) -> set[Transition]:
    """Between leaves of the mission; a SubTree that a scenario mocks is none."""
    return {(a, b) for a, b in pairwise(leaves) if a != b and {a, b} <= {*SKILLS, *STANDING}}


def wander(seed: int) -> list[str]:
    """Who decided, tick by tick."""
    rng = random.Random(seed)
    with ScriptedMission(MISSION, config=TWICE_A_SECOND) as mission:
        for name in SKILLS:
            for index in mission.index.find(name):
                AnyResult(mission.index.nodes[index], rng)
        for _ in range(TICKS):
            roll = rng.random()
            if roll < 0.05:
                mission.say("STOP")
            elif roll < 0.15:
                mission.say("GO")
            elif roll < 0.30:
                mission.set(track=rng.choice([None, {"range_m": 2.0}]))
            elif roll < 0.38:
                mission.set(scan_age_s=rng.choice([0.1, "never"]))
            mission.tick()
        return [seen.leaf_name for seen in mission.observations]


@cache
def possible() -> frozenset[Transition]:
    return frozenset().union(*(transitions(wander(seed)) for seed in range(RUNS)))


@cache
def covered() -> frozenset[Transition]:
    scenarios = [each for path in find_scenario_files([MISSION]) for each in read_scenarios(path)]
    return frozenset().union(*(transitions(run_scenario(scenario).leaves) for scenario in scenarios))


def test_every_transition_has_a_scenario() -> None:
    assert len(possible()) > 40
    assert sorted(possible() - covered()) == []


def test_no_scenario_shows_a_transition_that_wandering_does_not_find() -> None:
    assert sorted(covered() - possible()) == []
