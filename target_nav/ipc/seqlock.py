"""The newest-value channel: one writer, any number of readers, no locks between them.

Four slots are written in turn, so a reader has the time of three writes to copy the newest one. A reader accepts a
value only if it is whole, newer than what it accepted before, and of the present writer's reign.

Writers and readers are for one thread each.
"""

from __future__ import annotations

import math
import os
import struct
import time
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from types import TracebackType
from typing import Generic, TypeVar

from target_nav.errors import DeviceError
from target_nav.ipc import files, header, slots
from target_nav.ipc.codecs import Codec
from target_nav.ipc.files import Mapping
from target_nav.ipc.header import LOW, PAYLOAD_AT, Geometry
from target_nav.ipc.slots import PAYLOAD_IN_DATA, BulkSink, Fault, Loaded

T = TypeVar("T")

SLOTS = 4
_STAMP = struct.Struct("<d")
TRIES = 16
"""Copies a reader attempts in one call before it is content with what it has."""

CLOCK_SKEW_S = 1.0
"""A stamp farther in the future than this is not of this machine's monotonic clock."""


@dataclass(frozen=True)
class ReaderStatistics:
    accepted: int = 0
    """Values accepted."""
    torn: int = 0
    """Copies thrown away because the writer was at that slot meanwhile; each was tried again."""
    crc_errors: int = 0
    """Copies thrown away though the lock words agreed."""
    stale: int = 0
    """Values refused because they are older than one accepted before, or of a former writer's reign."""
    reopened: int = 0
    """Times the file was made anew and followed, or another writer took it over."""


@dataclass(frozen=True)
class WriterStatistics:
    written: int = 0
    dropped_items: int = 0
    """Detections or points that did not fit."""
    repaired: int = 0
    """Slots found half-written by a dead predecessor."""
    reclaimed: int = 0
    """Times the file had been removed under this writer and was made again."""


class Writer(Generic[T]):
    """The only writer of a channel. Raises DeviceError on opening if another live process is."""

    def __init__(
        self,
        path: Path,
        codec: Codec[T],
        slot_count: int = SLOTS,
        clock_ns: Callable[[], int] = time.monotonic_ns,
    ) -> None:
        self._path, self._codec, self._clock_ns = path, codec, clock_ns
        self._geometry = Geometry(codec.layout, slot_count)
        self._buffer = slots.private_buffer(codec.head_bytes)
        self._mapping: Mapping | None = None
        self._written = self._dropped = self._repaired = self._reclaimed = 0
        self._claim()

    @property
    def name(self) -> str:
        return self._path.name

    @property
    def statistics(self) -> WriterStatistics:
        return WriterStatistics(self._written, self._dropped, self._repaired, self._reclaimed)

    def write(self, value: T) -> None:
        """Publishes `value` to every reader.

        Raises:
            DeviceError: a value the layout cannot hold (the channel keeps its last one), or the file was removed and
                another process has claimed the name since.
        """
        encoded = self._codec.encode(value, self._buffer, PAYLOAD_AT)
        mapping = self._held()
        slots.store(
            mapping, self._sequence & (self._geometry.slot_count - 1), self._sequence, self._buffer, encoded
        )
        slots.publish(mapping, self._sequence)
        self._sequence += 1
        self._written += 1
        self._dropped += encoded.dropped

    def close(self) -> None:
        """Gives the channel up; its last value stays readable. May be called twice."""
        mapping, self._mapping = self._mapping, None
        if mapping is not None:
            mapping.close()

    def _held(self) -> Mapping:
        mapping = self._mapping
        if mapping is None:
            raise DeviceError(f"{self.name} is closed; open it again before writing")
        if mapping.removed:
            # Somebody cleaned up /dev/shm (systemd's RemoveIPC does at logout): readers would never hear of us again.
            self.close()
            self._reclaimed += 1
            mapping = self._claim()
        return mapping

    def _claim(self) -> Mapping:
        mapping = files.claim(self._path, self._geometry)
        try:
            reign = slots.take_over(mapping, self._codec.head_bytes, os.getpid(), self._clock_ns())
            mapping.reserve(PAYLOAD_AT + min(self._codec.head_bytes, 1 << 16))
        except BaseException:
            mapping.close()
            raise
        self._sequence = reign.generation
        self._repaired += reign.repaired
        self._mapping = mapping
        return mapping

    def __enter__(self) -> Writer[T]:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.close()

    def __del__(self) -> None:
        if getattr(self, "_mapping", None) is not None:
            self.close()


