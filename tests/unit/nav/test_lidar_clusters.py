"""Clusters: narrow and free-standing is the target's; everything else is left alone."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from target_nav.nav.lidar_clusters import PolarView, TargetFix, find_clusters, polar_view, target_fixes
from target_nav.nav.scan_points import deskewed_points_in_odom
from tests.unit.nav.scripted_world import Drive, Pose2D, Sensors, Twist2D, World, box

WIDTH_M = 0.08
Point = tuple[float, float]


def view_of(world: World, stamp_s: float = 10.5) -> PolarView:
    scan = world.scan(stamp_s)
    points = deskewed_points_in_odom(
        scan, world.poses(stamp_s + 0.25, since_s=stamp_s - 1.0), world.config.lidar
    )
    assert points is not None
    return polar_view(points)


def fixes_near(world: World, x_m: float, y_m: float, gate_m: float = 0.3) -> list[TargetFix]:
    found = target_fixes(view_of(world), [(x_m, y_m)], gate_m, WIDTH_M)
    return [fix for fix in found if not fix.doubtful]


def error_m(fix: TargetFix, x_m: float, y_m: float) -> float:
    return math.hypot(fix.x_m - x_m, fix.y_m - y_m)


@settings(max_examples=60, deadline=None)
@given(st.floats(0.25, 2.0), st.floats(-math.pi, math.pi))
def test_a_lone_pin_is_found_at_its_centre_in_every_direction(range_m: float, bearing: float) -> None:
    x_m, y_m = range_m * math.cos(bearing), range_m * math.sin(bearing)
    (fix,) = fixes_near(World(pins=[(x_m, y_m)]), x_m, y_m)
    assert error_m(fix, x_m, y_m) < 0.010 + 0.006 * range_m


def test_its_covariance_says_how_far_off_it_may_be() -> None:
    """Normalised error squared over a few hundred noisy scans: 2 if it were exact, less if careful."""
    squares = []
    for seed in range(150):
        rng = np.random.default_rng(seed)
        range_m, bearing = rng.uniform(0.3, 2.2), rng.uniform(-math.pi, math.pi)
        x_m, y_m = range_m * math.cos(bearing), range_m * math.sin(bearing)
        for fix in fixes_near(World(pins=[(x_m, y_m)], sensors=Sensors(seed=seed)), x_m, y_m):
            off = np.array([fix.x_m - x_m, fix.y_m - y_m])
            squares.append(off @ np.linalg.solve(np.array(fix.covariance_m2).reshape(2, 2), off))
    assert len(squares) > 110
    assert 0.3 < np.mean(squares) < 2.5
    assert np.mean(np.array(squares) > 13.8) < 0.02


def test_a_pin_is_found_while_the_robot_turns_and_the_scan_is_skewed() -> None:
    world = World(pins=[(1.5, 0.2)], drive=Drive(Pose2D(), ((5.0, Twist2D(0.1, 0.0, 0.5)),)))
    (fix,) = fixes_near(world, 1.5, 0.2)
    assert error_m(fix, 1.5, 0.2) < 0.02


BESIDE = {
    "a box is too wide": (World(walls=box(1.2, 0.0, 0.2, 0.25)), (1.2, 0.0)),
    "a wall ahead": (World(walls=[(1.2, -2.0, 1.2, 2.0)]), (1.2, 0.0)),
    "a wall along the line of sight": (World(walls=[(-2.0, -0.25, 4.0, -0.25)]), (1.2, -0.25)),
    "a corner of the room": (World(walls=[(1.5, -2.0, 1.5, 0.3), (1.5, 0.3, -2.0, 0.3)]), (1.5, 0.3)),
    "a corner of a box": (World(walls=box(1.5, 0.5, 0.4, 0.4)), (1.3, 0.3)),
    "a pin that touches a box": (World(pins=[(1.5, 0.0)], walls=box(1.5, 0.142, 0.2, 0.2)), (1.5, 0.0)),
    "a pin half hidden by a box": (World(pins=[(1.8, 0.0)], walls=box(1.0, 0.10, 0.2, 0.2)), (1.8, 0.0)),
    "a pin behind a box": (World(pins=[(1.8, 0.0)], walls=box(1.5, 0.0, 0.2, 0.4)), (1.8, 0.0)),
    "a box twice as wide": (World(walls=box(1.5, 0.0, 0.16, 0.16)), (1.45, 0.0)),
    "a bin, round but thick": (World(circles=[(1.5, 0.0, 0.15)]), (1.5, 0.0)),
    "nothing": (World(), (1.5, 0.0)),
}


@pytest.mark.parametrize("name", BESIDE)
def test_no_fix_from(name: str) -> None:
    world, (x_m, y_m) = BESIDE[name]
    assert fixes_near(world, x_m, y_m) == []


@pytest.mark.parametrize(
    "walls",
    [
        [(1.62, -2.0, 1.62, 2.0)],
        [(-2.0, 0.15, 4.0, 0.15)],
        box(1.5, 0.25, 0.2, 0.2),
        box(1.0, 0.25, 0.2, 0.2),
        box(2.0, 0.0, 0.2, 0.5),
    ],
    ids=[
        "wall 12 cm behind",
        "wall 15 cm beside",
        "box 11 cm beside",
        "box beside and in front",
        "box behind",
    ],
)
def test_a_pin_near_something_else_gives_its_own_range(
    walls: list[tuple[float, float, float, float]],
) -> None:
    (fix,) = fixes_near(World(pins=[(1.5, 0.0)], walls=walls), 1.5, 0.0)
    assert error_m(fix, 1.5, 0.0) < 0.02


@settings(max_examples=40, deadline=None)
@given(st.floats(0.4, 3.0), st.floats(0.2, 1.4), st.integers(0, 10_000))
def test_a_wall_full_of_holes_is_no_forest_of_pins(distance_m: float, angle: float, seed: int) -> None:
    c, s = math.cos(angle), math.sin(angle)
    foot = (distance_m * c, distance_m * s)
    wall = (foot[0] - 5 * s, foot[1] + 5 * c, foot[0] + 5 * s, foot[1] - 5 * c)
    world = World(walls=[wall], sensors=Sensors(seed=seed, dropouts=1.5))
    assert len(fixes_near(world, *foot, gate_m=0.5)) <= 1


def view_with(returns: dict[int, float]) -> PolarView:
    """The view of a still robot with a beam a degree, beam 0 straight ahead, and nothing but these returns."""
    beams = np.array(sorted(returns))
    ranges = np.array([returns[beam] for beam in beams.tolist()])
    return PolarView(0.0, 0.0, 10.0, math.radians(1.0), ranges, np.radians(beams.astype(float)))


def test_a_wall_of_which_only_every_fourth_beam_comes_back_is_no_row_of_pins() -> None:
    wall = view_with(dict.fromkeys(range(-40, 41, 4), 2.0))
    assert len(find_clusters(wall)) == 21
    assert all(fix.doubtful for fix in target_fixes(wall, [(2.04, 0.0)], 0.5, WIDTH_M))
    alone = view_with({0: 2.0})
    assert [fix.doubtful for fix in target_fixes(alone, [(2.04, 0.0)], 0.5, WIDTH_M)] == [False]


def test_one_return_where_a_pin_would_fill_seven_beams_is_no_pin() -> None:
    assert target_fixes(view_with({0: 0.6}), [(0.64, 0.0)], 0.3, WIDTH_M) == []
    assert target_fixes(view_with({0: 0.6, 1: 0.6, 2: 0.6}), [(0.64, 0.0)], 0.3, WIDTH_M) != []


def test_a_pin_too_far_off_to_fill_two_beams_is_left_to_the_camera() -> None:
    assert fixes_near(World(pins=[(2.2, 0.0)]), 2.2, 0.0) != []
    assert fixes_near(World(pins=[(2.5, 0.0)]), 2.5, 0.0) == []


def test_half_a_pin_may_be_either_half() -> None:
    """Of a pin that fills beams -3 to 3 only the left half came back: its centre is off, and the fix knows."""
    whole = {beam: 0.64 - math.sqrt(0.04**2 - (0.64 * math.radians(beam)) ** 2) for beam in range(-3, 4)}
    (full,) = target_fixes(view_with(whole), [(0.64, 0.0)], 0.3, WIDTH_M)
    (half,) = target_fixes(view_with({b: r for b, r in whole.items() if b > 0}), [(0.64, 0.0)], 0.3, WIDTH_M)
    assert abs(full.y_m) < 0.001
    assert half.y_m > 0.015
    assert half.y_m < 2.0 * math.sqrt(half.covariance_m2[3])
    assert half.covariance_m2[3] > 1.5 * full.covariance_m2[3]


def test_within_its_slack_a_fix_may_be_where_one_likes_and_no_farther() -> None:
    whole = {beam: 0.64 - math.sqrt(0.04**2 - (0.64 * math.radians(beam)) ** 2) for beam in range(-3, 4)}
    (half,) = target_fixes(view_with({b: r for b, r in whole.items() if b > 0}), [(0.64, 0.0)], 0.3, WIDTH_M)
    assert half.nearest_to(half.x_m, half.y_m) == pytest.approx((half.x_m, half.y_m))
    assert math.dist(half.nearest_to(0.64, 0.0), (0.64, 0.0)) < math.dist((half.x_m, half.y_m), (0.64, 0.0))
    for side in (-1.0, 1.0):
        x_m, y_m = half.nearest_to(0.64, side)
        assert math.dist((x_m, y_m), (half.x_m, half.y_m)) == pytest.approx(half.slack_m)
        assert (y_m - half.y_m) * side > 0.0


def test_a_wall_behind_does_not_make_a_pin_doubtful() -> None:
    world = World(pins=[(1.5, 0.0)], walls=[(1.62, -2.0, 1.62, 2.0)])
    found = target_fixes(view_of(world), [(1.5, 0.0)], 0.3, WIDTH_M)
    assert [fix.doubtful for fix in found] == [False]


def test_nor_does_a_wall_that_ends_beside_it() -> None:
    world = World(pins=[(1.5, 0.0)], walls=[(1.62, 0.06, 1.62, 0.5)])
    found = target_fixes(view_of(world), [(1.5, 0.0)], 0.4, WIDTH_M)
    assert [fix.doubtful for fix in found] == [False]


def test_of_a_pin_and_a_post_that_melt_into_one_thing_every_part_is_doubtful() -> None:
    world = World(pins=[(1.5, 0.0)], circles=[(1.5, 0.09, 0.03)])
    found = target_fixes(view_of(world), [(1.5, 0.0)], 0.3, WIDTH_M)
    assert len(found) > 3
    assert all(fix.doubtful for fix in found)
    assert any(error_m(fix, 1.5, 0.0) < 0.03 for fix in found)


def test_what_is_left_of_a_thing_behind_another_is_doubtful() -> None:
    world = World(pins=[(1.8, 0.0)], walls=box(1.0, 0.10, 0.2, 0.2))
    found = target_fixes(view_of(world), [(1.8, 0.0)], 0.3, WIDTH_M)
    assert [fix.doubtful for fix in found] == [True]


def test_two_pins_are_two() -> None:
    assert len(fixes_near(World(pins=[(1.0, 0.12), (1.0, -0.12)]), 1.0, 0.0)) == 2


def test_clusters_run_on_across_the_end_of_the_circle() -> None:
    world = World(pins=[(-1.0, 0.0)])
    clusters = find_clusters(view_of(world))
    assert len(clusters) == 1
    start, length = clusters[0]
    assert length >= 4
    assert start > 0


def test_every_return_is_in_exactly_one_cluster() -> None:
    world = World(
        pins=[(1.0, 0.3)], walls=box(0.0, -1.0, 0.5, 0.3), circles=[(-1.0, 0.5, 0.1)], sensors=Sensors(seed=4)
    )
    view = view_of(world)
    members = np.concatenate(
        [(start + np.arange(n)) % len(view.ranges_m) for start, n in find_clusters(view)]
    )
    assert sorted(members.tolist()) == list(range(len(view.ranges_m)))


def test_an_empty_scan_has_no_clusters() -> None:
    view = view_of(World())
    assert len(find_clusters(view)) == 0
    assert target_fixes(view, [(1.0, 0.0)], 1.0, WIDTH_M) == []
    assert view.nearest_between_m(0.0, 0.1) == math.inf


def test_the_nearest_return_in_a_direction() -> None:
    view = view_of(World(walls=[(-1.0, -5.0, -1.0, 5.0)], pins=[(-0.5, 0.0)]))
    assert view.nearest_between_m(math.pi, 0.05) == pytest.approx(0.46, abs=0.01)
    assert view.nearest_between_m(-math.pi + 0.3, 0.05) == pytest.approx(1.03, abs=0.02)
    assert view.nearest_between_m(0.0, 0.5) == math.inf
