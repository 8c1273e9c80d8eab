"""Boxes as the detector would give them: where they should be, and wrong in the measured ways."""

import math
from dataclasses import replace

import numpy as np
import pytest

from target_nav.config import CameraConfig
from target_nav.sim.arena import Arena, Bounds, BoxObstacle, CircleObstacle, PlacedObject
from target_nav.sim.boxes import BoxCamera
from target_nav.sim.history import PoseHistory
from target_nav.sim.world import World
from target_nav.state.types import Pose2D, RawDetection, RawDetectionFrame

CAMERA = CameraConfig()
PERFECT = replace(CAMERA, noise_scale=0.0, miss_probability=0.0, false_rate=0.0, mount_error_rad=0.0)
NOISY = replace(CAMERA, miss_probability=0.0, false_rate=0.0, mount_error_rad=0.0)


def camera_of(
    config: CameraConfig, target: PlacedObject | None, obstacles=(), decoys=(), seed: int = 1
) -> BoxCamera:
    arena = Arena("any", Bounds(-9, -9, 9, 9), Pose2D(), target=target, obstacles=obstacles, decoys=decoys)
    caster = World(arena).ray_caster(config.z_m)
    return BoxCamera(config, arena.objects, "bowling_pin", caster, np.random.default_rng(seed), 0.0)


def frames(camera: BoxCamera, count: int, pose: Pose2D = Pose2D()) -> list[RawDetectionFrame]:  # noqa: B008
    history = PoseHistory(0.0, 0.01, pose.x_m, pose.y_m, pose.yaw_rad)
    taken: list[RawDetectionFrame] = []
    now_s = 0.0
    while len(taken) < count:
        now_s += 0.1
        camera.advance(now_s, history)
        taken += camera.take(now_s)
    return taken[:count]


def one_box(config: CameraConfig, x_m: float, y_m: float, **world) -> RawDetection | None:
    (frame,) = frames(camera_of(config, PlacedObject("bowling_pin", x_m, y_m), **world), 1)
    return frame.detections[0] if frame.detections else None


@pytest.mark.parametrize(("range_m", "bearing_rad"), [(1.0, 0.0), (1.0, 0.4), (2.5, -0.3), (3.9, 0.1)])
def test_a_perfect_box_gives_range_and_bearing_back(range_m, bearing_rad):
    x = CAMERA.x_m + range_m * math.cos(bearing_rad)
    box = one_box(PERFECT, x, range_m * math.sin(bearing_rad))
    assert box is not None
    bearing = math.atan((320.0 - box.u_px) / 554.0)
    assert bearing == pytest.approx(bearing_rad, abs=0.003)
    assert 554.0 * 0.28 / box.height_px / math.cos(bearing) == pytest.approx(range_m, rel=0.002)
    assert box.width_px / box.height_px == pytest.approx(0.08 / 0.28 / math.cos(bearing_rad), rel=0.03)


def test_the_camera_sees_left_on_the_left():
    left, right = one_box(PERFECT, 2.0, 0.5), one_box(PERFECT, 2.0, -0.5)
    assert left is not None
    assert right is not None
    assert left.u_px < 320.0 < right.u_px
    assert left.u_px + right.u_px == pytest.approx(640.0)


@pytest.mark.parametrize(("x_m", "y_m"), [(-1.0, 0.0), (1.0, 1.5), (4.3, 0.0), (0.12, 0.0)])
def test_behind_aside_too_far_or_in_the_lens_there_is_no_box(x_m, y_m):
    assert one_box(PERFECT, x_m, y_m) is None


def test_under_0_4_m_the_pin_no_longer_fits_the_picture():
    camera_x = CAMERA.x_m
    whole = one_box(PERFECT, camera_x + 0.40, 0.0)
    assert whole is not None
    assert whole.height_px < 480.0
    seen = [box for frame in frames(camera_of(PERFECT, PlacedObject("bowling_pin", camera_x + 0.25, 0.0)), 20)
            for box in frame.detections]  # fmt: skip
    assert seen
    for box in seen:
        assert box.height_px == pytest.approx(480.0)
        naive_range_m = 554.0 * 0.28 / box.height_px
        assert naive_range_m > 0.25 * 1.2


def test_jitter_makes_ranges_wrong_by_the_measured_share():
    boxes = [f.detections[0] for f in frames(camera_of(NOISY, PlacedObject("bowling_pin", 2.12, 0.0)), 1500)]
    ranges = 554.0 * 0.28 / np.array([box.height_px for box in boxes])
    bearings = np.degrees(np.arctan((320.0 - np.array([box.u_px for box in boxes])) / 554.0))
    assert 0.034 <= np.std(ranges) / 2.0 <= 0.046
    assert 0.4 <= np.std(bearings) <= 0.7
    assert np.mean(bearings) == pytest.approx(0.0, abs=0.05)


def test_the_mount_error_is_constant_within_its_limit_and_differs_by_seed():
    config = replace(PERFECT, mount_error_rad=0.014)
    errors = []
    for seed in range(30):
        camera = camera_of(config, PlacedObject("bowling_pin", 2.12, 0.0), seed=seed)
        bearings = {math.atan((320.0 - f.detections[0].u_px) / 554.0) for f in frames(camera, 3)}
        assert max(bearings) - min(bearings) < 1e-9
        # A camera that looks to the left sees the pin to the right.
        assert min(bearings) == pytest.approx(-camera.mount_error_rad, abs=1e-3)
        errors.append(camera.mount_error_rad)
    assert max(abs(error) for error in errors) <= 0.014
    assert np.std(errors) > 0.004


