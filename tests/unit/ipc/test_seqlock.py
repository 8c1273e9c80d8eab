"""The newest-value channel: what a reader accepts, what it refuses, and whom it follows."""

from __future__ import annotations

import math
import os
from collections.abc import Callable
from pathlib import Path

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from target_nav.errors import DeviceError
from target_nav.ipc import header, seqlock, slots
from target_nav.ipc.channels import DET, LASER, NAV, open_reader, open_writer
from target_nav.ipc.files import path_of
from target_nav.ipc.header import CRC_AT, LOW, PAYLOAD_AT, lock_busy, lock_done
from target_nav.ipc.seqlock import SLOTS, TRIES, Reader, Writer
from target_nav.ipc.slots import Fault
from target_nav.state.types import DetectionFrame
from tests.unit.ipc.values import frame


def lock_word(writer: Writer[DetectionFrame], sequence: int) -> int:
    return writer._mapping.geometry.slot_at(sequence % SLOTS) // 4


def last_sequence(writer: Writer[DetectionFrame]) -> int:
    return writer._sequence - 1


# Reading


def test_a_reader_opened_before_its_writer_waits_for_it(prefix: str) -> None:
    with open_reader(DET, prefix) as reader:
        assert reader.latest() is None
        assert reader.take_new() is None
        assert reader.age_s(10.0) == math.inf
        with open_writer(DET, prefix) as writer:
            assert reader.latest() is None
            writer.write(frame(1))
            assert reader.latest() == frame(1)


def test_latest_stays_and_take_new_gives_each_value_once(prefix: str) -> None:
    with open_writer(DET, prefix) as writer, open_reader(DET, prefix) as reader:
        writer.write(frame(1))
        assert reader.take_new() == frame(1)
        assert reader.take_new() is None
        assert reader.latest() == reader.latest() == frame(1)
        writer.write(frame(2))
        writer.write(frame(3))
        assert reader.latest() == frame(3)
        assert reader.take_new() == frame(3)
        assert reader.take_new() is None


def test_every_reader_has_its_own_cursor(prefix: str) -> None:
    with open_writer(DET, prefix) as writer, open_reader(DET, prefix) as one, open_reader(DET, prefix) as two:
        writer.write(frame(1))
        assert one.take_new() == two.take_new() == frame(1)


def test_a_reader_opened_after_its_writer_has_closed_learns_the_last_word_and_its_age(prefix: str) -> None:
    with open_writer(DET, prefix) as writer:
        writer.write(frame(1, stamp_s=10.0))
    with open_reader(DET, prefix) as reader:
        assert reader.latest() == frame(1, stamp_s=10.0)
        assert reader.age_s(12.5) == 2.5


@pytest.mark.parametrize(
    ("stamp_s", "age_s"),
    [
        (10.0, 2.0),
        (12.5, 0.0),
        (1.7e9, math.inf),
        (math.nan, math.inf),
        (-math.inf, math.inf),
        (math.inf, math.inf),
    ],
)
def test_a_stamp_that_is_no_time_of_this_clock_is_infinitely_old(
    prefix: str, stamp_s: float, age_s: float
) -> None:
    with open_writer(DET, prefix) as writer, open_reader(DET, prefix) as reader:
        writer.write(frame(1, stamp_s))
        assert reader.age_s(12.0) == age_s


@settings(max_examples=50, deadline=None)
@given(steps=st.lists(st.sampled_from(["write", "take", "latest"]), max_size=40))
def test_any_mixture_of_writing_and_reading_gives_the_newest_and_never_goes_back(steps: list[str]) -> None:
    prefix = f"t{os.getpid()}-mixture"
    written, taken = 0, 0
    with open_writer(DET, prefix) as writer, open_reader(DET, prefix) as reader:
        for step in steps:
            if step == "write":
                written += 1
                writer.write(frame(written))
            elif step == "take":
                assert reader.take_new() == (frame(written) if written > taken else None)
                taken = written
            else:
                assert reader.latest() == (frame(written) if written else None)
    path_of(prefix, "det").unlink()


def test_statistics_count_what_was_accepted_and_written(prefix: str) -> None:
    with open_writer(DET, prefix) as writer, open_reader(DET, prefix) as reader:
        for i in range(10):
            writer.write(frame(i))
            reader.latest()
            reader.latest()
        assert reader.statistics == seqlock.ReaderStatistics(accepted=10)
        assert writer.statistics == seqlock.WriterStatistics(written=10)


# Torn, corrupt, stale


def test_a_slot_the_writer_is_at_is_not_accepted(prefix: str) -> None:
    with open_writer(DET, prefix) as writer, open_reader(DET, prefix) as reader:
        writer.write(frame(1))
        sequence = last_sequence(writer)
        writer._mapping.words[lock_word(writer, sequence)] = lock_busy(sequence + SLOTS)
        assert reader.latest() is None
        assert reader.statistics.torn == TRIES
        writer._mapping.words[lock_word(writer, sequence)] = lock_done(sequence)
        assert reader.latest() == frame(1)


def test_a_slot_rewritten_while_it_is_copied_is_torn(prefix: str) -> None:
    with open_writer(DET, prefix) as writer:
        writer.write(frame(1))
        sequence = last_sequence(writer)

        def lap(data: bytes, bulk_bytes: int) -> memoryview:
            for i in range(SLOTS):
                writer.write(frame(2 + i))
            return memoryview(bytearray(bulk_bytes))

        assert slots.load(writer._mapping, sequence % SLOTS, sequence & LOW, 24, lap) is Fault.TORN


