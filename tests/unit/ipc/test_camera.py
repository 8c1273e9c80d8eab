"""Pictures: copied once, verified after copying, into memory of the reader's choice."""

from __future__ import annotations

import numpy as np
import pytest

from target_nav.errors import DeviceError
from target_nav.ipc.channels import CAMERA, SIM_CAMERA, open_reader, open_writer
from target_nav.ipc.header import PAYLOAD_AT
from target_nav.ipc.seqlock import SLOTS, TRIES
from target_nav.state.snapshots import CameraFrame
from tests.unit.ipc.values import picture, same


@pytest.mark.parametrize("channel", [CAMERA, SIM_CAMERA], ids=lambda c: c.name)
def test_a_picture_arrives_whole_and_once(prefix: str, channel) -> None:
    with open_writer(channel, prefix) as writer, open_reader(channel, prefix) as reader:
        writer.write(picture(1))
        assert same(reader.take_new(), picture(1))
        assert reader.take_new() is None
        assert reader.latest() is reader.latest()


def test_the_two_cameras_are_two_channels_of_one_layout(prefix: str) -> None:
    assert CAMERA.geometry == SIM_CAMERA.geometry
    with open_writer(SIM_CAMERA, prefix) as writer, open_reader(CAMERA, prefix) as reader:
        writer.write(picture(1))
        assert reader.latest() is None


def test_a_picture_handed_out_never_changes_and_cannot_be_drawn_on(prefix: str) -> None:
    with open_writer(CAMERA, prefix) as writer, open_reader(CAMERA, prefix) as reader:
        held = []
        for i in range(3 * SLOTS):
            writer.write(picture(i))
            held.append(reader.latest())
        assert all(same(frame, picture(i)) for i, frame in enumerate(held))
        with pytest.raises(ValueError, match="read-only"):
            held[0].image_bgr[0, 0] = 1


def test_pictures_may_change_their_size(prefix: str) -> None:
    with open_writer(CAMERA, prefix) as writer, open_reader(CAMERA, prefix) as reader:
        for shape in [(6, 8), (480, 640), (3, 5), (1080, 1920), (6, 8)]:
            writer.write(picture(7, shape))
            assert same(reader.take_new(), picture(7, shape))


def test_read_into_fills_the_callers_buffer_and_takes_the_picture(prefix: str) -> None:
    buffer = np.zeros((6, 8, 3), np.uint8)
    with open_writer(CAMERA, prefix) as writer, open_reader(CAMERA, prefix) as reader:
        assert reader.read_into(buffer) is None
        writer.write(picture(1))
        frame = reader.read_into(buffer)
        assert same(frame, picture(1))
        assert np.shares_memory(frame.image_bgr, buffer)
        assert reader.read_into(buffer) is None
        assert reader.take_new() is None
        assert same(reader.latest(), picture(1))
        assert not np.shares_memory(reader.latest().image_bgr, buffer)
        assert reader.statistics.accepted == 1


def test_read_into_a_flat_and_larger_buffer_uses_its_beginning(prefix: str) -> None:
    buffer = np.full(1000, 9, np.uint8)
    with open_writer(CAMERA, prefix) as writer, open_reader(CAMERA, prefix) as reader:
        writer.write(picture(1))
        assert same(reader.read_into(buffer), picture(1))
        assert (buffer[6 * 8 * 3 :] == 9).all()


def test_a_buffer_that_cannot_hold_the_picture_is_refused_with_both_sizes(prefix: str) -> None:
    with open_writer(CAMERA, prefix) as writer, open_reader(CAMERA, prefix) as reader:
        writer.write(picture(1))
        with pytest.raises(
            DeviceError, match=r"the buffer has 100 bytes; a picture of \(6, 8, 3\) needs 144"
        ):
            reader.read_into(np.zeros(100, np.uint8))
        read_only = np.zeros(144, np.uint8)
        read_only.flags.writeable = False
        for buffer in (np.zeros(144, np.float32), np.zeros((6, 16, 3), np.uint8)[:, ::2], read_only):
            with pytest.raises(DeviceError, match="contiguous, writable uint8"):
                reader.read_into(buffer)
        assert same(reader.take_new(), picture(1))


def test_pixels_changed_under_right_lock_words_are_caught_by_their_sum(prefix: str) -> None:
    with open_writer(CAMERA, prefix) as writer, open_reader(CAMERA, prefix) as reader:
        writer.write(picture(1))
        start = writer._mapping.geometry.slot_at((writer._sequence - 1) % SLOTS) + PAYLOAD_AT
        for at in (CAMERA.codec.head_bytes, CAMERA.codec.head_bytes + 6 * 8 * 3 - 1):
            writer._mapping.view[start + at] ^= 1
            assert reader.latest() is None
            writer._mapping.view[start + at] ^= 1
        assert reader.statistics.crc_errors == 2 * TRIES
        assert same(reader.latest(), picture(1))


def test_a_picture_overtaken_while_it_is_copied_is_tried_again(prefix: str, monkeypatch) -> None:
    with open_writer(CAMERA, prefix) as writer, open_reader(CAMERA, prefix) as reader:
        writer.write(picture(0))
        allocate, overtakings = reader._allocate, iter(range(2))

        def overtaken(data: bytes, bulk_bytes: int) -> memoryview | None:
            for turn in overtakings:
                for i in range(SLOTS):
                    writer.write(picture(10 * turn + i))
                break
            return allocate(data, bulk_bytes)

        monkeypatch.setattr(reader, "_allocate", overtaken)
        assert same(reader.take_new(), picture(13))
        assert reader.statistics.torn == 2
        assert reader.statistics.crc_errors == 0


def test_memory_is_taken_for_the_pictures_in_use_only(prefix: str, monkeypatch) -> None:
    from target_nav.ipc.files import path_of

    with open_writer(CAMERA, prefix) as writer:
        writer.write(CameraFrame(1.0, 1, np.ones((48, 64, 3), np.uint8)))
        status = path_of(prefix, "camera").stat()
        assert status.st_size == CAMERA.geometry.file_bytes > 20_000_000
        assert status.st_blocks * 512 < 200_000
