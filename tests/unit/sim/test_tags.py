"""Tags on walls: what the projected reader says is what the real detector says of the drawn picture."""

from __future__ import annotations

import math
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from target_nav.config import Config
from target_nav.detectors.apriltag import AprilTagDetector
from target_nav.errors import ConfigError
from target_nav.sim.arena import Arena, Bounds, BoxObstacle, PlacedObject, load_arena
from target_nav.sim.arena_writer import arena_text
from target_nav.sim.render import Renderer
from target_nav.sim.simulation import Simulation
from target_nav.sim.tags import CORNER_SIGMA_PX, TagReader
from target_nav.sim.world import World
from target_nav.state.types import Pose2D, RawDetection
from target_nav.utils.frames import compose, wrap_angle

QUIET = Config().override({"camera.noise_scale": 0.0, "camera.miss_probability": 0.0})
CAMERA = QUIET.camera
TAG = PlacedObject("apriltag:7", 2.0, 0.5, math.pi)
ROOM = Arena("tag", Bounds(-3.0, -3.0, 2.0, 3.0), Pose2D(), TAG, config=QUIET)
HEADER = "bounds: [-3, -3, 2, 3]\nrobot: {x: 0, y: 0}\n"


def pose_at(away_m: float, aside_deg: float, look_aside_rad: float = 0.03) -> Pose2D:
    """base_link, with the camera so far from the tag and so much to the side of its normal, looking past it."""
    to_camera = TAG.yaw_rad + math.radians(aside_deg)
    x, y = TAG.x_m + away_m * math.cos(to_camera), TAG.y_m + away_m * math.sin(to_camera)
    yaw = to_camera + math.pi + look_aside_rad
    return Pose2D(x - CAMERA.x_m * math.cos(yaw), y - CAMERA.x_m * math.sin(yaw), yaw)


def camera_at(pose: Pose2D) -> Pose2D:
    return compose(pose, Pose2D(CAMERA.x_m, CAMERA.y_m, CAMERA.yaw_rad))


def reader(arena: Arena = ROOM, seed: int = 0) -> TagReader:
    camera = arena.config.camera
    return TagReader(
        camera, camera.focal_px, World(arena).ray_caster(camera.z_m), np.random.default_rng(seed)
    )


def off_deg(seen: RawDetection, pose: Pose2D) -> list[float]:
    true_rad = wrap_angle(TAG.yaw_rad - camera_at(pose).yaw_rad)
    facings = [facing for facing in (seen.facing, seen.other_facing) if facing is not None]
    return [abs(math.degrees(wrap_angle(facing.facing_rad - true_rad))) for facing in facings]


@pytest.mark.parametrize(("away_m", "aside_deg"), [(2.6, -40), (2.0, 20), (1.5, 50), (0.8, 5), (0.33, -3)])
def test_drawn_and_read_is_what_the_projection_says(away_m: float, aside_deg: float) -> None:
    pose = pose_at(away_m, aside_deg)
    picture = Renderer(ROOM, QUIET).draw(pose, 0.0, np.random.default_rng(0))
    (drawn,) = AprilTagDetector(7, TAG.class_name, CAMERA).detect(picture)
    said = reader().read(TAG, camera_at(pose))
    assert said is not None
    assert (drawn.u_px, drawn.v_px) == pytest.approx((said.u_px, said.v_px), abs=1.0)
    assert (drawn.width_px, drawn.height_px) == pytest.approx((said.width_px, said.height_px), abs=1.5)
    true_off, false_off = off_deg(drawn, pose)
    assert true_off < 4.0
    assert (false_off, 0.0) == pytest.approx((off_deg(said, pose)[1], off_deg(said, pose)[0]), abs=6.0)
    assert drawn.other_facing is not None
    assert said.other_facing is not None
    # What the false pose leaves unexplained, to a factor.
    assert 0.5 < drawn.other_facing.error_px / said.other_facing.error_px < 2.0


def test_noise_takes_the_wrong_pose_first_from_afar_and_not_from_near() -> None:
    noisy = replace(ROOM, config=Config().override({"camera.miss_probability": 0.0}))

    def wrong_share(away_m: float, aside_deg: float) -> float:
        looks = reader(noisy)
        pose = pose_at(away_m, aside_deg)
        seen = [looks.read(TAG, camera_at(pose)) for _ in range(200)]
        offs = [off_deg(each, pose) for each in seen if each is not None]
        assert len(offs) > 150
        return float(np.mean([first > second for first, second in offs]))

    assert wrong_share(0.8, 20.0) == 0.0
    assert 0.02 < wrong_share(3.8, 10.0) < 0.5


