"""The camera process with the C++ detector behind it: pictures to objects, kills, corrupt models, sources that end."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
import time
from collections.abc import Iterator
from pathlib import Path

import cv2
import numpy as np
import pytest

from target_nav.app.model_file import cpu_model
from target_nav.config import Config
from target_nav.detectors.onnx_detector import OnnxDetector
from target_nav.detectors.undistort import Undistorter
from target_nav.ipc import channels
from target_nav.sim.arena import Arena, Bounds, PlacedObject
from target_nav.sim.render import Renderer
from target_nav.state.snapshots import Calibration
from target_nav.state.types import DetectionFrame, Pose2D, RawDetectionFrame
from tests.utils import cpp_detector, tiny_onnx
from tests.utils.perception import PerceptionRig, has_object

pytestmark = pytest.mark.linux

START_LIMIT_S = 60.0
SQUARE_PX = (304, 208, 24, 64)
"""Left, top, width, height of the red thing; its box is as the network's constants say, a square of 24 px."""


def picture() -> np.ndarray:
    image = np.full((480, 640, 3), 90, np.uint8)
    left, top, width, height = SQUARE_PX
    image[top : top + height, left : left + width] = (30, 30, 220)
    return image


class Rig(PerceptionRig):
    UNTIL_LIMIT_S = START_LIMIT_S

    def __init__(self, folder: Path) -> None:
        super().__init__(folder, picture())

    def start(
        self, source: str = "sim", model: Path = cpp_detector.RED_SQUARE, *more: str
    ) -> subprocess.Popen[str]:
        """The camera process with the C++ detector. Shape is not judged here: the network's boxes are square."""
        cpp_detector.program()
        settings = ("detector.program=cpp", f"detector.model={model}", "detector.aspect_tolerance=2.0")
        process = subprocess.Popen(
            [
                *(sys.executable, "-m", "target_nav.app.camera_node", "--no-ros", "--prefix", self.prefix),
                *("--detector", source, "--logs", str(self.folder)),
                *(part for setting in (*settings, *more) for part in ("--set", setting)),
            ],
            stderr=subprocess.PIPE,
            text=True,
        )
        self.running.append(process)
        return process

    def detector_pid(self) -> int | None:
        (status,) = [s for s in channels.describe(self.prefix) if s.name == "detections"]
        return status.writer_pid if status.exists and status.alive else None

    def log(self) -> str:
        path = self.folder / "detector.log"
        return path.read_text() if path.exists() else "(no log)"


@pytest.fixture
def rig(tmp_path: Path) -> Iterator[Rig]:
    rig = Rig(tmp_path)
    yield rig
    rig.close()


def test_pictures_become_objects_with_their_own_stamps(rig: Rig) -> None:
    rig.start()
    frame = rig.until(has_object)
    assert frame.stamp_s in rig.sent
    left, top, width, height = SQUARE_PX
    found = frame.detections[0]
    assert abs(found.u_px - (left + width / 2)) < 16
    assert top - 16 < found.v_px < top + height + 16
    shown = channels.open_reader(channels.CAMERA, prefix=rig.prefix).latest()
    assert shown is not None
    assert np.array_equal(shown.image_bgr, rig.image)
    rig.image = np.full((480, 640, 3), 90, np.uint8)
    assert rig.until(lambda f: not f.detections).stamp_s > frame.stamp_s


def test_killed_at_any_moment_it_is_back_and_nothing_wrong_was_accepted(rig: Rig) -> None:
    """The bound is for a machine that has other things to do; docs/perception.md has what was measured."""
    camera = rig.start()
    rig.until(has_object)
    pictures = channels.open_reader(channels.CAMERA, prefix=rig.prefix)
    rng = np.random.default_rng(3)
    gone_s = []
    for _ in range(6):
        pid = rig.detector_pid()
        assert pid is not None
        time.sleep(float(rng.uniform(0.0, 0.05)))
        os.kill(pid, signal.SIGKILL)
        killed_s = time.monotonic()
        frame = rig.until(lambda f, since_s=killed_s: f.stamp_s > since_s, limit_s=20.0)
        gone_s.append(time.monotonic() - killed_s)
        assert frame.stamp_s in rig.sent
        shown = pictures.take_new()
        assert shown is None or np.array_equal(shown.image_bgr, rig.image)
        rig.until(has_object)
    print(f"\nback after {', '.join(f'{s:.2f}' for s in gone_s)} s")
    assert camera.poll() is None
    assert pictures.statistics.crc_errors == 0


