"""The simulated camera: frames drawn beside the physics, never in its way."""

from __future__ import annotations

import threading

import numpy as np
import pytest
from numpy.typing import NDArray

from target_nav.app.sim_camera import SimCamera
from target_nav.state.snapshots import CameraFrame
from target_nav.state.types import Pose2D

PATIENCE_S = 10.0


def noise(pose: Pose2D, stamp_s: float, rng: np.random.Generator) -> NDArray[np.uint8]:
    return rng.integers(0, 255, (2, 2, 3), dtype=np.uint8)


def frames_of(seed: int, count: int) -> list[CameraFrame]:
    frames: list[CameraFrame] = []
    written = threading.Semaphore(0)

    def write(frame: CameraFrame) -> None:
        frames.append(frame)
        written.release()

    camera = SimCamera(noise, write, seed)
    for index in range(count):
        camera.expose(Pose2D(float(index), 0.0, 0.0), 0.1 * index)
        assert written.acquire(timeout=PATIENCE_S)
    camera.close()
    assert camera.statistics.frames == count
    return frames


def test_frames_carry_the_stamp_of_their_exposure() -> None:
    frames = frames_of(1, 3)
    assert [frame.stamp_s for frame in frames] == pytest.approx([0.0, 0.1, 0.2])
    assert [frame.frame_id for frame in frames] == [0, 1, 2]


def test_the_seed_decides_the_noise() -> None:
    first, again, other = frames_of(1, 2), frames_of(1, 2), frames_of(2, 2)
    assert np.array_equal(first[1].image_bgr, again[1].image_bgr)
    assert not np.array_equal(first[1].image_bgr, other[1].image_bgr)


def test_frames_that_come_too_fast_are_dropped_and_nothing_waits() -> None:
    drawing, go_on = threading.Event(), threading.Event()

    def slow(pose: Pose2D, stamp_s: float, rng: np.random.Generator) -> NDArray[np.uint8]:
        drawing.set()
        assert go_on.wait(PATIENCE_S)
        return noise(pose, stamp_s, rng)

    camera = SimCamera(slow, lambda frame: None, 1)
    camera.expose(Pose2D(), 0.0)
    assert drawing.wait(PATIENCE_S)
    for index in range(1, 5):
        camera.expose(Pose2D(), 0.1 * index)
    go_on.set()
    camera.close()
    assert (camera.statistics.frames, camera.statistics.dropped) == (2, 3)


def test_an_error_while_drawing_reaches_the_main_thread() -> None:
    def broken(pose: Pose2D, stamp_s: float, rng: np.random.Generator) -> NDArray[np.uint8]:
        raise RuntimeError("no canvas")

    camera = SimCamera(broken, lambda frame: None, 1)
    camera.expose(Pose2D(), 0.0)
    camera.close()
    with pytest.raises(RuntimeError, match="no canvas"):
        camera.expose(Pose2D(), 0.1)
