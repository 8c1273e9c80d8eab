"""The protocol of one slot: store so that a reader can tell, load so that nothing torn gets through.

Writer: lock odd (busy), payload as one slice, lock even (done), then `published`. Reader: lock is the done-value of the
sequence wanted, copy, lock is still that, and the copy's own sequence and CRC-32 agree. Both lock words carry the
sequence, so a slot that was rewritten twice meanwhile does not look untouched.

On x86-64 stores become visible in program order and the lock words alone are exact. On AArch64 they need not: a copy
may then hold old bytes under right lock words. That is what the CRC is for; it turns such a copy into one more try.
"""

from __future__ import annotations

import zlib
from collections.abc import Callable
from enum import Enum
from struct import Struct
from typing import NamedTuple

from target_nav.ipc import header
from target_nav.ipc.codecs import Encoded
from target_nav.ipc.files import Mapping
from target_nav.ipc.header import CRC_AT, LENGTH_AT, LOW, PAYLOAD_AT, SEQUENCE_AT, lock_busy, lock_done

_SEALED = Struct("<QII")
"""sequence, length, reserved: what the CRC covers before the payload."""
_READ = Struct("<IQI")
"""crc, sequence, length: a slot from `CRC_AT` on."""


class Fault(Enum):
    TORN = "torn"
    CRC = "crc"


class Loaded(NamedTuple):
    """`data` is a private copy of the slot from its CRC on; the payload begins at `PAYLOAD_IN_DATA`."""

    sequence: int
    data: bytes


PAYLOAD_IN_DATA = PAYLOAD_AT - CRC_AT

BulkSink = Callable[[bytes, int], "memoryview | None"]
"""(data, bytes of bulk) -> where to copy them, None if that cannot be right."""


def private_buffer(head_bytes: int) -> bytearray:
    """Where a writer builds a slot: laid out as the slot is, so it can be stored as one slice."""
    return bytearray(PAYLOAD_AT + head_bytes)


def store(mapping: Mapping, index: int, sequence: int, buffer: bytearray, encoded: Encoded) -> None:
    """Stores a payload built at `PAYLOAD_AT` of `buffer`. Does not publish it."""
    at = mapping.geometry.slot_at(index)
    end = PAYLOAD_AT + encoded.length
    bulk = encoded.bulk
    length = encoded.length + (bulk.nbytes if bulk is not None else 0)
    mapping.reserve(PAYLOAD_AT + length)
    private = memoryview(buffer)
    _SEALED.pack_into(buffer, SEQUENCE_AT, sequence, length, 0)
    buffer[CRC_AT:SEQUENCE_AT] = zlib.crc32(private[SEQUENCE_AT:end]).to_bytes(4, "little")
    words, view = mapping.words, mapping.view
    words[at >> 2] = lock_busy(sequence)
    view[at + CRC_AT : at + end] = private[CRC_AT:end]
    if bulk is not None:
        view[at + end : at + PAYLOAD_AT + length] = bulk
    words[at >> 2] = lock_done(sequence)


def publish(mapping: Mapping, sequence: int) -> None:
    mapping.words[header.PUBLISHED] = sequence & LOW


def load(
    mapping: Mapping,
    index: int,
    sequence_low: int,
    bulk_from: int | None = None,
    sink: BulkSink | None = None,
) -> Loaded | Fault:
    """A private, verified copy of the payload whose sequence ends in `sequence_low`.

    `bulk_from` is where a payload's bulk begins, which goes to `sink`'s buffer and has to be verified by the caller.
    """
    geometry, words, view = mapping.geometry, mapping.words, mapping.view
    at = geometry.slot_at(index)
    expected = lock_done(sequence_low)
    if words[at >> 2] != expected:
        return Fault.TORN
    length = words[(at + LENGTH_AT) >> 2]
    if length > geometry.payload_bytes:
        return Fault.TORN
    head = length if bulk_from is None else min(length, bulk_from)
    data = bytes(view[at + CRC_AT : at + PAYLOAD_AT + head])
    if bulk_from is not None and sink is not None:
        target = sink(data, length - head)
        if target is None:
            return Fault.TORN
        target[:] = view[at + PAYLOAD_AT + head : at + PAYLOAD_AT + length]
    if words[at >> 2] != expected:
        return Fault.TORN
    crc, sequence, length_copied = _READ.unpack_from(data)
    if crc != zlib.crc32(memoryview(data)[4:]) or length_copied != length or sequence & LOW != sequence_low:
        return Fault.CRC
    return Loaded(sequence, data)


def newest_sequence(mapping: Mapping, head_bytes: int) -> tuple[int, int]:
    """(highest sequence in a valid slot or 0, slots repaired): for a writer that takes over, before it writes.

    A slot that a dead predecessor left half-written, or that fails its CRC, is marked as never written.
    """
    highest, repaired = 0, 0
    for index in range(mapping.geometry.slot_count):
        at = mapping.geometry.slot_at(index) >> 2
        sequence_word = at + SEQUENCE_AT // 4
        low, high = mapping.words[sequence_word], mapping.words[sequence_word + 1]
        if mapping.words[at] == low == high == 0:
            continue
        loaded = load(mapping, index, low, head_bytes)
        if isinstance(loaded, Fault):
            for word in (at, sequence_word, sequence_word + 1):
                mapping.words[word] = 0
            repaired += 1
        else:
            highest = max(highest, loaded.sequence)
    return highest, repaired


class Reign(NamedTuple):
    """One writer's time: `generation` is the first sequence it may use, `repaired` the slots it had to clean."""

    generation: int
    repaired: int


def take_over(mapping: Mapping, head_bytes: int, pid: int, fresh_sequence: int) -> Reign:
    """Makes this process the file's writer in the header. The caller holds the lock.

    Sequences go on from the predecessor's. In a new file they begin at `fresh_sequence`, the monotonic clock in
    nanoseconds, so they do not go back when a file was removed and made again.
    """
    words = mapping.words
    highest, repaired = newest_sequence(mapping, head_bytes)
    previous, _ = read_reign(mapping)
    generation = max(highest + 1, previous or fresh_sequence)
    changing = words[header.CLAIM] | 1
    words[header.CLAIM] = changing
    words[header.PID] = pid
    words[header.GENERATION_LOW] = generation & LOW
    words[header.GENERATION_HIGH] = generation >> 32
    publish(mapping, generation - 1)
    words[header.CLAIM] = (changing + 1) & LOW
    return Reign(generation, repaired)


def read_reign(mapping: Mapping) -> tuple[int, int]:
    """(generation, pid) as they stand in the header."""
    words = mapping.words
    return words[header.GENERATION_HIGH] << 32 | words[header.GENERATION_LOW], words[header.PID]


def stable_reign(mapping: Mapping) -> tuple[int, int] | None:
    """(generation, claim word), or None while a writer is just taking over, or before the first one ever did."""
    words = mapping.words
    before = words[header.CLAIM]
    generation, _ = read_reign(mapping)
    if before & 1 or generation == 0 or words[header.CLAIM] != before:
        return None
    return generation, before
