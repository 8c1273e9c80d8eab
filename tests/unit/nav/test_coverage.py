"""What the camera has seen of the floor, and what it would see from elsewhere."""

from __future__ import annotations

import math

import numpy as np
import pytest

from target_nav.config import CameraConfig
from target_nav.nav.coverage import Coverage
from target_nav.state.types import Pose2D
from tests.unit.nav.views import NO_POINTS, points, wall

HERE = points((0.0, 0.0))


def looked(coverage: Coverage, yaw_rad: float = 0.0, times: int = 3) -> None:
    for _ in range(times):
        coverage.update(Pose2D(yaw_rad=yaw_rad), NO_POINTS, 9.0)


def ahead_and_behind(coverage: Coverage) -> tuple[float, float]:
    area = coverage.unseen_by_ray_m2(HERE)[0]
    ahead = np.abs(coverage.ray_angles_rad) < 0.35
    behind = np.abs(coverage.ray_angles_rad) > math.pi - 0.35
    return float(area[ahead].sum()), float(area[behind].sum())


def known(range_m: float = 3.0) -> Coverage:
    """All round here is floor, and the camera has seen none of it."""
    coverage = Coverage(CameraConfig(), range_m)
    coverage.update(Pose2D(), NO_POINTS, 9.0)
    coverage.look_again(range_m)
    return coverage


def test_at_first_the_whole_disc_is_unseen() -> None:
    assert known().unseen_by_ray_m2(HERE).sum() == pytest.approx(math.pi * 9.0, rel=0.05)


def test_of_what_is_not_known_to_be_floor_only_the_first_metre_counts() -> None:
    coverage = Coverage(CameraConfig(), 3.0)
    assert coverage.unseen_by_ray_m2(HERE).sum() == pytest.approx(math.pi * (1.3**2 - 0.3**2), rel=0.1)
    coverage.update(Pose2D(), NO_POINTS, 1.5)
    assert coverage.known_m2 == pytest.approx(math.pi * 1.5**2, rel=0.1)
    coverage.look_again(3.0)
    coverage.update(Pose2D(), NO_POINTS, 3.0)
    assert coverage.known_m2 == pytest.approx(math.pi * 3.0**2, rel=0.1)


def test_between_the_returns_of_a_wall_at_a_slant_there_is_no_way_through() -> None:
    """From 0.3 m beside it beams of one degree meet a wall up to half a metre apart; cells alone would let through."""
    coverage = Coverage(CameraConfig(), 3.0)
    beams = np.radians(np.arange(6.0, 174.0, 1.0))
    slanting = np.column_stack([0.3 / np.tan(beams), np.full(len(beams), 0.3)])
    for _ in range(3):
        coverage.update(Pose2D(), slanting, 4.0)
    x, y = (axis.reshape(-1) for axis in np.meshgrid(np.arange(-2.5, 2.6, 0.1), np.arange(0.6, 2.0, 0.1)))
    assert not coverage.is_known_free(np.column_stack([x, y])).any()
    assert coverage.is_known_free(points((1.0, -1.0), (2.0, 0.1))).all()


def test_known_floor_that_comes_up_behind_is_hoped_for() -> None:
    coverage = Coverage(CameraConfig(), 3.0)
    coverage.update(Pose2D(), NO_POINTS, 1.0)
    before = float(coverage.unseen_by_ray_m2(HERE).sum())
    coverage.update(Pose2D(), NO_POINTS, 3.0)
    assert float(coverage.unseen_by_ray_m2(HERE).sum()) > before


def test_what_was_in_the_picture_often_enough_is_seen_and_no_more() -> None:
    coverage = known()
    before = ahead_and_behind(coverage)
    looked(coverage, times=2)
    assert ahead_and_behind(coverage) == before, "twice is not enough"
    looked(coverage, times=1)
    after = ahead_and_behind(coverage)
    assert after[0] == 0.0
    assert after[1] == before[1]


def test_nothing_is_seen_or_hoped_for_behind_a_wall() -> None:
    coverage = Coverage(CameraConfig(), 3.0)
    coverage.update(Pose2D(), wall(1.0, -3.0, 1.0, 3.0), 9.0)
    looked(coverage)
    area_from_behind = coverage.unseen_by_ray_m2(points((2.0, 0.0)))[0]
    assert area_from_behind[np.abs(coverage.ray_angles_rad) < 1.0].sum() > 3.0, "the far side is still unseen"
    reach = coverage.unseen_by_ray_m2(HERE)[0][np.abs(coverage.ray_angles_rad) < 0.2]
    assert reach.sum() < 0.05, "and from here nothing more can be seen of it"


