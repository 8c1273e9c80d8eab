"""The camera with real pictures: as many frames, as late, from where the robot was."""

from __future__ import annotations

import numpy as np

from target_nav.config import Config
from target_nav.sim.arena import Arena, Bounds, PlacedObject
from target_nav.sim.history import PoseHistory
from target_nav.sim.pixels import Draw, PixelCamera
from target_nav.sim.simulation import Simulation
from target_nav.state.types import Pose2D, RawDetection

CONFIG = Config()
BOX = RawDetection("bowling_pin", 0.9, 320.0, 240.0, 40.0, 140.0)
FRAME = np.zeros((480, 640, 3), np.uint8)


def test_frames_come_at_their_rate_and_late_by_their_latency() -> None:
    seen: list[Pose2D] = []

    def draw_with(mount_error_rad: float) -> Draw:
        assert abs(mount_error_rad) <= CONFIG.camera.mount_error_rad

        def draw(pose: Pose2D, stamp_s: float, rng: np.random.Generator) -> np.ndarray:
            seen.append(pose)
            return FRAME

        return draw

    camera = PixelCamera(CONFIG.camera, draw_with, lambda picture: (BOX,), np.random.default_rng(1), 0.0)
    history = PoseHistory(0.0, 0.01, 0.0, 0.0, 0.0)
    frames = []
    for step in range(1, 201):
        history.append(0.01 * step, 0.0, 0.0)
        camera.advance(0.01 * step, history)
        for frame in camera.take(0.01 * step):
            assert 0.01 * step - frame.stamp_s >= CONFIG.camera.latency_s - 1e-9
            frames.append(frame)
    assert 17 <= len(frames) <= 20
    assert [frame.frame_id for frame in frames] == list(range(len(frames)))
    assert all(frame.detections == (BOX,) for frame in frames)
    # Drawn from where the robot was when the frame was exposed: it drives 1 m/s.
    assert all(abs(pose.x_m - frame.stamp_s) < 0.02 for pose, frame in zip(seen, frames))


def test_the_same_seed_shows_the_same_pictures() -> None:
    arena = Arena("room", Bounds(-3, -3, 3, 3), Pose2D(-2.0, 0.0, 0.0), PlacedObject("bowling_pin", 0.0, 0.0))

    def pictures(seed: int) -> list[np.ndarray]:
        taken: list[np.ndarray] = []

        def detect(picture: np.ndarray) -> tuple[RawDetection, ...]:
            taken.append(picture)
            return ()

        Simulation(arena, seed, detect=detect).step_to(0.35)
        return taken

    first, again, other = pictures(3), pictures(3), pictures(4)
    assert len(first) >= 3
    assert all(np.array_equal(a, b) for a, b in zip(first, again, strict=True))
    assert not np.array_equal(first[0], other[0])
