"""Generated arenas: the same ones from the same seed, as many of each kind and level, each of them possible."""

from __future__ import annotations

from collections import Counter
from pathlib import Path

import pytest

from target_nav.config import Config
from target_nav.errors import ConfigError
from target_nav.sim.arena import load_arena
from target_nav.sim.arena_checks import geometry_problems
from target_nav.sim.arena_types import NOT_FOUND
from target_nav.sim.arena_writer import write_arena
from target_nav.sim.generator import (
    BOX_JITTER,
    FOCAL_ERROR,
    KIND_NAMES,
    LEVELS,
    GeneratedName,
    generate_arena,
    kind_and_level,
)
from target_nav.sim.solvable import Solver

CONFIG = Config()
ROUND = len(KIND_NAMES) * len(LEVELS)


def test_a_round_has_each_kind_at_each_level_once() -> None:
    assert Counter(kind_and_level(number) for number in range(ROUND)) == Counter(
        {(kind, level): 1 for kind in KIND_NAMES for level in LEVELS}
    )


@pytest.mark.parametrize("number", range(0, ROUND, 5))
def test_an_arena_is_a_function_of_its_name_and_can_be_solved(number: int) -> None:
    arena = generate_arena(GeneratedName(11, number), CONFIG)
    assert arena == generate_arena(GeneratedName(11, number), CONFIG) == load_arena(f"generated_11_{number}")
    assert (arena.kind, arena.level) == kind_and_level(number)
    assert not list(geometry_problems(arena))
    assert Solver(arena).is_solvable()
    assert (arena.expect == NOT_FOUND) == (arena.kind == "no_pin") == (arena.target is None)


def test_other_seeds_and_other_numbers_give_other_arenas() -> None:
    arenas = [generate_arena(GeneratedName(seed, number), CONFIG) for seed in (1, 2) for number in (0, ROUND)]
    assert len({arena.robot for arena in arenas}) == 4


def test_a_file_holds_the_very_same_arena(tmp_path: Path) -> None:
    for number in (2, 6, 17, 33, 46):
        arena = generate_arena(GeneratedName(3, number), CONFIG)
        assert load_arena(write_arena(arena, tmp_path, CONFIG)) == arena


def test_what_the_sensors_get_wrong_is_drawn_within_what_was_measured() -> None:
    configs = [generate_arena(GeneratedName(9, number), CONFIG).config for number in range(12)]
    assert len({config.camera.focal_error for config in configs}) == 12
    assert all(abs(config.camera.focal_error) <= FOCAL_ERROR for config in configs)
    assert all(BOX_JITTER[0] <= config.camera.box_jitter <= BOX_JITTER[1] for config in configs)
    assert all(config.lidar.noise_scale == config.lidar.dropout_scale == 1.0 for config in configs)


def test_a_body_that_fits_nowhere_is_refused() -> None:
    wide = CONFIG.override({"robot.half_width_m": 1.9, "robot.front_m": 1.9, "robot.rear_m": 1.9})
    with pytest.raises(ConfigError, match=r"generated_1_0: none of 500 drawn arenas of kind 'open'"):
        generate_arena(GeneratedName(1, 0), wide)


@pytest.mark.parametrize("text", ["generated_1", "generated_-1_2", "generated_1_2.yaml", "xgenerated_1_2"])
def test_what_is_no_generated_name_is_none(text: str) -> None:
    assert GeneratedName.parse(text) is None
