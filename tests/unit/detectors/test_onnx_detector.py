"""The shipped network by OpenCV's dnn: it finds a rendered pin, and a file that is no network is told so."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from target_nav.app.model_file import cpu_model
from target_nav.config import Config
from target_nav.detectors.onnx_detector import OnnxDetector
from target_nav.errors import DeviceError
from target_nav.sim.arena import Arena, Bounds, PlacedObject
from target_nav.sim.render import Renderer
from target_nav.state.types import Pose2D
from target_nav.utils.distance import project

CAMERA = Config().camera


@pytest.fixture(scope="module")
def detector() -> OnnxDetector:
    return OnnxDetector(cpu_model(Config()))


def picture_of(target: PlacedObject | None, range_m: float = 1.2) -> np.ndarray:
    arena = Arena("room", Bounds(-4.0, -4.0, 4.0, 4.0), Pose2D(-3.0, 0.0, 0.0), target)
    pose = Pose2D(-range_m - CAMERA.x_m, 0.0, 0.0)
    return Renderer(arena, Config()).draw(pose, 0.0, np.random.default_rng(1))


@pytest.mark.parametrize("range_m", [0.6, 1.2, 2.5])
def test_a_rendered_pin_is_found_where_it_is(detector: OnnxDetector, range_m: float) -> None:
    best = detector.detect(picture_of(PlacedObject("bowling_pin", 0.0, 0.0), range_m))[0]
    truth = project(CAMERA, range_m, 0.0, 0.28, 0.08)
    assert truth is not None
    assert best.class_name == "bowling_pin"
    assert best.score >= Config().detector.score_min
    assert best.u_px == pytest.approx(truth.u_px, abs=0.15 * truth.width_px + 2.0)
    assert best.height_px == pytest.approx(truth.height_px, rel=0.10)


def test_an_empty_room_has_no_pin(detector: OnnxDetector) -> None:
    assert [d for d in detector.detect(picture_of(None)) if d.score >= Config().detector.score_min] == []


@pytest.mark.parametrize("name", ["bottle", "cone", "can"])
def test_a_look_alike_is_no_pin(detector: OnnxDetector, name: str) -> None:
    found = detector.detect(picture_of(PlacedObject(name, 0.0, 0.0)))
    assert [d for d in found if d.score >= Config().detector.score_min] == []


def test_a_picture_of_another_kind_is_refused(detector: OnnxDetector) -> None:
    with pytest.raises(ValueError, match="uint8"):
        detector.detect(np.zeros((480, 640), np.uint8))


def test_a_file_that_is_not_there_is_told(tmp_path: Path) -> None:
    with pytest.raises(DeviceError, match="not there"):
        OnnxDetector(tmp_path / "none.onnx")


@pytest.mark.parametrize("size", [0, 100, 200_000])
def test_a_torn_file_is_told(tmp_path: Path, size: int) -> None:
    torn = tmp_path / "torn.onnx"
    torn.write_bytes(cpu_model(Config()).read_bytes()[:size])
    with pytest.raises(DeviceError, match=r"torn\.onnx"):
        OnnxDetector(torn)
