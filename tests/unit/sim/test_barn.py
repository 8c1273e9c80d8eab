"""The BARN set's worlds: read from its files, scaled to a robot, and scored as the set does.

What needs the set's data is skipped where they are not: they are no part of the project.
"""

from __future__ import annotations

import gzip
import math
import os
from pathlib import Path

import pytest

from target_nav.config import Config
from target_nav.errors import ConfigError
from target_nav.sim.arena import load_arena
from target_nav.sim.arena_checks import geometry_problems
from target_nav.sim.barn import (
    CYLINDERS,
    JACKAL,
    SUMMARY,
    BarnName,
    barn_arena,
    barn_score,
    optimal_time_s,
    read_barn,
    scale_for,
)

DATA = Path(os.environ.get("TARGET_NAV_BARN", Path(__file__).parents[3].parent / "shared" / "data" / "barn"))
needs_data = pytest.mark.skipif(
    not (DATA / SUMMARY).exists(), reason=f"the BARN set is not at {DATA}; set TARGET_NAV_BARN to its folder"
)


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    """Two small worlds in the set's format."""
    rows = "# all radius 0.075; row: world,x,y\n3,-1.5,6.0\n3,-3.0,7.5\n8,-2.25,8.0\n"
    (tmp_path / CYLINDERS).write_bytes(gzip.compress(rows.encode()))
    summary = "world,n_cyl,ref_path_len_m,widest_clearance_m\n3,2,10.5,0.9\n8,1,10.2,0.8\n"
    (tmp_path / SUMMARY).write_text(summary)
    return tmp_path


def test_worlds_are_read_by_index(folder: Path) -> None:
    worlds = read_barn(folder)
    assert [(w.index, len(w.cylinders_m), w.path_m) for w in worlds] == [(3, 2, 10.5), (8, 1, 10.2)]


def test_a_world_at_the_sets_scale_is_ten_metres_from_start_to_goal(folder: Path) -> None:
    arena = load_arena(f"barn:jackal:3:{folder}")
    assert arena.goal is not None
    assert math.dist((arena.robot.x_m, arena.robot.y_m), (arena.goal.x_m, arena.goal.y_m)) == 10.0
    assert arena.config.goal.x_m == pytest.approx(10.0)
    assert arena.config.goal.y_m == pytest.approx(0.0)
    assert arena.config.goal.within_m < arena.goal.radius_m == 1.0
    assert arena.time_limit_s == 100.0
    assert (arena.config.lidar.beams, arena.config.lidar.rate_hz) == (720, 40.0)
    assert not list(geometry_problems(arena))


def test_for_another_robot_everything_is_scaled_by_its_size(folder: Path) -> None:
    config = Config()
    scale = scale_for(config)
    assert scale == pytest.approx(math.hypot(0.15, 0.14) / 0.333)
    arena = barn_arena(read_barn(folder)[0], config, scale)
    assert arena.obstacles[0].radius_m == pytest.approx(0.075 * scale)  # type: ignore[union-attr]
    assert arena.config.goal.x_m == pytest.approx(10.0 * scale)
    assert scale_for(Config().override(JACKAL)) == 1.0


@pytest.mark.parametrize(
    ("time_s", "score"),
    [(None, 0.0), (1.0, 0.5), (10.0, 0.5), (12.5, 0.4), (20.0, 0.25), (40.0, 0.125), (90.0, 0.125)],
)
def test_the_score_is_the_sets(time_s: float | None, score: float) -> None:
    assert barn_score(time_s, 5.0) == pytest.approx(score)


def test_the_optimal_time_is_the_reference_path_at_top_speed(folder: Path) -> None:
    assert optimal_time_s(BarnName("jackal", 3, folder)) == pytest.approx(10.5 / 2.0)


@pytest.mark.parametrize("text", ["barn", "barn:jackal:3", "barn:tank:3:/x", "barn:jackal:x:/y"])
def test_other_names_are_no_worlds(text: str) -> None:
    assert BarnName.parse(text) is None


def test_what_is_missing_or_wrong_is_said(folder: Path, tmp_path: Path) -> None:
    with pytest.raises(ConfigError, match=r"has no world 4; it has 3, 8"):
        load_arena(f"barn:jackal:4:{folder}")
    (folder / SUMMARY).write_text("world,ref_path_len_m\n3,far\n")
    with pytest.raises(ConfigError, match="not the set's numbers"):
        read_barn(folder)
    (folder / SUMMARY).unlink()
    with pytest.raises(ConfigError, match=f"must hold {CYLINDERS} and {SUMMARY}"):
        read_barn(folder)


@needs_data
@pytest.mark.parametrize("robot", ["jackal", "own"])
def test_all_worlds_of_the_set_are_arenas_without_a_fault(robot: str) -> None:
    worlds = read_barn(DATA)
    assert len(worlds) == 100
    for world in worlds[::9]:
        arena = load_arena(f"barn:{robot}:{world.index}:{DATA}")
        assert not list(geometry_problems(arena))
        assert len(arena.obstacles) == len(world.cylinders_m)