def test_the_shadow_of_a_box_is_worth_going_for() -> None:
    coverage = Coverage(CameraConfig(), 3.0)
    for yaw in np.arange(0.0, 6.3, 0.3):
        for _ in range(3):
            coverage.update(Pose2D(yaw_rad=float(yaw)), wall(1.0, -0.2, 1.0, 0.2), 9.0)
    from_the_side, from_here = coverage.unseen_by_ray_m2(points((1.6, 1.2), (0.0, 0.0))).sum(axis=1)
    assert from_here < 0.1
    assert from_the_side > 0.4


def test_looking_again_begins_anew_nearer() -> None:
    coverage = Coverage(CameraConfig(), 3.0)
    looked(coverage)
    coverage.look_again(1.5)
    assert coverage.unseen_by_ray_m2(HERE).sum() == pytest.approx(math.pi * (1.5**2 - 0.3**2), rel=0.08)


def test_settled_is_seen_all_round() -> None:
    coverage = Coverage(CameraConfig(), 3.0)
    coverage.settle(Pose2D())
    assert coverage.unseen_by_ray_m2(HERE).sum() < 0.3


def test_known_free_is_what_the_lidar_looked_at() -> None:
    coverage = Coverage(CameraConfig(), 3.0)
    assert not coverage.is_known_free(points((-1.0, 0.0)))[0]
    coverage.update(Pose2D(), wall(1.0, -1.0, 1.0, 1.0), 9.0)
    assert coverage.is_known_free(points((-1.0, 0.0), (1.0, 0.0), (2.0, 0.0))).tolist() == [
        True,
        False,
        False,
    ]


def test_it_lies_round_where_it_began() -> None:
    coverage = Coverage(CameraConfig(), 3.0)
    coverage.begin(Pose2D(50.0, -20.0, 1.0))
    coverage.update(Pose2D(50.0, -20.0, 1.0), NO_POINTS, 9.0)
    assert coverage.is_known_free(points((51.0, -20.0)))[0]


def test_beyond_the_reach_of_the_view_nothing_counts() -> None:
    coverage = Coverage(CameraConfig(), 3.0)
    for _ in range(3):
        coverage.update(Pose2D(), NO_POINTS, 1.0)
    assert coverage.is_known_free(points((-0.8, 0.0), (-1.5, 0.0))).tolist() == [True, False]
    assert ahead_and_behind(coverage)[0] == 0.0, "what could be seen from here was"
    coverage.update(Pose2D(), NO_POINTS, 3.0)
    assert ahead_and_behind(coverage)[0] > 1.0, "but what lies farther off was not"


def test_single_cells_left_over_are_not_worth_going_for() -> None:
    coverage = known()
    coverage.settle(Pose2D())
    for x in np.arange(-2.0, 2.1, 0.4):
        coverage._looks[100, 120 + round(x / 0.1)] = 0
    coverage._missing = None
    assert coverage.unseen_by_ray_m2(HERE).sum() < 0.05
    coverage._looks[100:102, 120:122] = 0
    coverage._missing = None
    assert coverage.unseen_by_ray_m2(HERE).sum() > 0.02


def test_floor_in_front_of_a_walls_old_place_is_none_behind_its_new_one() -> None:
    """Drift puts a wall nearer than it was; what was seen before it has become its inside."""
    coverage = Coverage(CameraConfig(), 3.0)
    coverage.update(Pose2D(), wall(1.8, -2.0, 1.8, 2.0), 4.0)
    between = points((1.6, 0.0), (1.6, 0.4), (-1.5, 0.0))
    assert coverage.is_known_free(between).tolist() == [True, True, True]
    coverage.update(Pose2D(), wall(1.4, -2.0, 1.4, 2.0), 4.0)
    assert coverage.is_known_free(between).tolist() == [False, False, True]
    coverage.update(Pose2D(2.5, 0.0), wall(1.4, -2.0, 1.4, 2.0), 4.0)
    assert coverage.is_known_free(between).tolist() == [True, True, True], "seen from there it is floor again"
