"""Candidates: who gets which detection and which cluster, and what happens when camera and LiDAR disagree."""

from __future__ import annotations

import math

import pytest

from target_nav.config import Config
from target_nav.nav.lidar_clusters import TargetFix
from target_nav.nav.tracker_candidate import Candidate, Travel
from target_nav.nav.tracker_candidates import CandidateSet
from target_nav.nav.tracker_filter import CameraMeasurement, TargetFilter
from target_nav.state.types import Pose2D
from tests.unit.nav.scripted_world import SPEC

CONFIG = Config()
GATE = CONFIG.track.gate_sigma**2
ORIGIN = Pose2D()
START = Travel()


def measured(x_m: float, y_m: float = 0.0) -> CameraMeasurement:
    """What a camera at the origin measures of a target there."""
    range_m = math.hypot(x_m, y_m)
    return CameraMeasurement(range_m, 0.035 * range_m, math.atan2(y_m, x_m), 0.01, bearing_only=False)


def fix_at(x_m: float, y_m: float = 0.0, stamp_s: float = 1.0, doubtful: bool = False) -> TargetFix:
    covariance_m2 = (2e-4, 0.0, 0.0, 2e-4)
    return TargetFix(stamp_s, x_m, y_m, covariance_m2, 3, 0.0, 0.0, covariance_m2, doubtful)


def seen(x_m: float, y_m: float = 0.0, hits: int = 10) -> Candidate:
    candidate = Candidate(TargetFilter(CONFIG.track, ORIGIN, measured(x_m, y_m)), START, 0.0, hits=1)
    for _ in range(hits - 1):
        look(candidate, x_m, y_m)
    candidate.hits, candidate.confirmed = hits, hits >= CONFIG.track.confirm_hits
    return candidate


def look(candidate: Candidate, x_m: float, y_m: float = 0.0) -> None:
    expected = candidate.camera.expect(ORIGIN)
    assert expected is not None
    candidate.see(ORIGIN, expected, measured(x_m, y_m), GATE)


def position(candidate: Candidate) -> tuple[float, float]:
    return candidate.filter.x_m, candidate.filter.y_m


def take_fixes(candidate: Candidate, *fixes: TargetFix) -> None:
    CandidateSet(CONFIG, [candidate]).take_fixes(fixes, ORIGIN, START)


def test_one_look_at_a_cluster_moves_nothing_and_the_second_does() -> None:
    candidate = seen(2.0)
    take_fixes(candidate, fix_at(2.05))
    assert position(candidate) == pytest.approx((2.0, 0.0))
    assert candidate.last_ranged_s == -math.inf
    take_fixes(candidate, fix_at(2.05, stamp_s=1.2))
    assert candidate.filter.x_m > 2.04
    assert candidate.last_ranged_s == 1.2


@pytest.mark.parametrize(
    "second", [fix_at(1.95, stamp_s=1.2), fix_at(2.05, stamp_s=2.5)], ids=["elsewhere", "later"]
)
def test_a_second_look_that_does_not_bear_out_the_first_moves_nothing(second: TargetFix) -> None:
    candidate = seen(2.0)
    take_fixes(candidate, fix_at(2.05))
    take_fixes(candidate, second)
    assert position(candidate) == pytest.approx((2.0, 0.0))


def twice(candidate: Candidate, *fixes: tuple[float, float, bool]) -> bool:
    """Whether the same clusters, seen in two scans, were taken."""
    for stamp_s in (1.0, 1.2):
        take_fixes(candidate, *(fix_at(x_m, y_m, stamp_s, doubtful) for x_m, y_m, doubtful in fixes))
    return candidate.fused is not None


def test_of_two_clusters_that_fit_alike_none_is_taken() -> None:
    assert not twice(seen(2.0), (1.97, 0.0, False), (2.06, 0.0, False))


def test_of_two_clusters_the_one_that_fits_far_better_is_taken() -> None:
    candidate = seen(2.0)
    assert twice(candidate, (2.02, 0.0, False), (2.02, 0.12, False))
    assert abs(candidate.filter.y_m) < 0.02


