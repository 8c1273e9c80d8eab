"""Scenarios carried out: which expectations are met, and what is told of those that are not."""

from __future__ import annotations

from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from target_nav.mission.scenario_checks import trace_fits
from target_nav.mission.scenario_file import read_scenarios
from target_nav.mission.scenario_run import ScenarioError, run_scenario
from tests.unit.mission.scenarios import one, run, write

SCRIPT = """
script:
  - {at: 1, say: GO}
  - {at: 2, track: {range_m: 2.0}}
lasts_s: 3
"""


@pytest.mark.parametrize(
    "met",
    [
        "{at: 0, leaf: Idle}",
        "{at: 0.97, state: SEARCHING}",  # between two ticks: the next one
        "{at: 1, state: SEARCHING, leaf: TurnSearch, moves: true, outcome: none}",
        "{from: 0, to: 0.95, leaf: Idle, moves: false, reason: waiting for GO}",
        "{from: 2.1, state: NAVIGATING}",
        "{by: 2.5, state: NAVIGATING}",
        "{after: 1, by: 1, leaf: TurnSearch}",
        "{after: 2, within_ticks: 2, leaf: NavigateToTarget}",
        "{after: 2, within_s: 0.1, leaf: NavigateToTarget}",
        "{at: end, leaf: '*/Mission/Navigate*'}",
        "{at: end, leaf: Nav*}",
        "{at: 1, status: {Mission: RUNNING, MissionRequested: SUCCESS, Idle: INVALID, Arrived: INVALID}}",
        "{at: 1, message: {TurnSearch: 'turned * deg'}}",
        "{at: end, board: {track: {range_m: {below: 2.0}}, request: {state: NAVIGATING, near_target: false}}}",
        "{at: 0, board: {/why: none, requested: false, pose_in_odom: {yaw_rad: 0}}}",
        "{from: 0, not: {state: ARRIVED}}",
        "{by: 0.5, not: {state: ARRIVED, leaf: Arrived}}",
        "{states: [IDLE, SEARCHING, NAVIGATING]}",
        "{states: [..., NAVIGATING]}",
        "{from: 1, to: 1.9, states: [SEARCHING]}",
        "{leaves: [Idle, TurnSearch, NavigateToTarget]}",
        "{leaves: [Idle, ..., Navigate*]}",
    ],
)
def test_expectations_that_are_met(tmp_path: Path, met: str) -> None:
    result = run(tmp_path, f"{SCRIPT}expect:\n  - {met}")
    assert result.passed, result.explain()


@pytest.mark.parametrize(
    ("missed", "expected", "got"),
    [
        (
            "{at: 0.5, leaf: TurnSearch}",
            "at 0.5 s: leaf is TurnSearch",
            ["at 0.50 s leaf is Idle, not TurnSearch"],
        ),
        (
            "{from: 0, state: IDLE, moves: false}",
            "all the time from 0 s to the end: state is IDLE, the robot is standing",
            ["at 1.00 s state is SEARCHING, not IDLE", "at 1.00 s the robot is moving, not standing"],
        ),
        (
            "{by: 1.9, state: NAVIGATING}",
            "at some time from 0 to 1.9 s: state is NAVIGATING",
            ["0.00 to 0.95 s: state is IDLE", "1.00 to 1.90 s: state is SEARCHING"],
        ),
        (
            "{after: 2, within_ticks: 1, leaf: Arrived}",
            "within 1 tick from 2 s on: leaf is Arrived",
            ["2.00 s: leaf is NavigateToTarget"],
        ),
        (
            "{at: 0, board: {/why: not found}}",
            "at 0 s: /why is 'not found'",
            ["at 0.00 s /why is None, not 'not found'"],
        ),
        (
            "{at: 1, status: {Mission: SUCCESS}}",
            "at 1 s: status of Mission is 'SUCCESS'",
            ["at 1.00 s status of Mission is RUNNING, not 'SUCCESS'"],
        ),
        (
            "{at: 0, not: {leaf: Idle, state: IDLE}}",
            "at 0 s: not (leaf is Idle and state is IDLE)",
            ["at 0.00 s leaf is Idle and state is IDLE"],
        ),
        (
            "{states: [IDLE, SPIRAL_SEARCH, NAVIGATING]}",
            "in the whole scenario: states IDLE, SPIRAL_SEARCH, NAVIGATING",
            ["  IDLE", "- SPIRAL_SEARCH", "+ SEARCHING", "  NAVIGATING"],
        ),
    ],
)
def test_expectations_that_are_missed_say_what_came_instead(
    tmp_path: Path, missed: str, expected: str, got: list[str]
) -> None:
    result = run(tmp_path, f"{SCRIPT}expect:\n  - {missed}")
    (failure,) = result.failures
    assert failure.expected == expected
    assert list(failure.got) == got
    assert str(failure.place) == f"{tmp_path}/scenarios/some.yaml:9"


