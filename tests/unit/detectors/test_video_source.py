"""Cameras and video files; the file is a real one, written here."""

from __future__ import annotations

from pathlib import Path

import cv2
import numpy as np
import pytest

from target_nav.detectors.video_source import VideoSource
from target_nav.errors import DeviceError

FRAMES = 6
LEVELS = [20 + 40 * k for k in range(FRAMES)]


@pytest.fixture
def video(tmp_path: Path) -> Path:
    path = tmp_path / "grey.avi"
    writer = cv2.VideoWriter(str(path), cv2.VideoWriter.fourcc(*"MJPG"), 10.0, (64, 48))
    assert writer.isOpened()
    for level in LEVELS:
        writer.write(np.full((48, 64, 3), level, np.uint8))
    writer.release()
    return path


class FakeClock:
    def __init__(self) -> None:
        self.now_s = 50.0

    def __call__(self) -> float:
        return self.now_s


def test_a_file_is_played_at_its_own_rate_and_ends(video: Path) -> None:
    clock = FakeClock()
    source = VideoSource(str(video), 64, 48, rate_hz=100.0, clock=clock)
    seen = []
    for _ in range(30):  # 3 polls for each of 10 periods
        frame = source.poll()
        if frame is not None:
            seen.append(frame)
        clock.now_s += 0.1 / 3 + 1e-6
    assert [frame.frame_id for frame in seen] == list(range(1, FRAMES + 1))
    assert [float(frame.image_bgr.mean()) for frame in seen] == pytest.approx(LEVELS, abs=3.0)
    steps = np.diff([frame.stamp_s for frame in seen])
    assert steps == pytest.approx([0.1] * (FRAMES - 1), abs=1e-3)
    assert "end of" in source.ended
    assert not source.lost
    source.close()


def test_a_lower_rate_is_kept(video: Path) -> None:
    clock = FakeClock()
    source = VideoSource(str(video), 64, 48, rate_hz=5.0, clock=clock)
    assert source.poll() is not None
    clock.now_s += 0.1
    assert source.poll() is None
    clock.now_s += 0.1001
    assert source.poll() is not None


@pytest.mark.parametrize("source", ["/dev/video_that_is_not_there", "97"])
def test_a_camera_that_is_not_there_is_told_with_those_that_are(source: str) -> None:
    with pytest.raises(DeviceError, match=r"is not there \(present: .+\); plug it in"):
        VideoSource(source, 640, 480, 10.0)


def test_a_file_that_is_not_there_is_told() -> None:
    with pytest.raises(DeviceError, match=r"video lost\.avi is not there; --source takes"):
        VideoSource("lost.avi", 640, 480, 10.0)


def test_a_file_that_is_no_video_is_told(tmp_path: Path) -> None:
    path = tmp_path / "letter.txt"
    path.write_text("no pictures in here")
    with pytest.raises(DeviceError, match="cannot be opened"):
        VideoSource(str(path), 640, 480, 10.0)
