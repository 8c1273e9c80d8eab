"""Writers that die, come back, or lose their file: whom a reader follows, and what of the dead it still believes."""

from __future__ import annotations

import pytest

from target_nav.errors import DeviceError
from target_nav.ipc import files, header, seqlock, slots
from target_nav.ipc.channels import DET, open_reader, open_writer
from target_nav.ipc.files import path_of
from target_nav.ipc.header import CRC_AT, PAYLOAD_AT, lock_busy
from target_nav.ipc.seqlock import SLOTS
from tests.unit.ipc.values import frame


def test_a_restarted_writer_is_picked_up_and_its_predecessors_slots_are_not(prefix: str) -> None:
    with open_reader(DET, prefix) as reader:
        for run in range(3):
            with open_writer(DET, prefix) as writer:
                fresh = open_reader(DET, prefix)
                assert fresh.latest() is None, "the last word of a former reign is not this writer's"
                fresh.close()
                writer.write(frame(run))
                assert reader.take_new() == frame(run)
        assert reader.statistics.accepted == 3
        assert reader.statistics.reopened == 2
        assert reader.statistics.stale == 0


def test_a_slot_left_half_written_is_repaired_by_the_successor(prefix: str) -> None:
    with open_reader(DET, prefix) as reader:
        writer = open_writer(DET, prefix)
        for i in range(6):
            writer.write(frame(i))
        sequence, mapping, word = (
            writer._sequence,
            writer._mapping,
            writer._mapping.geometry.slot_at(writer._sequence % SLOTS) // 4,
        )
        mapping.words[word] = lock_busy(sequence)
        at = mapping.geometry.slot_at(sequence % SLOTS)
        mapping.view[at + CRC_AT : at + 90] = bytes(range(86))
        writer.close()
        assert reader.latest() == frame(5)
        with open_writer(DET, prefix) as successor:
            assert successor.statistics.repaired == 1
            assert successor._sequence == sequence
            assert successor._mapping.words[word] == 0
            for i in range(6, 12):
                successor.write(frame(i))
                assert reader.take_new() == frame(i)
        with open_writer(DET, prefix) as third:
            assert third.statistics.repaired == 0


def test_a_writer_that_died_before_it_published_does_not_confuse_its_successor(prefix: str) -> None:
    with open_reader(DET, prefix) as reader:
        writer = open_writer(DET, prefix)
        writer.write(frame(1))
        encoded = writer._codec.encode(frame(2), writer._buffer, PAYLOAD_AT)
        slots.store(writer._mapping, writer._sequence % SLOTS, writer._sequence, writer._buffer, encoded)
        writer.close()
        assert reader.latest() == frame(1)
        with open_writer(DET, prefix) as successor:
            assert reader.take_new() == frame(1)
            successor.write(frame(3))
            assert reader.take_new() == frame(3)


def test_while_a_writer_takes_over_readers_keep_what_they_have(prefix: str) -> None:
    with open_writer(DET, prefix) as writer, open_reader(DET, prefix) as reader:
        writer.write(frame(1))
        assert reader.latest() == frame(1)
        writer._mapping.words[header.CLAIM] |= 1
        writer.write(frame(2))
        assert reader.latest() == frame(1)
        # It died there; the next one finishes.
        writer.close()
        with open_writer(DET, prefix) as successor:
            assert successor._mapping.words[header.CLAIM] % 2 == 0
            successor.write(frame(3))
            assert reader.latest() == frame(3)


def test_a_new_file_no_writer_has_taken_over_yet_says_nothing(prefix: str) -> None:
    path = path_of(prefix, "det")
    with open_reader(DET, prefix) as reader:
        with open_writer(DET, prefix) as writer:
            writer.write(frame(1))
            assert reader.latest() == frame(1)
        path.unlink()
        mapping = files.claim(path, DET.geometry)
        assert reader.latest() == frame(1)
        mapping.close()
        with open_writer(DET, prefix) as writer:
            writer.write(frame(2))
            assert reader.latest() == frame(2)
        assert reader.statistics == seqlock.ReaderStatistics(accepted=2, reopened=1)


def test_a_file_that_was_removed_and_made_again_is_followed(prefix: str) -> None:
    with open_reader(DET, prefix) as reader:
        for run in range(3):
            with open_writer(DET, prefix) as writer:
                writer.write(frame(run))
                assert reader.take_new() == frame(run)
            path_of(prefix, "det").unlink()
            assert reader.latest() == frame(run), "what was accepted stays"
        assert reader.statistics.reopened == 2


def test_a_writer_whose_file_was_removed_under_it_makes_it_again(prefix: str) -> None:
    with open_writer(DET, prefix) as writer, open_reader(DET, prefix) as reader:
        writer.write(frame(1))
        assert reader.latest() == frame(1)
        path_of(prefix, "det").unlink()
        writer.write(frame(2))
        assert reader.latest() == frame(2)
        assert writer.statistics.reclaimed == 1


def test_a_writer_whose_name_was_taken_meanwhile_says_who_has_it(prefix: str) -> None:
    with open_writer(DET, prefix) as writer:
        path_of(prefix, "det").unlink()
        with open_writer(DET, prefix), pytest.raises(DeviceError, match=f"writes {prefix}_det; stop it"):
            writer.write(frame(1))


def test_a_closed_writer_says_so(prefix: str) -> None:
    writer = open_writer(DET, prefix)
    writer.close()
    writer.close()
    with pytest.raises(DeviceError, match=f"{prefix}_det is closed"):
        writer.write(frame(1))


def test_a_closed_reader_opens_again_where_it_was(prefix: str) -> None:
    with open_writer(DET, prefix) as writer, open_reader(DET, prefix) as reader:
        writer.write(frame(1))
        assert reader.take_new() == frame(1)
        reader.close()
        assert reader.latest() == frame(1)
        assert reader.take_new() is None
        writer.write(frame(2))
        assert reader.take_new() == frame(2)


def test_a_forgotten_writer_gives_its_claim_back(prefix: str) -> None:
    writer = open_writer(DET, prefix)
    del writer
    open_writer(DET, prefix).close()