def test_every_missed_expectation_is_told_and_what_happened_below(tmp_path: Path) -> None:
    result = run(tmp_path, f"{SCRIPT}expect:\n  - {{at: 0, leaf: Arrived}}\n  - {{at: 1, leaf: Arrived}}")
    assert len(result.failures) == 2
    text = result.explain()
    places = [
        text.index(part) for part in ("at 0.00 s leaf is Idle", "at 1.00 s leaf is Turn", "what happened")
    ]
    assert places == sorted(places)
    rows = [" ".join(row.split()) for row in result.timeline]
    assert rows[0] == "0.00 s IDLE Idle waiting for GO"
    assert rows[1] == "1.00 s SEARCHING TurnSearch turned 0 deg"
    assert [row.split()[3] for row in rows] == ["Idle", "TurnSearch", "NavigateToTarget"]


def test_a_scenario_lasts_to_the_last_time_that_it_names(tmp_path: Path) -> None:
    assert run(tmp_path, "expect:\n  - {by: 0.5, leaf: Idle}\n  - {at: 1.5, leaf: Idle}").ticks == 31


def test_the_same_scenario_twice_does_the_same(tmp_path: Path) -> None:
    scenario = one(tmp_path, f"{SCRIPT}expect:\n  - {{at: 0, leaf: Arrived}}")
    assert run_scenario(scenario).explain() == run_scenario(scenario).explain()


def test_defaults_hold_for_every_scenario_and_its_own_words_come_first(tmp_path: Path) -> None:
    top = """\
    defaults:
      robot: stands
      config: {search.time_limit_s: 1, search.yaw_rate_radps: 0.2}
      mocks: {TurnSearch: {returns: SUCCESS, after_s: 1}, NavigateToTarget: RUNNING}
      board: {requested: true, scan_age_s: 0.4}
    """
    path = write(
        tmp_path,
        """
        - name: as the file says
          expect: [{at: 2, leaf: NavigateToTarget, board: {scan_age_s: 0.4, pose_in_odom: {yaw_rad: 0}}}]
        - name: as it says itself
          robot: drives
          config: {search.time_limit_s: 2}
          mocks: {TurnSearch: FAILURE}
          board: {scan_age_s: 0.2}
          expect: [{at: 0, status: {TurnSearch: FAILURE}, board: {scan_age_s: 0.2}}, {at: 1, outcome: failed}]
        """,
        top,
    )
    results = [run_scenario(scenario) for scenario in read_scenarios(path)]
    assert [result.explain() for result in results if not result.passed] == []
    assert dict(results[1].scenario.config) == {"search.time_limit_s": 2, "search.yaw_rate_radps": 0.2}
    assert [result.scenario.drives for result in results] == [False, True]


def test_changes_are_in_force_in_the_first_tick_at_or_after_their_time(tmp_path: Path) -> None:
    parts = "script: [{at: 0.98, say: GO}]\nexpect: [{at: 0.95, state: IDLE}, {at: 1.0, state: SEARCHING}]"
    assert run(tmp_path, parts).passed


def test_what_does_not_fit_the_mission_is_told_with_its_place(tmp_path: Path) -> None:
    scenario = one(
        tmp_path,
        """
        config: {search.tim: 3}
        mocks:
          TurnSerch: SUCCESS
        script:
          - {at: 1, track: {x_m: 1}}
        expect:
          - {at: 2, leaf: NavigatToTarget}
          - {at: 2, board: {/wy: x}}
        """,
    )
    with pytest.raises(ScenarioError) as told:
        run_scenario(scenario)
    path = f"{tmp_path}/scenarios/some.yaml"
    assert str(told.value).splitlines() == [
        f"{path}:3: error: it: config: unknown key 'search.tim'; did you mean 'search.time_limit_s'?",
        f"{path}:6: error: it: no behaviour of the mission is 'TurnSerch'; did you mean \"TurnSearch\"?",
        f"{path}:8: error: it: track is new; it must say where: x_m and y_m, or range_m and bearing_rad",
        f"{path}:10: error: it: no behaviour of the mission is 'NavigatToTarget'; did you mean \"NavigateToTarget\"?",
        f"{path}:11: error: it: the mission has no blackboard entry '/wy'; did you mean \"/why\"?",
    ]


def test_a_mission_with_errors_is_told_with_the_missions_own_places(tmp_path: Path) -> None:
    scenario = one(tmp_path, "expect: [{at: 1, leaf: Idle}]")
    text = scenario.mission.read_text(encoding="utf-8")
    scenario.mission.write_text(text.replace("<Idle/>", "<Idel/>"), encoding="utf-8")
    with pytest.raises(ScenarioError, match=r"mission\.xml:\d+:\d+: error: unknown node Idel"):
        run_scenario(scenario)


@given(st.lists(st.sampled_from("ab"), max_size=6))
def test_a_trace_fits_itself_and_whatever_is_left_out_with_dots(names: list[str]) -> None:
    assert trace_fits(names, names, str.__eq__)
    assert trace_fits(["..."], names, str.__eq__)
    for cut in range(len(names) + 1):
        assert trace_fits([*names[:cut], "...", *names[cut:]], names, str.__eq__)
        assert trace_fits(["...", *names[cut:]], names, str.__eq__)
    assert not trace_fits([*names, "a"], names, str.__eq__)
    assert not trace_fits(["...", "c", "..."], names, str.__eq__)