def test_a_killed_camera_process_takes_its_detector_along(rig: Rig) -> None:
    first = rig.start()
    rig.until(has_object)
    pid = rig.detector_pid()
    first.kill()
    first.wait()
    deadline_s = time.monotonic() + 10.0
    while os.path.exists(f"/proc/{pid}") and rig.detector_pid() == pid:
        assert time.monotonic() < deadline_s
        time.sleep(0.01)
    rig.start()
    killed_s = time.monotonic()
    assert rig.until(lambda f: has_object(f) and f.stamp_s > killed_s)


@pytest.mark.parametrize("share", [0.0, 0.5, 0.95])
def test_a_corrupt_model_is_told_and_ends_the_camera_process(rig: Rig, tmp_path: Path, share: float) -> None:
    content = tiny_onnx.red_square_network()
    model = tmp_path / "model.onnx"
    model.write_bytes(content[: int(share * len(content))])
    _, errors = rig.start(model=model).communicate(timeout=START_LIMIT_S)
    assert rig.running[0].returncode == 2
    assert "model" in errors
    assert "corrupt" in errors or "no network" in errors
    assert "Traceback" not in errors
    assert rig.det.latest() is None


def test_a_model_for_something_else_is_told(rig: Rig) -> None:
    _, errors = rig.start(model=cpp_detector.RED_SQUARE.parent / "four_planes.onnx").communicate(
        timeout=START_LIMIT_S
    )
    assert rig.running[0].returncode == 2
    assert "no head" in errors


def test_a_camera_that_is_not_there_is_told(rig: Rig) -> None:
    _, errors = rig.start("/dev/video_none").communicate(timeout=START_LIMIT_S)
    assert rig.running[0].returncode == 2
    assert "camera /dev/video_none is not there" in errors


def test_a_video_that_ends_leaves_a_clear_word_and_objects_that_only_grow_older(
    rig: Rig, tmp_path: Path
) -> None:
    video = tmp_path / "v.avi"
    writer = cv2.VideoWriter(str(video), cv2.VideoWriter.fourcc(*"MJPG"), 20.0, (640, 480))
    for _ in range(12):
        writer.write(rig.image)
    writer.release()
    camera = rig.start(str(video))
    deadline_s = time.monotonic() + START_LIMIT_S
    while "end of" not in rig.log():
        assert time.monotonic() < deadline_s, rig.log()
        time.sleep(0.05)
    time.sleep(1.5)
    assert camera.poll() is None
    assert rig.det.age_s(time.monotonic()) > 1.0
    camera.send_signal(signal.SIGTERM)
    _, errors = camera.communicate(timeout=10.0)
    assert camera.returncode == 0
    assert "after 12 pictures" in errors
    assert "the detector is ended" in errors


