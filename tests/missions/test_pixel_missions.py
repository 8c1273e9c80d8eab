"""Whole missions that look at rendered pictures: the network finds the pin, a colour finds a ball.

A small share of the campaign in docs/model.md, which has a hundred missions.
"""

from __future__ import annotations

import shutil
from dataclasses import replace
from pathlib import Path

import pytest

from target_nav.app.paths import mission_path
from target_nav.app.virtual import RunResult, run_virtual
from target_nav.sim.arena import Arena, PlacedObject, load_arena

pytestmark = pytest.mark.slow

OWN_TARGET = '<SetTarget class="bowling_pin" height_m="0.28" width_m="0.08" lidar_width_m="0.032"/>'


def look_for(folder: Path, target: str) -> Path:
    """The reference mission with another target."""
    trees = mission_path("bowling_pin").parent
    shutil.copytree(trees / "subtrees", folder / "subtrees")
    text = (trees / "bowling_pin.xml").read_text(encoding="utf-8")
    assert OWN_TARGET in text
    mission = folder / "other.xml"
    mission.write_text(text.replace(OWN_TARGET, target), encoding="utf-8")
    return mission


def ball_room() -> Arena:
    room = load_arena("open_floor")
    assert room.target is not None
    return replace(room, name="ball", target=PlacedObject("ball", room.target.x_m, room.target.y_m))


@pytest.mark.parametrize(("arena", "seed"), [("open_floor", 1), ("decoys", 2)])
def test_the_network_finds_the_pin_in_rendered_rooms(arena: str, seed: int) -> None:
    result: RunResult = run_virtual(load_arena(arena), mission_path("bowling_pin"), seed, pixels=True)
    assert result.as_expected, result
    assert not result.collided


def test_a_mission_names_another_detector_and_finds_a_ball_by_its_colour(tmp_path: Path) -> None:
    target = '<SetTarget class="orange" detector="hsv" height_m="0.22" width_m="0.22"/>'
    result = run_virtual(ball_room(), look_for(tmp_path, target), 1, pixels=True)
    assert result.as_expected, result
    assert not result.collided


def test_pixels_give_the_same_run_for_the_same_seed() -> None:
    short = replace(load_arena("open_floor"), time_limit_s=4.0)
    first, again = (
        run_virtual(short, mission_path("bowling_pin"), 5, pixels=True).as_json(True) for _ in range(2)
    )
    assert first == again