@pytest.mark.parametrize(
    "pose",
    [
        pytest.param(pose_at(2.0, 100.0), id="from behind"),
        pytest.param(pose_at(2.0, 80.0), id="too much from the side"),
        pytest.param(pose_at(4.5, 0.0), id="too far off"),
        pytest.param(pose_at(0.15, 0.0), id="too near to be whole in the picture"),
        pytest.param(pose_at(2.0, 0.0, 0.6), id="outside of the picture"),
        pytest.param(pose_at(2.0, 0.0, math.pi), id="looking away"),
    ],
)
def test_what_cannot_be_read_is_not_read(pose: Pose2D) -> None:
    assert reader().read(TAG, camera_at(pose)) is None


def test_a_box_before_it_hides_it_from_reader_and_picture() -> None:
    pose = pose_at(2.5, 0.0)
    hidden = replace(ROOM, obstacles=(BoxObstacle(1.0, 0.55, 0.2, 0.4, 0.0),))
    assert reader(hidden).read(TAG, camera_at(pose)) is None
    picture = Renderer(hidden, QUIET).draw(pose, 0.0, np.random.default_rng(0))
    assert AprilTagDetector(7, TAG.class_name).detect(picture) == ()
    assert reader().read(TAG, camera_at(pose)) is not None


def test_lidar_and_footprint_meet_the_wall_and_not_the_tag() -> None:
    with_tag, without = World(ROOM), World(replace(ROOM, target=None))
    assert len(with_tag.circles) == len(without.circles) == 0
    assert with_tag.clearance_m(1.0, 0.5, 0.0) == without.clearance_m(1.0, 0.5, 0.0)


def test_nothing_is_invented_or_mistaken_where_the_target_is_a_tag() -> None:
    config = Config().override({"camera.false_rate": 0.9})
    decoys = (PlacedObject("bottle", 1.5, 0.0), PlacedObject("vase", 1.5, 1.0))
    simulation = Simulation(replace(ROOM, config=config, decoys=decoys), 1)
    simulation.step_to(8.0)
    seen = [box for frame in simulation.take_boxes() for box in frame.detections]
    tags = [box for box in seen if box.class_name == TAG.class_name]
    assert tags
    assert all(box.facing is not None for box in tags)
    assert {box.class_name for box in seen} <= {TAG.class_name, "bottle", "vase"}


def test_the_arena_that_comes_along_shows_the_tag_from_forty_degrees() -> None:
    arena = load_arena("tag_on_wall")
    assert arena.target is not None
    to_robot = math.atan2(arena.robot.y_m - arena.target.y_m, arena.robot.x_m - arena.target.x_m)
    assert abs(math.degrees(wrap_angle(to_robot - arena.target.yaw_rad))) == pytest.approx(40.0, abs=0.5)


def test_a_written_arena_is_read_back(tmp_path: Path) -> None:
    file = tmp_path / "tag.yaml"
    file.write_text(arena_text(ROOM, QUIET))
    assert load_arena(file, QUIET) == ROOM


@pytest.mark.parametrize(
    ("target", "says"),
    [
        ('{class: "apriltag:7", x: 2.0, y: 0.5}', "a tag needs a yaw"),
        ("{class: bowling_pin, x: 1.5, y: 0.5, yaw: 1.0}", "only a tag has a yaw; bowling_pin is round"),
        ('{class: "apriltag:587", x: 2.0, y: 0.5, yaw: 0}', "not a tag of the family 36h11"),
        ('{class: "apriltag:7", x: 1.5, y: 0.5, yaw: 3.14}', "hangs on nothing"),
    ],
)
def test_what_is_wrong_with_a_tag_is_told(tmp_path: Path, target: str, says: str) -> None:
    file = tmp_path / "bad.yaml"
    file.write_text(f"{HEADER}target: {target}\n")
    with pytest.raises(ConfigError, match=says) as refusal:
        load_arena(file)
    assert "bad.yaml:3" in str(refusal.value)


def test_sigma_of_a_corner_is_what_the_facing_varies_by() -> None:
    """One picture's error about the true direction, seen aslant: the corners' over the width's change."""
    looks = reader(replace(ROOM, config=Config().override({"camera.miss_probability": 0.0})))
    pose = pose_at(1.5, 40.0)
    offs = [
        min(off_deg(seen, pose)) for _ in range(300) if (seen := looks.read(TAG, camera_at(pose))) is not None
    ]
    expected = math.degrees(CORNER_SIGMA_PX / (59.0 * math.sin(math.radians(40.0))))
    assert np.sqrt(np.mean(np.square(offs))) == pytest.approx(expected, rel=0.25)
