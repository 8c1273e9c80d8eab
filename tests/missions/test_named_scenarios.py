"""Each complaint of users of comparable systems, and each weakness of the original, as a run that must not show it.

What each arena is about stands in its first lines and in `docs/campaigns.md`; here is what has to be so at the end.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from pathlib import Path

import pytest

from target_nav.app.paths import mission_path
from target_nav.app.virtual import RunResult, run_virtual
from target_nav.sim.arena import list_arenas, load_arena

# the longest is several minutes of virtual time, and CI shares its machine
pytestmark = [pytest.mark.slow, pytest.mark.timeout(300)]

DOCUMENT = Path(__file__).parents[2] / "docs" / "campaigns.md"
STOP_M, BEARING_RAD = 0.020, math.radians(3.0)

Claim = Callable[[RunResult], bool]


def exact(run: RunResult) -> bool:
    """The stop is within 20 mm and 3 degrees."""
    assert run.stop_error_m is not None
    assert run.bearing_error_rad is not None
    return abs(run.stop_error_m) <= STOP_M and abs(run.bearing_error_rad) <= BEARING_RAD


def goes_no_farther_than(way_m: float) -> Claim:
    return lambda run: run.path_m <= way_m and (run.bearing_error_rad is None or exact(run))


def never_turns_in_the_slot(run: RunResult) -> bool:
    return all(abs(yaw) < 0.2 for _, _, y_m, yaw in run.trace if y_m < -0.5)


def gives_a_reason(run: RunResult) -> bool:
    return run.outcome == "failed" and bool(run.reason)


def good(run: RunResult) -> bool:
    return True


CLAIMS: dict[str, Claim] = {
    "dead_band": exact,
    "wall_instead_of_pin": gives_a_reason,
    "lateral_miss": exact,
    "late_camera": exact,
    "circling": goes_no_farther_than(1.0),
    "table": exact,
    "edge_of_picture": goes_no_farther_than(1.5),
    "lost_on_the_way": exact,
    "boxed_in": gives_a_reason,
    "box_at_the_bearing": exact,
    "niche": exact,
    "wide_blind_zone": exact,
    "drop_outs": exact,
    "wrong_focal_length": exact,
    "slow_target": exact,
    "leaving_target": exact,
}
GOALS: dict[str, Claim] = {
    "goal_open_floor": goes_no_farther_than(3.5),
    "goal_behind_boxes": good,
    "goal_strafe": never_turns_in_the_slot,
    "goal_beside": goes_no_farther_than(1.0),
    "goal_dead_end": good,
    "goal_differential": good,
}
MISSIONS = {**dict.fromkeys(CLAIMS, "bowling_pin"), **dict.fromkeys(GOALS, "go_to_point")}


@pytest.mark.parametrize("arena", MISSIONS)
def test_the_complaint_is_not_ours(arena: str) -> None:
    run = run_virtual(load_arena(arena), mission_path(MISSIONS[arena]), seed=40)
    assert run.as_expected, run
    assert (CLAIMS | GOALS)[arena](run), run


def test_every_named_arena_is_tried_and_told_of() -> None:
    assert set(CLAIMS) == set(list_arenas("complaints"))
    assert set(GOALS) == set(list_arenas("goals"))
    text = DOCUMENT.read_text(encoding="utf-8")
    untold = [name for name in MISSIONS if f"`{name}`" not in text]
    assert not untold, f"docs/campaigns.md does not name {untold}"
