"""A target that moves: rays, boxes, clearances and the judge all know where it is by now."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

from target_nav.config import Config
from target_nav.sim.arena import Arena, load_arena
from target_nav.sim.arena_types import Bounds, PlacedObject
from target_nav.sim.simulation import Simulation
from target_nav.state.types import Pose2D

PERFECT = Config().override(
    {
        "lidar.noise_scale": 0.0,
        "lidar.dropout_scale": 0.0,
        "lidar.true_profile": False,
        "lidar.lost_scan_probability": 0.0,
        "camera.noise_scale": 0.0,
        "camera.miss_probability": 0.0,
        "camera.false_rate": 0.0,
        "camera.mount_error_rad": 0.0,
    }
)


def arena(velocity_mps: tuple[float, float], moves_s: float = math.inf) -> Arena:
    return Arena(
        name="moving",
        bounds=Bounds(-2.0, -2.0, 2.0, 2.0),
        robot=Pose2D(),
        target=PlacedObject("bowling_pin", 1.0, 0.0, velocity_mps, moves_s),
        config=PERFECT,
    )


def after(seconds: float, where: Arena) -> Simulation:
    simulation = Simulation(where, seed=1)
    simulation.step_to(seconds)
    return simulation


def test_lidar_camera_and_judge_see_it_where_it_is() -> None:
    simulation = after(6.0, arena((0.08, 0.0), 5.0))
    assert simulation.arena_now.target is not None
    assert simulation.arena_now.target.x_m == pytest.approx(1.4, abs=0.001)
    ahead = simulation.take_scans()[-1].ranges_m
    assert float(np.nanmin(ahead)) == pytest.approx(1.36, abs=0.005)
    (box,) = simulation.take_boxes()[-1].detections
    camera = PERFECT.camera
    assert box.height_px == pytest.approx(camera.focal_px * 0.28 / (1.4 - camera.x_m), rel=0.02)
    assert simulation.target_distance_m == pytest.approx(1.36 - 0.15, abs=0.001)
    error_m = simulation.judge(0.1, reported_arrived=True).stop_error_m
    assert error_m == pytest.approx(1.36 - 0.15 - 0.1, abs=0.001)


def test_it_stops_before_a_wall_and_stays() -> None:
    target = after(40.0, arena((0.1, 0.0))).arena_now.target
    assert target is not None
    assert 2.0 - (target.x_m + 0.04) == pytest.approx(0.05, abs=0.002)


def test_driving_into_a_robot_that_stands_is_a_collision() -> None:
    assert not after(5.0, arena((-0.1, 0.0))).collided
    assert after(12.0, arena((-0.1, 0.0))).collided


def test_one_that_stands_changes_nothing() -> None:
    still, moving = arena((0.0, 0.0)), arena((0.05, 0.0), 0.0)
    assert after(3.0, still).take_boxes() == after(3.0, moving).take_boxes()


def test_a_file_says_how_it_moves_within_limits(tmp_path) -> None:
    head = "bounds: [-2, -2, 2, 2]\nrobot: {x: 0, y: 0}\n"
    path = tmp_path / "a.yaml"
    path.write_text(
        head + "target: {class: bowling_pin, x: 1, y: 0, velocity_mps: [0.05, -0.1], moves_s: 9}\n"
    )
    target = load_arena(path).target
    assert target == PlacedObject("bowling_pin", 1.0, 0.0, (0.05, -0.1), 9.0)
    path.write_text(head + "target: {class: bowling_pin, x: 1, y: 0, velocity_mps: [5, 0]}\n")
    with pytest.raises(Exception, match=r"a\.yaml:3: error: target's velocity_mps's x is 5 m/s"):
        load_arena(path)


def test_it_is_written_as_it_is_read(tmp_path) -> None:
    from target_nav.sim.arena_writer import write_arena

    one = replace(arena((0.05, 0.0), 4.0), config=Config())
    assert load_arena(write_arena(one, tmp_path, Config())).target == one.target