def test_what_stands_before_the_pin_hides_it():
    whole = one_box(PERFECT, 2.0, 0.0)
    assert whole is not None
    assert one_box(PERFECT, 2.0, 0.0, obstacles=(BoxObstacle(1.0, 0.0, 0.2, 0.3, 0.0),)) is None
    assert one_box(PERFECT, 2.0, 0.0, obstacles=(CircleObstacle(1.0, 0.0, 0.1),)) is None
    behind = one_box(PERFECT, 2.0, 0.0, obstacles=(BoxObstacle(3.0, 0.0, 0.2, 2.0, 0.0),))
    assert behind == whole


@pytest.mark.parametrize("side", [1.0, -1.0])
def test_a_partly_hidden_pin_has_a_narrower_box_on_its_free_side(side):
    pin = PlacedObject("bowling_pin", 2.0, 0.0)
    whole = one_box(PERFECT, 2.0, 0.0)
    assert whole is not None
    # The box ends 5 mm to one side of the line of sight, half a metre before the pin, and hides what is on that side.
    box = BoxObstacle(1.5, 0.155 * side, 0.1, 0.3, 0.0)
    found = [b for f in frames(camera_of(PERFECT, pin, (box,)), 60) for b in f.detections]
    assert 10 < len(found) < 50  # and it is found less often
    for detection in found:
        assert 0.4 * whole.width_px < detection.width_px < 0.75 * whole.width_px
        assert (detection.u_px - whole.u_px) * side > 0.1 * whole.width_px
        assert detection.height_px == pytest.approx(whole.height_px)


def test_a_low_thing_hides_nothing():
    cup = PlacedObject("cup", 1.0, 0.0)
    (frame,) = frames(camera_of(PERFECT, PlacedObject("bowling_pin", 2.0, 0.0), decoys=(cup,)), 1)
    assert {d.class_name for d in frame.detections} == {"bowling_pin", "cup"}


def test_frames_come_late_at_their_rate_with_the_stamp_of_exposure():
    camera = camera_of(PERFECT, PlacedObject("bowling_pin", 2.0, 0.0))
    history = PoseHistory(0.0, 0.01, 0.0, 0.0, 0.0)
    got: list[tuple[float, RawDetectionFrame]] = []
    for step in range(1, 301):
        camera.advance(step * 0.01, history)
        got += [(step * 0.01, frame) for frame in camera.take(step * 0.01)]
    assert [frame.frame_id for _, frame in got] == list(range(len(got)))
    assert np.allclose(np.diff([frame.stamp_s for _, frame in got]), 0.1)
    assert len(got) in (28, 29)
    for delivered_s, frame in got:
        assert 0.1 - 1e-6 <= delivered_s - frame.stamp_s < 0.1 + 0.011


def test_a_share_of_the_frames_misses_the_pin():
    config = replace(NOISY, miss_probability=0.06)
    found = sum(
        bool(f.detections) for f in frames(camera_of(config, PlacedObject("bowling_pin", 2.0, 0.0)), 3000)
    )
    assert found / 3000 == pytest.approx(0.94, abs=0.015)


def test_false_boxes_come_at_their_rate_inside_the_picture():
    config = replace(CAMERA, false_rate=0.02)
    invented = [box for frame in frames(camera_of(config, None), 4000) for box in frame.detections]
    assert len(invented) / 4000 == pytest.approx(0.02, abs=0.007)
    for box in invented:
        assert box.class_name == "bowling_pin"
        assert box.u_px - box.width_px / 2 >= 0.0
        assert box.u_px + box.width_px / 2 <= 640.0
        assert box.v_px - box.height_px / 2 >= 0.0
        assert box.v_px + box.height_px / 2 <= 480.0
    assert len({round(box.u_px / 64) for box in invented}) > 5


def test_a_decoy_is_mostly_itself_and_sometimes_a_target_of_the_wrong_shape():
    boxes = [b for f in frames(camera_of(NOISY, None, decoys=(PlacedObject("vase", 2.0, 0.0),)), 3000)
             for b in f.detections]  # fmt: skip
    wrong = [box for box in boxes if box.class_name == "bowling_pin"]
    assert {box.class_name for box in boxes} == {"bowling_pin", "vase"}
    assert len(wrong) / len(boxes) == pytest.approx(0.05, abs=0.015)
    right_aspect = np.mean([box.width_px / box.height_px for box in boxes if box.class_name == "vase"])
    assert np.mean([box.width_px / box.height_px for box in wrong]) > 1.3 * right_aspect
    assert max(box.score for box in wrong) <= 0.7


def test_scores_fall_with_range():
    means = []
    for range_m in (1.0, 2.0, 3.8):
        camera = camera_of(NOISY, PlacedObject("bowling_pin", range_m, 0.0))
        means.append(np.mean([f.detections[0].score for f in frames(camera, 200)]))
    assert means[0] > means[1] > means[2] > 0.55