def test_a_doubtful_cluster_is_never_taken_and_keeps_a_worse_one_from_being_taken() -> None:
    assert not twice(seen(2.0), (2.0, 0.0, True))
    assert not twice(seen(2.0), (2.0, 0.0, True), (2.03, 0.05, False))
    assert twice(seen(2.0), (2.0, 0.0, False), (2.03, 0.12, True))


def test_a_cluster_outside_the_gate_is_not_taken() -> None:
    assert not twice(seen(2.0), (2.0, 0.2, False))
    assert not twice(seen(6.0), (6.0 + CONFIG.track.lidar_range_gate_m + 0.05, 0.0, False))


def test_a_candidate_that_was_seen_once_takes_no_cluster() -> None:
    assert not twice(seen(2.0, hits=1), (2.0, 0.0, False))


def test_when_camera_and_lidar_no_longer_agree_the_camera_is_right() -> None:
    candidate = seen(2.0, hits=2)
    candidate.take(fix_at(2.1, 0.12))
    assert candidate.filter.y_m > 0.06
    for _ in range(30):
        look(candidate, 2.0)
    assert position(candidate) == pytest.approx((2.0, 0.0), abs=0.01)
    assert candidate.last_ranged_s == -math.inf


def test_a_cluster_that_only_agrees_with_earlier_clusters_is_not_taken() -> None:
    """Without this, a chair leg that was taken once is taken for ever."""
    candidate = seen(2.0, hits=30)
    candidate.take(fix_at(2.1, 0.15))
    candidate.last_fix = fix_at(2.1, 0.15)
    before = position(candidate)
    take_fixes(candidate, fix_at(2.1, 0.15, stamp_s=1.2))
    assert position(candidate) == before


def test_a_cluster_that_suits_the_camera_better_ends_a_wrong_one_within_three_scans() -> None:
    candidate = seen(2.0, hits=2)
    candidate.take(fix_at(2.1, 0.06))
    scans = [
        (fix_at(2.1, 0.06, 1.0 + 0.2 * n), fix_at(2.0, 0.0, 1.0 + 0.2 * n, doubtful=True)) for n in range(3)
    ]
    believed = []
    for fixes in scans:
        believed.append(candidate.fused is not None)
        take_fixes(candidate, *fixes)
    assert believed == [True, True, True]
    assert candidate.fused is None
    assert position(candidate) == pytest.approx((2.0, 0.0))


def test_doubts_that_are_settled_in_between_end_nothing() -> None:
    candidate = seen(2.0, hits=2)
    candidate.take(fix_at(2.1, 0.06))
    for scan in range(6):
        others = [] if scan % 2 else [fix_at(2.0, 0.0, 1.0, doubtful=True)]
        take_fixes(candidate, fix_at(2.1, 0.06, 1.0), *others)
    assert candidate.fused is not None


def test_an_outlier_of_the_camera_does_not_move_what_the_lidar_settled() -> None:
    candidate = seen(2.0)
    for _ in range(5):
        candidate.take(fix_at(2.0))
    before = position(candidate)
    look(candidate, 2.6)
    assert position(candidate) == pytest.approx(before, abs=0.005)
    assert candidate.filter.camera_scale_error == pytest.approx(0.0, abs=0.002)


def take_frame(candidates: CandidateSet, *measurements: CameraMeasurement) -> int:
    return candidates.take_frame(1.0, ORIGIN, measurements, SPEC, START, lambda candidate, expected: True)


def test_a_confirmed_candidate_is_served_before_one_that_fits_better() -> None:
    confirmed, tentative = seen(2.0), seen(2.15, hits=2)
    take_frame(CandidateSet(CONFIG, [tentative, confirmed]), measured(2.12))
    assert (confirmed.hits, tentative.hits) == (11, 2)
    assert (confirmed.misses, tentative.misses) == (0, 1)


def test_each_detection_goes_to_one_candidate_and_each_candidate_gets_one() -> None:
    left, right = seen(2.0, 0.2), seen(2.0, -0.2)
    candidates = CandidateSet(CONFIG, [left, right])
    assert take_frame(candidates, measured(2.0, -0.21), measured(2.0, 0.21), measured(3.0, 0.8)) == 1
    assert (left.hits, right.hits) == (11, 11)
    assert len(candidates.candidates) == 3


