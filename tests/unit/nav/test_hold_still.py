"""Standing and waiting."""

from __future__ import annotations

from target_nav.nav.hold_still import HoldStill
from target_nav.nav.skill import SkillStatus
from target_nav.state.types import STOP, Twist2D
from tests.unit.nav.views import view


def test_it_stands_for_as_long_as_it_is_asked() -> None:
    skill = HoldStill()
    skill.start(view(0.0))
    for now_s in (0.0, 1.0, 1000.0):
        step = skill.step(view(now_s, twist=Twist2D(0.1, 0.0, 0.0)))
        assert (step.status, step.twist) == (SkillStatus.RUNNING, STOP)
