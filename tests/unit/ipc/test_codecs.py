"""Bounded arrays: how much is stored, what is kept when there is too much, what guards the pixels."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra import numpy as hnp

from target_nav.errors import DeviceError
from target_nav.ipc.channels import CAMERA, DET, DETECTIONS, LASER, Channel
from target_nav.ipc.codecs import MAX_DETECTIONS, MAX_PIXEL_BYTES, MAX_POINTS, Encoded, pixel_sum
from target_nav.state.snapshots import CameraFrame, LaserSnapshot
from target_nav.state.types import DetectionFrame, Pose2D, RawDetectionFrame
from tests.unit.ipc.values import detection, frames, lasers, pictures, raw_frames, same


def encode(channel: Channel[Any], value: Any) -> tuple[bytes, Encoded]:
    buffer = bytearray(channel.codec.head_bytes)
    encoded = channel.codec.encode(value, buffer, 0)
    return bytes(buffer[: encoded.length]), encoded


def through(channel: Channel[Any], value: Any) -> Any:
    head, encoded = encode(channel, value)
    bulk = encoded.bulk
    if bulk is None:
        return channel.codec.decode(head, 0, None)
    pixels = np.frombuffer(bytes(bulk), np.uint8)
    return channel.codec.decode(head, 0, pixels.reshape(channel.codec.shape(head, 0)))


@given(frames)
def test_detections_come_back(value: DetectionFrame) -> None:
    assert same(through(DET, value), value)


@given(raw_frames)
def test_raw_detections_come_back(value: RawDetectionFrame) -> None:
    assert same(through(DETECTIONS, value), value)


@given(lasers)
def test_laser_points_come_back(value: LaserSnapshot) -> None:
    assert same(through(LASER, value), value)


@given(pictures)
def test_pictures_of_any_size_come_back(value: CameraFrame) -> None:
    assert same(through(CAMERA, value), value)


@pytest.mark.parametrize("count", [0, 1, MAX_DETECTIONS - 1, MAX_DETECTIONS])
def test_as_many_detections_as_there_are_are_stored_and_no_more(count: int) -> None:
    value = DetectionFrame(1.0, 2, tuple(detection(track_id=i) for i in range(count)))
    head, encoded = encode(DET, value)
    assert through(DET, value) == value
    assert encoded.dropped == 0
    assert (
        len(head) == DET.codec.layout["detections"].offset + count * DET.codec.layout["detections"].item_bytes
    )


def test_of_too_many_detections_the_best_are_kept_in_their_order_and_the_rest_is_counted() -> None:
    scores = [*np.linspace(0.1, 0.9, MAX_DETECTIONS), math.nan, 0.05, 0.95]
    value = DetectionFrame(1.0, 2, tuple(detection(score=float(s), track_id=i) for i, s in enumerate(scores)))
    kept = through(DET, value).detections
    assert [d.track_id for d in kept] == [*range(1, MAX_DETECTIONS), MAX_DETECTIONS + 2]
    assert encode(DET, value)[1].dropped == 3


@pytest.mark.parametrize("count", [0, 1, MAX_POINTS, MAX_POINTS + 1, 4 * MAX_POINTS])
def test_of_too_many_points_evenly_spaced_ones_are_kept(count: int) -> None:
    points = np.column_stack([np.arange(count), -np.arange(count)]).astype(float)
    value = LaserSnapshot(1.0, Pose2D(), points)
    kept = through(LASER, value).points_in_base_m
    assert len(kept) == min(count, MAX_POINTS)
    assert encode(LASER, value)[1].dropped == count - len(kept)
    if count:
        assert kept[0].tolist() == points[0].tolist()
        assert kept[-1].tolist() == points[-1].tolist()
        assert np.ptp(np.diff(kept[:, 0])) <= 1.0 if count > 1 else True


@pytest.mark.parametrize("points", [np.zeros(6), np.zeros((3, 3)), np.array([["a", "b"]])])
def test_points_of_another_shape_are_refused(points: np.ndarray) -> None:
    with pytest.raises(DeviceError, match=r"laser points have shape .*must be \(N, 2\)"):
        through(LASER, LaserSnapshot(1.0, Pose2D(), points))


def test_points_of_another_number_type_are_metres_all_the_same() -> None:
    value = LaserSnapshot(1.0, Pose2D(), np.array([[1, 2], [3, 4]], np.float32))
    assert through(LASER, value).points_in_base_m.tolist() == [[1.0, 2.0], [3.0, 4.0]]


@pytest.mark.parametrize(
    "image",
    [
        np.zeros((4, 4, 3), np.float32),
        np.zeros((4, 4), np.uint8),
        np.zeros((4, 4, 4), np.uint8),
        None,
    ],
    ids=str,
)
def test_what_is_no_bgr_picture_is_refused(image: Any) -> None:
    with pytest.raises(DeviceError, match=r"must be uint8 of shape \(height, width, 3\)"):
        through(CAMERA, CameraFrame(1.0, 1, image))


@pytest.mark.parametrize("shape", [(0, 4, 3), (4, 0, 3), (1081, 1920, 3)])
def test_an_empty_or_too_large_picture_is_refused_with_the_limit(shape: tuple[int, int, int]) -> None:
    with pytest.raises(DeviceError, match=f"it must have 1 ... {MAX_PIXEL_BYTES}"):
        through(CAMERA, CameraFrame(1.0, 1, np.zeros(shape, np.uint8)))


def test_the_largest_picture_fits() -> None:
    image = np.zeros((1080, 1920, 3), np.uint8)
    image[-1, -1] = (1, 2, 3)
    assert through(CAMERA, CameraFrame(1.0, 1, image)).image_bgr[-1, -1].tolist() == [1, 2, 3]


def test_a_mirrored_or_cropped_view_is_stored_as_it_looks() -> None:
    image = np.arange(5 * 7 * 3, dtype=np.uint8).reshape(5, 7, 3)
    for view in (image[:, ::-1], image[1:4, 2:5], image[..., ::-1]):
        assert same(through(CAMERA, CameraFrame(1.0, 1, view)), CameraFrame(1.0, 1, view.copy()))


def test_the_wrong_value_for_a_channel_names_both_kinds() -> None:
    with pytest.raises(DeviceError, match="carries DetectionFrame, not RawDetectionFrame"):
        through(DET, RawDetectionFrame(1.0, 1))
    with pytest.raises(DeviceError, match="carries Detection, not str"):
        through(DET, DetectionFrame(1.0, 1, ("pin",)))


@given(hnp.arrays(np.uint8, st.integers(1, 60)), st.data())
def test_every_byte_of_a_picture_counts_in_its_sum(pixels: np.ndarray, data: st.DataObject) -> None:
    where = data.draw(st.integers(0, pixels.size - 1))
    changed = pixels.copy()
    changed[where] ^= data.draw(st.integers(1, 255))
    assert pixel_sum(changed) != pixel_sum(pixels)


@given(hnp.arrays(np.uint8, st.integers(0, 60)))
def test_the_sum_of_a_picture_is_that_of_its_words_filled_up_with_zeros(pixels: np.ndarray) -> None:
    raw = pixels.tobytes().ljust(64, b"\0")
    words = [int.from_bytes(raw[i : i + 8], "little") for i in range(0, 64, 8)]
    assert pixel_sum(pixels) == sum(words) % 2**64