def test_a_byte_changed_under_right_lock_words_is_caught_by_the_crc_wherever_it_is(prefix: str) -> None:
    with open_writer(DET, prefix) as writer, open_reader(DET, prefix) as reader:
        writer.write(frame(1))
        mapping = writer._mapping
        start = mapping.geometry.slot_at(last_sequence(writer) % SLOTS)
        length = mapping.words[(start + header.LENGTH_AT) // 4]
        for at in range(start + CRC_AT, start + PAYLOAD_AT + length):
            mapping.view[at] ^= 0x10
            assert reader.latest() is None, at - start
            mapping.view[at] ^= 0x10
        assert reader.statistics.crc_errors + reader.statistics.torn == TRIES * (PAYLOAD_AT - CRC_AT + length)
        assert reader.latest() == frame(1)


def test_a_length_no_payload_has_is_not_followed(prefix: str) -> None:
    with open_writer(DET, prefix) as writer, open_reader(DET, prefix) as reader:
        writer.write(frame(1))
        at = writer._mapping.geometry.slot_at(last_sequence(writer) % SLOTS)
        writer._mapping.words[(at + header.LENGTH_AT) // 4] = 0xFFFF_FFF0
        assert reader.latest() is None


def test_a_value_older_than_one_accepted_before_is_refused_once_and_for_all(prefix: str) -> None:
    with open_writer(DET, prefix) as writer, open_reader(DET, prefix) as reader:
        writer.write(frame(1))
        writer.write(frame(2))
        assert reader.take_new() == frame(2)
        slots.publish(writer._mapping, last_sequence(writer) - 1)
        assert reader.take_new() is None
        assert reader.take_new() is None
        assert reader.latest() == frame(2)
        assert reader.statistics.stale == 1


def test_a_slot_of_a_former_reign_is_refused_even_if_it_is_published(prefix: str) -> None:
    with open_writer(DET, prefix) as writer:
        writer.write(frame(0))
        writer.write(frame(1))
    with open_writer(DET, prefix) as successor, open_reader(DET, prefix) as reader:
        slots.publish(successor._mapping, last_sequence(successor))
        assert reader.latest() is None
        successor.write(frame(2))
        slots.publish(successor._mapping, last_sequence(successor) - 1)
        assert reader.latest() is None
        slots.publish(successor._mapping, last_sequence(successor) - 2)
        assert reader.latest() is None
        slots.publish(successor._mapping, last_sequence(successor))
        assert reader.latest() == frame(2)


def test_a_channel_nothing_was_written_to_is_not_mistaken_for_a_torn_one(prefix: str) -> None:
    with open_writer(DET, prefix), open_reader(DET, prefix) as reader:
        assert reader.latest() is None
        assert reader.statistics == seqlock.ReaderStatistics()


def test_nonsense_with_a_right_crc_is_an_error_that_names_the_channel(prefix: str) -> None:
    with open_writer(DET, prefix) as writer, open_reader(DET, prefix) as reader:
        encoded = writer._codec.encode(frame(1), writer._buffer, PAYLOAD_AT)
        writer._buffer[PAYLOAD_AT + 16] = 65
        slots.store(writer._mapping, writer._sequence % SLOTS, writer._sequence, writer._buffer, encoded)
        slots.publish(writer._mapping, writer._sequence)
        with pytest.raises(DeviceError, match=f"{prefix}_det has the right layout but holds nonsense"):
            reader.latest()


def test_a_value_that_cannot_be_written_leaves_the_last_one_in_place(prefix: str) -> None:
    with open_writer(DET, prefix) as writer, open_reader(DET, prefix) as reader:
        writer.write(frame(1))
        with pytest.raises(DeviceError, match=r"DetectionFrame\.frame_id is 9223372036854775808"):
            writer.write(frame(2**63))
        assert reader.latest() == frame(1)


# Numbers that wrap


@pytest.mark.parametrize("modulus", [2**31, 2**32])
def test_counters_wrap_without_a_lost_or_repeated_value(prefix: str, modulus: int) -> None:
    start: Callable[[], int] = lambda: 5 * modulus - 6  # noqa: E731
    path = path_of(prefix, "det")
    with Writer(path, DET.codec, clock_ns=start) as writer, Reader(path, DET.codec) as reader:
        for i in range(12):
            writer.write(frame(i))
            assert reader.take_new() == frame(i)
            assert reader.take_new() is None
        assert reader.statistics == seqlock.ReaderStatistics(accepted=12)


def test_prefixes_and_channels_do_not_meet(prefix: str) -> None:
    other = f"{prefix}_b"
    with open_writer(DET, prefix) as one, open_writer(DET, other) as two, open_reader(DET, other) as reader:
        one.write(frame(1))
        assert reader.latest() is None
        two.write(frame(2))
        assert reader.latest() == frame(2)
        assert open_reader(NAV, prefix).latest() is None
        assert open_reader(LASER, prefix).latest() is None
    assert {p.name for p in Path("/dev/shm").glob(f"{prefix}_*")} == {f"{prefix}_det", f"{other}_det"}
