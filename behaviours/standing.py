"""Standing still, with a reason: idle, holding, arrived, given up. None of them ends by itself."""

from __future__ import annotations

from py_trees.common import Status

from behaviours.leaf import text
from behaviours.motion import MotionLeaf
from target_nav.nav.skill import Skill, SkillStatus, SkillStep, View
from target_nav.state import keys
from target_nav.state.types import NavState, Outcome, OutcomeKind


class _StandStill:
    """The skill of doing nothing."""

    def __init__(self, reason: str) -> None:
        self._step = SkillStep(SkillStatus.RUNNING, reason=reason)

    def start(self, view: View) -> None:
        """Nothing to prepare."""

    def step(self, view: View) -> SkillStep:
        return self._step


class StandingLeaf(MotionLeaf):
    """Asks for zero velocity and keeps RUNNING."""

    STATE = NavState.IDLE
    REASON = ""

    def reason(self) -> str:
        return str(self.get_input("reason", self.REASON)) if "reason" in self.input_ports() else self.REASON

    def make_skill(self) -> Skill:
        return _StandStill(self.reason())


class Idle(StandingLeaf):
    """Waits for GO."""

    INPUT_PORTS = {}
    OUTPUT_PORTS = {}
    REASON = "waiting for GO"


class HoldStill(StandingLeaf):
    """Stands still for a reason that the mission gives."""

    INPUT_PORTS = {"reason": text("shown to the operator", default="holding still")}
    OUTPUT_PORTS = {}


class EndingLeaf(StandingLeaf):
    """Stands still and says how the mission ended, until it is halted; then the outcome is gone as well."""

    KIND: OutcomeKind
    WRITES = (keys.REQUEST, keys.OUTCOME)

    def update(self) -> Status:
        status = super().update()
        self.write(keys.OUTCOME, Outcome(self.KIND, self.feedback_message))
        return status

    def terminate(self, new_status: Status) -> None:
        super().terminate(new_status)
        if self.status is Status.RUNNING:
            self.write(keys.OUTCOME, None)


class Arrived(EndingLeaf):
    """The mission succeeded: the robot stands in front of the target and stays there."""

    STATE = NavState.ARRIVED
    NEAR_TARGET = True
    KIND = OutcomeKind.SUCCEEDED
    INPUT_PORTS = {"reason": text("shown to the operator", default="arrived")}
    OUTPUT_PORTS = {}


class GiveUp(EndingLeaf):
    """The mission failed: the robot stands still and says why."""

    KIND = OutcomeKind.FAILED
    INPUT_PORTS = {"reason": text("shown to the operator", default="gave up")}
    OUTPUT_PORTS = {}
