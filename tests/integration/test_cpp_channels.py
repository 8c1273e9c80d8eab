"""The C++ writer against the Python reader: two processes flat out, killed in the middle, restarted."""

from __future__ import annotations

import os
import signal
import subprocess
import time
import uuid
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest

from target_nav.ipc import channels, cpp_header
from target_nav.state.types import RawDetectionFrame
from tests.utils import cpp_detector, tiny_onnx

pytestmark = pytest.mark.linux

SECONDS = 3.0


@pytest.fixture
def prefix() -> Iterator[str]:
    name = f"t{uuid.uuid4().hex[:10]}"
    yield name
    for file in Path("/dev/shm").glob(f"{name}_*"):
        file.unlink()


def whole(frame: RawDetectionFrame) -> bool:
    """Everything in a frame of `channel_stress` follows from its number."""
    boxes = frame.detections
    number = float(frame.frame_id)
    return len(boxes) == frame.frame_id % 65 and all(
        (b.class_name, b.score, b.u_px, b.v_px, b.width_px, b.height_px)
        == ("bowling_pin", number, number, number, number, number)
        for b in boxes
    )


def test_the_committed_header_is_the_generated_one() -> None:
    assert (cpp_detector.DRPAI / "generated" / "channels.hpp").read_text() == cpp_header.generate(), (
        "python -m target_nav.ipc.cpp_header > drpai/generated/channels.hpp"
    )


def test_the_committed_networks_are_the_written_ones() -> None:
    data = cpp_detector.RED_SQUARE.parent
    assert cpp_detector.RED_SQUARE.read_bytes() == tiny_onnx.red_square_network()
    assert (data / "four_planes.onnx").read_bytes() == tiny_onnx.red_square_network(planes=4)


def test_boxes_flat_out_none_torn_none_stale(prefix: str) -> None:
    with subprocess.Popen(
        [cpp_detector.channel_stress(), "detections", prefix, str(SECONDS)], stdout=subprocess.PIPE, text=True
    ) as writer:
        reader = channels.open_reader(channels.DETECTIONS, prefix=prefix)
        accepted = torn = stale = 0
        last = 0
        while writer.poll() is None:
            frame = reader.take_new()
            if frame is None:
                continue
            accepted += 1
            torn += not whole(frame)
            stale += frame.frame_id <= last
            last = frame.frame_id
        assert writer.stdout is not None
        written = int(writer.stdout.read())
    statistics = reader.statistics
    print(f"\nboxes: written {written}, accepted {accepted}, torn {torn}, stale {stale}; {statistics}")
    assert (torn, stale) == (0, 0)
    assert writer.returncode == 0
    assert accepted > 10
    assert reader.latest() == frame or reader.latest().frame_id == written


def test_pictures_flat_out_none_torn_none_stale(prefix: str) -> None:
    with subprocess.Popen(
        [cpp_detector.channel_stress(), "camera", prefix, str(SECONDS)], stdout=subprocess.PIPE, text=True
    ) as writer:
        reader = channels.open_reader(channels.CAMERA, prefix=prefix)
        buffer = np.empty((480, 640, 3), np.uint8)
        accepted = torn = stale = 0
        last = 0
        while writer.poll() is None:
            frame = reader.read_into(buffer)
            if frame is None:
                continue
            accepted += 1
            value = frame.frame_id % 251
            torn += not (frame.image_bgr.shape == (480, 640, 3) and bool((frame.image_bgr == value).all()))
            stale += frame.frame_id <= last
            last = frame.frame_id
        assert writer.stdout is not None
        written = int(writer.stdout.read())
    print(
        f"\npictures: written {written}, accepted {accepted}, torn {torn}, stale {stale}; {reader.statistics}"
    )
    assert (torn, stale) == (0, 0)
    assert accepted > 10


@pytest.mark.slow
def test_writers_killed_at_any_moment_leave_nothing_torn(prefix: str) -> None:
    """Every other one kills itself inside of a slot; the others are killed from outside while they write."""
    stress = cpp_detector.channel_stress()
    reader = channels.open_reader(channels.DETECTIONS, prefix=prefix)
    rng = np.random.default_rng(5)
    accepted = torn = killed_inside = 0
    for round_ in range(40):
        inside = round_ % 2 == 0
        command = [stress, "detections", prefix, "0.02" if inside else "60", *(["die"] if inside else [])]
        with subprocess.Popen(command, stdout=subprocess.DEVNULL) as writer:
            end_s = time.monotonic() + 5.0
            kill_s = time.monotonic() + float(rng.uniform(0.02, 0.08))
            while writer.poll() is None and time.monotonic() < end_s:
                if not inside and time.monotonic() > kill_s:
                    writer.send_signal(signal.SIGKILL)
                frame = reader.take_new()
                if frame is not None:
                    accepted += 1
                    torn += not whole(frame)
            assert writer.poll() == -signal.SIGKILL
            killed_inside += inside
        after = reader.take_new()
        torn += after is not None and not whole(after)
    print(
        f"\n40 writers killed, {killed_inside} inside a slot: accepted {accepted}, torn {torn}; {reader.statistics}"
    )
    assert torn == 0
    assert accepted > 10


def test_python_takes_the_channel_over_from_cpp_and_back(prefix: str) -> None:
    stress = cpp_detector.channel_stress()
    reader = channels.open_reader(channels.DETECTIONS, prefix=prefix)
    last_s = 0.0
    for _ in range(3):
        subprocess.run([stress, "detections", prefix, "0.02"], stdout=subprocess.DEVNULL, check=True)
        cpp = reader.take_new()
        assert cpp is not None
        assert cpp.stamp_s > last_s
        with channels.open_writer(channels.DETECTIONS, prefix=prefix) as writer:
            assert reader.take_new() is None
            mine = RawDetectionFrame(time.monotonic(), 1)
            writer.write(mine)
            assert reader.take_new() == mine
            busy = subprocess.run(
                [stress, "detections", prefix, "0.02"], capture_output=True, text=True, check=False
            )
            assert busy.returncode != 0
            assert f"pid {os.getpid()}" in busy.stderr
        last_s = mine.stamp_s