def test_the_lens_reaches_the_detector_and_straightens_as_python_does(rig: Rig) -> None:
    lens = {"lens_k1": -0.25, "lens_k2": 0.05, "lens_p1": 0.001, "center_right_px": 4.0, "pixel_aspect": 1.01}
    rng = np.random.default_rng(1)
    rig.image = cv2.GaussianBlur(rng.integers(0, 256, (480, 640, 3), dtype=np.uint8), (0, 0), 3.0)
    rig.start("sim", cpp_detector.RED_SQUARE, *(f"camera.{key}={value}" for key, value in lens.items()))
    camera = Config().override({f"camera.{key}": value for key, value in lens.items()}).camera
    calibration = Calibration(
        0.0, camera.focal_px, camera.focal_y_px, camera.center_u_px, camera.center_v_px, camera.lens, 0.3, ""
    )
    expected = Undistorter().apply(rig.image, calibration)
    pictures = channels.open_reader(channels.CAMERA, prefix=rig.prefix)

    def straightened(frame: DetectionFrame) -> bool:
        shown = pictures.latest()
        return shown is not None and not np.array_equal(shown.image_bgr, rig.image)

    rig.until(straightened)
    shown = pictures.latest()
    assert shown is not None
    difference = np.abs(shown.image_bgr.astype(int) - expected.astype(int))
    assert difference.max() <= 3
    assert difference.mean() < 0.1


def test_both_opencv_generations_see_the_same_boxes(rig: Rig) -> None:
    """The C++ program has Debian's 4.x, Python the 5.x of PyPI: the same network, the same numbers."""
    net = cv2.dnn.readNetFromONNX(str(cpp_detector.RED_SQUARE))
    small = cv2.resize(rig.image, (320, 240), interpolation=cv2.INTER_AREA)
    boxed = cv2.copyMakeBorder(small, 8, 8, 0, 0, cv2.BORDER_CONSTANT, value=(114, 114, 114))
    net.setInput(cv2.dnn.blobFromImage(boxed, 1 / 255.0, swapRB=True))
    heads = net.forward(net.getUnconnectedOutLayersNames())
    best = max(float(head[0, 0].max()) for head in heads)
    rig.start()
    rig.until(has_object)
    raw = channels.open_reader(channels.DETECTIONS, prefix=rig.prefix).latest()
    assert isinstance(raw, RawDetectionFrame)
    assert raw.detections[0].score == pytest.approx(1.0 / (1.0 + np.exp(-best)), abs=0.01)


@pytest.mark.parametrize("range_m", [1.0, 2.0, 3.5])
def test_both_detectors_look_again_by_the_same_rule(rig: Rig, range_m: float) -> None:
    """A rendered pin, near enough for the glance alone and too far for it: the same boxes but for OpenCV's rounding."""
    model = cpu_model(Config())
    arena = Arena("pin", Bounds(-5, -5, 5, 5), Pose2D(-2, 0, 0), PlacedObject("bowling_pin", 0.0, 0.0))
    rig.image = Renderer(arena, Config()).draw(Pose2D(-range_m, 0.1, 0.0), 0.0, np.random.default_rng(4))
    (ours,) = OnnxDetector(model, score_min=Config().detector.propose_score).detect(rig.image)
    rig.start("sim", model)
    rig.until(has_object)
    raw = channels.open_reader(channels.DETECTIONS, prefix=rig.prefix).latest()
    assert isinstance(raw, RawDetectionFrame)
    (theirs,) = raw.detections
    assert theirs.score == pytest.approx(ours.score, abs=0.02)
    assert (theirs.u_px, theirs.v_px) == pytest.approx((ours.u_px, ours.v_px), abs=0.5)
    assert (theirs.width_px, theirs.height_px) == pytest.approx((ours.width_px, ours.height_px), abs=1.0)


def test_the_stages_times_are_logged(rig: Rig, tmp_path: Path) -> None:
    process = subprocess.Popen(
        [cpp_detector.program(), "--prefix", rig.prefix, "--model", cpp_detector.RED_SQUARE, "--report", "1"],
        stderr=subprocess.PIPE,
        text=True,
    )
    rig.running.append(process)
    end_s = time.monotonic() + 6.0
    while time.monotonic() < end_s:
        rig.send()
    process.send_signal(signal.SIGINT)
    _, errors = process.communicate(timeout=10.0)
    assert process.returncode == 0, errors
    line = next(line for line in errors.splitlines() if "pictures/s" in line)
    for stage in ("arrive", "undistort", "prepare", "infer", "decode", "publish", "total"):
        assert f" {stage} " in line, json.dumps(line)
