"""An AprilTag on a wall, seen from forty degrees aside: the robot ends squarely before it.

The same over more seeds, with the first pose taken for the true one, and with a worse camera: `python -m benchmarks
tags`, figures in docs/measurements.md.
"""

from __future__ import annotations

import math

import pytest

from target_nav.app.paths import mission_path
from target_nav.app.virtual import RunResult, run_virtual
from target_nav.sim.arena import Arena, load_arena
from target_nav.utils.frames import wrap_angle

pytestmark = pytest.mark.slow

BEARING_LIMIT_RAD = math.radians(3.0)
SQUARE_LIMIT_RAD = math.radians(6.0)


def off_square_rad(arena: Arena, result: RunResult) -> float:
    """Between the robot's heading and the tag's inward normal."""
    assert arena.target is not None
    return abs(wrap_angle(result.trace[-1][3] - arena.target.yaw_rad - math.pi))


def ends_squarely(arena: Arena, result: RunResult) -> None:
    assert result.as_expected, result
    assert result.outcome == "succeeded"
    assert not result.collided
    assert result.bearing_error_rad is not None
    assert abs(result.bearing_error_rad) <= BEARING_LIMIT_RAD
    assert off_square_rad(arena, result) <= SQUARE_LIMIT_RAD


@pytest.mark.parametrize("seed", range(1, 11))
def test_it_ends_squarely_before_the_tag(seed: int) -> None:
    arena = load_arena("tag_on_wall")
    ends_squarely(arena, run_virtual(arena, mission_path("apriltag"), seed))


def test_so_it_does_with_rendered_pictures_and_the_real_detector() -> None:
    arena = load_arena("tag_on_wall")
    ends_squarely(arena, run_virtual(arena, mission_path("apriltag"), 1, pixels=True))
