"""Stopping for what may be the target, and not for every false box again and again."""

from __future__ import annotations

from target_nav.config import RobotConfig
from target_nav.nav.glimpse import Glimpse, Sight
from target_nav.state.types import STOP
from tests.unit.nav.views import track_at, view


def test_a_confirmed_track_seen_just_now_is_found() -> None:
    assert Glimpse(RobotConfig()).look(view(5.0, track=track_at(2.0, 0.0, 5.0))) is Sight.FOUND


def test_a_confirmed_track_of_some_time_ago_is_not() -> None:
    assert (
        Glimpse(RobotConfig()).look(view(5.0, track=track_at(2.0, 0.0, 5.0, seen_ago_s=2.0))) is Sight.NOTHING
    )


def test_an_unsure_one_is_looked_at_for_a_moment_then_left_for_a_while() -> None:
    glimpse = Glimpse(RobotConfig())
    seen = [
        glimpse.look(view(5.0 + 0.1 * i, track=track_at(2.0, 0.0, 5.0 + 0.1 * i, confirmed=False)))
        for i in range(40)
    ]
    assert seen[0] is Sight.LOOKING
    first_nothing = seen.index(Sight.NOTHING)
    assert 10 <= first_nothing <= 14
    again = seen.index(Sight.LOOKING, first_nothing)
    assert again - first_nothing >= 19


def test_it_faces_what_it_looks_at() -> None:
    glimpse = Glimpse(RobotConfig())
    seen = view(5.0, track=track_at(2.0, 0.6, 5.0, confirmed=False))
    glimpse.look(seen)
    assert glimpse.twist(seen).wz_radps > 0.1
    assert glimpse.twist(view(5.0)) == STOP
