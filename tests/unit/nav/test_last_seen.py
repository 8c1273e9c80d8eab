"""When a target that is out of sight counts as lost."""

from __future__ import annotations

from target_nav.config import Config
from target_nav.nav.last_seen import LastSeen
from target_nav.state.types import FloatArray, Pose2D
from tests.unit.nav.views import NO_POINTS, ORIGIN, track_at, view, wall

LIMIT_S = 3.0


def lost_after(
    obstacles: FloatArray = NO_POINTS, pose: Pose2D = ORIGIN, keep_track: bool = True
) -> float | None:
    """Seconds until a target seen last at 0 s, two metres ahead, counts as lost; None if it does not within 30 s."""
    last_seen = LastSeen(Config(), LIMIT_S)
    last_seen.begin(0.0)
    seen = track_at(2.0, 0.0, 0.0, seen_ago_s=0.0)
    for tick in range(600):
        now_s = 0.05 * tick
        track = seen if keep_track or tick == 0 else None
        if last_seen.lost(view(now_s, pose=pose, track=track, obstacles=obstacles)):
            return now_s
    return None


def test_in_plain_sight_it_is_lost_after_the_limit() -> None:
    found = lost_after()
    assert found is not None
    assert LIMIT_S < found < LIMIT_S + 0.2


def test_it_is_remembered_when_the_tracker_has_dropped_it() -> None:
    found = lost_after(keep_track=False)
    assert found is not None
    assert LIMIT_S < found < LIMIT_S + 0.2


def test_behind_something_it_is_not_missed_for_a_while() -> None:
    found = lost_after(wall(1.0, -0.3, 1.0, 0.3))
    assert found is not None
    assert 10.0 < found < 20.0, "later, but not never"


def test_what_stands_beside_or_behind_it_does_not_hide_it() -> None:
    assert lost_after(wall(1.0, 0.15, 1.0, 0.5)) == lost_after()
    assert lost_after(wall(2.2, -0.3, 2.2, 0.3)) == lost_after()


def test_out_of_the_picture_it_is_not_missed_for_a_while() -> None:
    found = lost_after(pose=Pose2D(yaw_rad=1.5))
    assert found is not None
    assert found > 10.0


def test_without_any_track_the_limit_counts_from_the_beginning() -> None:
    last_seen = LastSeen(Config(), LIMIT_S)
    last_seen.begin(50.0)
    assert last_seen.lost(view(52.9)) == ""
    assert "no confirmed track" in last_seen.lost(view(53.1))


def test_an_unconfirmed_track_does_not_replace_a_confirmed_one() -> None:
    last_seen = LastSeen(Config(), LIMIT_S)
    last_seen.begin(0.0)
    last_seen.lost(view(0.0, track=track_at(2.0, 0.0, 0.0)))
    last_seen.lost(view(0.1, track=track_at(0.5, 1.0, 0.1, confirmed=False)))
    assert last_seen.track is not None
    assert last_seen.track.x_m == 2.0
