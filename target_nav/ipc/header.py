"""What stands before the payloads of a channel's file: who writes, which layout, which slot is the newest.

Every word that one process changes while another looks is an aligned uint32 of its own, written and read in one
machine instruction through `memoryview.cast("I")`. (`struct.pack_into` zero-fills first: measured, 8 % of polls saw 0.)
"""

from __future__ import annotations

import zlib
from dataclasses import dataclass

from target_nav.ipc.cstruct import CStruct, Member, declare, round_up

MAGIC = b"TNAVSHM1"
LAYOUT_VERSION = 2
"""Counted up with every change of the protocol or of a layout; the fingerprint catches a change nobody counted."""

LINE_BYTES = 64
"""A cache line: slots begin on one, and the word that readers poll has one to itself."""

FILE_HEADER = declare(
    "FileHeader",
    [
        Member("magic", "char", 8),
        Member("layout_version", "uint32_t"),
        Member("layout_hash", "uint32_t"),
        Member("ready", "uint32_t"),
        Member("claim", "uint32_t"),
        Member("writer_pid", "uint32_t"),
        Member("generation_low", "uint32_t"),
        Member("generation_high", "uint32_t"),
        Member("slot_count", "uint32_t"),
        Member("slot_bytes", "uint32_t"),
        Member("payload_bytes", "uint32_t"),
        Member("layout_name", "char", 32),
        Member("reserved", "uint32_t", 12),
        Member("published", "uint32_t"),
        Member("reserved_line", "uint32_t", 15),
    ],
)
"""The offsets of magic, version, hash, claim and pid never change, so any version can name the writer of any other."""

SLOT_HEADER = declare(
    "SlotHeader",
    [
        Member("lock", "uint32_t"),
        Member("crc", "uint32_t"),
        Member("sequence", "uint64_t"),
        Member("length", "uint32_t"),
        Member("reserved", "uint32_t"),
    ],
)
"""`crc` is the CRC-32 of all that follows it in the slot, of bulk pixels excepted. `length` is the payload's."""

LOW = 0xFFFF_FFFF


def word(name: str) -> int:
    """Index of a header word in the file seen as uint32."""
    return FILE_HEADER[name].offset // 4


READY, CLAIM, PID, PUBLISHED = word("ready"), word("claim"), word("writer_pid"), word("published")
GENERATION_LOW, GENERATION_HIGH = word("generation_low"), word("generation_high")

CRC_AT = SLOT_HEADER["crc"].offset
SEQUENCE_AT = SLOT_HEADER["sequence"].offset
LENGTH_AT = SLOT_HEADER["length"].offset
PAYLOAD_AT = SLOT_HEADER.size


def lock_busy(sequence: int) -> int:
    return ((sequence << 1) | 1) & LOW


def lock_done(sequence: int) -> int:
    return (sequence << 1) & LOW


@dataclass(frozen=True)
class Geometry:
    """The shape of a channel's file. `slot_count` is a power of two: a wrapped counter still names the right slot."""

    layout: CStruct
    slot_count: int

    def __post_init__(self) -> None:
        if self.slot_count & (self.slot_count - 1):
            raise ValueError(f"slot_count is {self.slot_count}; it must be a power of two")

    @property
    def payload_bytes(self) -> int:
        return self.layout.size

    @property
    def slot_bytes(self) -> int:
        return round_up(PAYLOAD_AT + self.payload_bytes, LINE_BYTES)

    @property
    def file_bytes(self) -> int:
        return FILE_HEADER.size + self.slot_count * self.slot_bytes

    def slot_at(self, index: int) -> int:
        return FILE_HEADER.size + index * self.slot_bytes

    @property
    def layout_hash(self) -> int:
        text = "\n".join(
            [FILE_HEADER.text(), SLOT_HEADER.text(), self.layout.text(), f"slots {self.slot_count}"]
        )
        return zlib.crc32(text.encode())