class Reader(Generic[T]):
    """Follows a channel through absence, restarts of its writer and re-created files."""

    def __init__(self, path: Path, codec: Codec[T], slot_count: int = SLOTS) -> None:
        self._path, self._codec = path, codec
        self._geometry = Geometry(codec.layout, slot_count)
        self._mapping: Mapping | None = None
        self._claim_word = -1
        self._generation = 0
        self._accepted_sequence = self._value_sequence = self._taken_sequence = 0
        self._refused_sequence = 0
        self._value: T | None = None
        self._stamp_s = -math.inf
        self._accepted = self._torn = self._crc_errors = self._stale = self._reopened = 0

    @property
    def name(self) -> str:
        return self._path.name

    @property
    def statistics(self) -> ReaderStatistics:
        return ReaderStatistics(self._accepted, self._torn, self._crc_errors, self._stale, self._reopened)

    def latest(self) -> T | None:
        """The newest value ever accepted, None when there was none yet; `age_s` says how old it is.

        Raises:
            DeviceError: a live writer uses another layout or writes nonsense, or the file is not a channel.
        """
        self._poll()
        return self._value

    def take_new(self) -> T | None:
        """The newest value, once: None until a newer one has come. Raises as `latest` does."""
        self._poll()
        if self._value_sequence == self._taken_sequence:
            return None
        self._taken_sequence = self._value_sequence
        return self._value

    def age_s(self, now_s: float) -> float:
        """Age of the newest value by its own stamp; inf if there is none or its stamp is no time of this clock."""
        self._poll()
        age_s = now_s - self._stamp_s
        if not math.isfinite(age_s) or age_s < -CLOCK_SKEW_S:
            return math.inf
        return max(age_s, 0.0)

    def close(self) -> None:
        """Lets the file go; the last value stays. May be called twice; a later read opens it again."""
        mapping, self._mapping = self._mapping, None
        self._claim_word = -1
        if mapping is not None:
            mapping.close()

    def __enter__(self) -> Reader[T]:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.close()

    def __del__(self) -> None:
        if getattr(self, "_mapping", None) is not None:
            self.close()

    def _poll(self) -> None:
        loaded = self._fetch(self._value_sequence)
        if loaded is not None:
            self._value = self._decode(loaded)
            self._value_sequence = loaded.sequence

    def _decode(self, loaded: Loaded) -> T:
        try:
            value = self._codec.decode(loaded.data, PAYLOAD_IN_DATA, None)
        except (struct.error, ValueError) as error:
            raise DeviceError(
                f"{self.name} has the right layout but holds nonsense ({error}); restart its writer"
            ) from error
        return value

    def _fetch(self, after: int, sink: BulkSink | None = None) -> Loaded | None:
        """The newest payload if its sequence is not `after`. Follows a file that was made anew."""
        for _ in range(2):
            if self._mapping is None:
                self._mapping = files.open_for_reading(self._path, self._geometry)
            if self._mapping is None:
                return None
            loaded = self._fetch_from(self._mapping, after, sink)
            if loaded is not None:
                (self._stamp_s,) = _STAMP.unpack_from(loaded.data, PAYLOAD_IN_DATA)
                return loaded
            # Nothing new: perhaps because the writer writes another file of the same name by now.
            if files.inode_of(self._path) in (None, self._mapping.inode):
                return None
            self.close()
            self._reopened += 1
        return None

    def _fetch_from(self, mapping: Mapping, after: int, sink: BulkSink | None) -> Loaded | None:
        words = mapping.words
        if words[header.CLAIM] != self._claim_word:
            reign = slots.stable_reign(mapping)
            if reign is None:
                return None
            self._reopened += self._claim_word >= 0
            self._generation, self._claim_word = reign
        nothing = (after & LOW, (self._generation - 1) & LOW)
        for _ in range(TRIES):
            low = words[header.PUBLISHED]
            if low in nothing:
                return None
            index = low & (self._geometry.slot_count - 1)
            loaded = slots.load(mapping, index, low, self._codec.bulk_from, sink)
            if isinstance(loaded, Loaded) and not self._bulk_intact(loaded):
                loaded = Fault.CRC
            if loaded is Fault.TORN:
                self._torn += 1
            elif loaded is Fault.CRC:
                self._crc_errors += 1
            elif isinstance(loaded, Loaded):
                return loaded if self._newer(loaded.sequence) else None
        return None

    def _newer(self, sequence: int) -> bool:
        if sequence < self._generation or sequence < self._accepted_sequence:
            self._stale += sequence != self._refused_sequence
            self._refused_sequence = sequence
            return False
        self._accepted += sequence > self._accepted_sequence
        self._accepted_sequence = sequence
        return True

    def _bulk_intact(self, loaded: Loaded) -> bool:
        """For channels with bulk, which lies outside the CRC."""
        return True
