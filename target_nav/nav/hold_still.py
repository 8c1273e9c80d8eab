"""Stands and waits; a guard or a time limit in the mission ends it."""

from __future__ import annotations

from target_nav.nav.skill import SkillStatus, SkillStep, View
from target_nav.state.types import STOP


class HoldStill:
    def start(self, view: View) -> None:
        """Nothing to prepare."""

    def step(self, view: View) -> SkillStep:
        return SkillStep(SkillStatus.RUNNING, STOP, "holding still")