def test_a_crowd_of_false_boxes_pushes_no_confirmed_candidate_out() -> None:
    confirmed = seen(2.0)
    candidates = CandidateSet(CONFIG, [confirmed])
    for row in range(3):
        take_frame(candidates, *(measured(3.0 + row, -1.5 + 0.3 * column) for column in range(11)))
    assert confirmed in candidates.candidates
    assert len(candidates.candidates) <= 12


def test_two_candidates_at_one_place_become_one_and_the_one_seen_more_often_stays() -> None:
    often, rarely, beside = seen(2.0), seen(2.05, hits=5), seen(2.0, 0.2)
    candidates = CandidateSet(CONFIG, [rarely, often, beside])
    take_frame(candidates)
    assert candidates.candidates == [often, beside]


def test_the_chosen_one_stays_when_two_become_one() -> None:
    chosen, other = seen(2.0), seen(2.3, hits=50)
    candidates = CandidateSet(CONFIG, [chosen, other])
    assert candidates.choose(1.0, ORIGIN) is chosen
    for _ in range(3):
        other.take(fix_at(2.05))
    take_frame(candidates)
    assert candidates.choose(1.0, ORIGIN) is chosen
    assert candidates.candidates == [chosen]


def test_the_nearest_confirmed_is_meant_and_the_most_often_seen_while_none_is() -> None:
    near, far, fresh = seen(1.5), seen(2.5, 0.5), seen(0.8, -0.2, hits=2)
    assert CandidateSet(CONFIG, [far, near, fresh]).choose(1.0, ORIGIN) is near
    twice_seen = seen(3.0, 0.4, hits=3)
    assert CandidateSet(CONFIG, [fresh, twice_seen]).choose(1.0, ORIGIN) is twice_seen
    assert CandidateSet(CONFIG).choose(1.0, ORIGIN) is None


def test_a_candidate_that_is_not_seen_where_it_should_be_gives_way_to_one_that_is() -> None:
    ghost, real = seen(1.5), seen(2.5, 0.5)
    candidates = CandidateSet(CONFIG, [ghost, real])
    assert candidates.choose(1.0, ORIGIN) is ghost
    ghost.misses = 12
    assert candidates.choose(1.1, ORIGIN) is ghost
    assert candidates.choose(1.1 + CONFIG.track.switch_after_s, ORIGIN) is real


def test_it_gives_way_only_to_the_same_rival_for_the_whole_time() -> None:
    chosen, first, second = seen(2.5), seen(1.5, 0.5), seen(1.5, -0.5)
    candidates = CandidateSet(CONFIG, [chosen])
    assert candidates.choose(0.0, ORIGIN) is chosen
    candidates.candidates = [chosen, first]
    assert candidates.choose(0.5, ORIGIN) is chosen
    candidates.candidates = [chosen, second]
    assert candidates.choose(1.4, ORIGIN) is chosen
    assert candidates.choose(1.6, ORIGIN) is chosen
    assert candidates.choose(2.5, ORIGIN) is second


def test_between_two_scans_drift_counts_little_and_after_half_a_metre_as_much_as_to_the_camera() -> None:
    """Drift is a wrong scale: the way since the last fix decides how much of it there is for each metre more."""
    candidate = seen(2.0)
    take_fixes(candidate, fix_at(2.0))
    take_fixes(candidate, fix_at(2.0, stamp_s=1.2))
    assert candidate.fused is not None
    per_metre: list[float] = []
    for way_m in (0.02, 0.04, 0.2, 0.4, 0.8, 1.2):
        before = candidate.since
        travel = Travel(before.time_s, way_m, 0.0)
        per_metre.append(candidate.growth(ORIGIN, travel)[0] / (way_m - before.way_m))
        candidate.catch_up(ORIGIN, travel)
    assert per_metre == pytest.approx(sorted(per_metre))
    assert per_metre[0] == pytest.approx(per_metre[1])
    assert per_metre[-1] == pytest.approx(CONFIG.track.drift_sigma**2)
    assert per_metre[0] < 0.2 * per_metre[-1]
