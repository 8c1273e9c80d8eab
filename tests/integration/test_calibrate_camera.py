"""`target-nav calibrate camera`, both procedures, as a person runs them."""

from __future__ import annotations

import threading
import time
import uuid
from collections.abc import Iterator
from pathlib import Path

import cv2
import numpy as np
import pytest
from click.testing import CliRunner

from target_nav.app.commands.calibrate import command
from target_nav.app.settings import load_config
from target_nav.errors import TargetNavError
from target_nav.ipc import channels
from target_nav.state.types import RawDetection, RawDetectionFrame
from tests.unit.detectors.test_checkerboard import drawn, poses

pytestmark = pytest.mark.linux

FOCAL_PX = 580.0


def run(*arguments: str) -> str:
    result = CliRunner().invoke(command, ["camera", *arguments])
    if isinstance(result.exception, TargetNavError):
        raise result.exception
    assert result.exit_code == 0, result.output
    return result.output


@pytest.mark.slow
def test_the_lens_from_a_folder_of_pictures(tmp_path: Path) -> None:
    for k, pose in enumerate(poses(10, 0.6)):
        cv2.imwrite(str(tmp_path / f"{k}.png"), drawn(*pose))
    cv2.imwrite(str(tmp_path / "empty.png"), np.full((480, 640, 3), 127, np.uint8))
    file = tmp_path / "camera.yaml"
    file.write_text("camera.z_m: 0.2\n")
    output = run("lens", "--images", str(tmp_path), "--config", str(file))
    assert "empty.png: no whole board" in output
    camera = load_config(file).camera
    assert camera.z_m == 0.2
    assert camera.focal_px == pytest.approx(540.0, rel=0.01)
    assert camera.lens_k1 == pytest.approx(-0.22, abs=0.04)


def test_pictures_of_another_size_are_refused(tmp_path: Path) -> None:
    cv2.imwrite(str(tmp_path / "a.png"), np.zeros((240, 320, 3), np.uint8))
    with pytest.raises(TargetNavError, match="320x240, the configuration has 640x480"):
        run("lens", "--images", str(tmp_path), "--config", str(tmp_path / "c.yaml"))


@pytest.fixture
def detector() -> Iterator[tuple[str, list[float]]]:
    """A prefix, and the depths at which a pin is seen one after the other; boxes jitter by 2 %."""
    prefix = f"t{uuid.uuid4().hex[:10]}"
    depths: list[float] = []
    stop = threading.Event()

    def write() -> None:
        rng = np.random.default_rng(6)
        with channels.open_writer(channels.DETECTIONS, prefix=prefix) as writer:
            number = 0
            while not stop.is_set():
                number += 1
                boxes = []
                if depths:
                    height = FOCAL_PX * 0.28 / depths[0] * (1.0 + 0.02 * rng.standard_normal())
                    boxes = [RawDetection("bowling_pin", 0.9, 310.0, 240.0, height * 0.286, height)]
                writer.write(RawDetectionFrame(time.monotonic(), number, tuple(boxes)))
                time.sleep(0.003)

    thread = threading.Thread(target=write)
    thread.start()
    yield prefix, depths
    stop.set()
    thread.join()
    for file in Path("/dev/shm").glob(f"{prefix}_*"):
        file.unlink()


def test_the_focal_length_and_the_mount_s_yaw_from_a_pin_at_a_known_distance(
    detector: tuple[str, list[float]], tmp_path: Path
) -> None:
    prefix, depths = detector
    depths.append(1.5)
    file = tmp_path / "camera.yaml"
    output = run(
        "focal", "--at", "1.5", "--ahead", "--yes", "--prefix", prefix, "--config", str(file), "--boxes", "60"
    )
    camera = load_config(file).camera
    assert camera.focal_px == pytest.approx(FOCAL_PX, rel=0.01)
    assert camera.yaw_rad == pytest.approx(-np.arctan(10.0 / FOCAL_PX), abs=1e-3)
    assert f"written to {file}" in output


def test_without_a_target_the_person_is_told(
    detector: tuple[str, list[float]], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("target_nav.app.commands.calibrate_camera.SIGHTING_LIMIT_S", -2.0)
    with pytest.raises(TargetNavError, match="only 0 of 5 boxes"):
        run(
            "focal",
            "--at",
            "1",
            "--yes",
            "--prefix",
            detector[0],
            "--boxes",
            "5",
            "--config",
            str(tmp_path / "c"),
        )
    assert not (tmp_path / "c").exists()
