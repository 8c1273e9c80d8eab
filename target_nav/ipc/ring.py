"""The command channel: every command arrives, in order, and the last word an operator has is STOP.

Two files, each with one writer: `cmd` is the ring the GUI writes, `cmd_ack` the reader's answer (how far it has read),
by which the writer sees that somebody listens and how full the ring is.

- A command that nobody would read is refused, not kept: a robot that starts later must not drive off on an old GO.
- A full ring refuses (`push` returns False, `statistics` counts). Its last place is kept for STOP. So in a ring with no
  place left the newest command is a STOP already, and one more of it says nothing new: no STOP is ever lost.
- A reader takes nothing that was pushed before it opened, by the time of the push, not by position.
"""

from __future__ import annotations

import os
import time
from dataclasses import dataclass
from pathlib import Path

from target_nav.errors import DeviceError
from target_nav.ipc import files, header, slots
from target_nav.ipc.codecs import PlainCodec
from target_nav.ipc.files import Mapping
from target_nav.ipc.header import LOW, PAYLOAD_AT, SEQUENCE_AT, Geometry
from target_nav.ipc.seqlock import TRIES, Reader, Writer
from target_nav.ipc.slots import PAYLOAD_IN_DATA, Fault
from target_nav.state.types import Command, CommandKind

RING_SLOTS = 64


@dataclass(frozen=True)
class PushedCommand:
    """A command in the ring. `pushed_ns` is the monotonic time of the push; `stamp_s` is the command's own."""

    stamp_s: float
    pushed_ns: int
    command: Command


@dataclass(frozen=True)
class CommandAck:
    """How far the reader has read: the sequence of the newest command it took or skipped."""

    stamp_s: float
    consumed: int


@dataclass(frozen=True)
class CommandWriterStatistics:
    pushed: int = 0
    refused_full: int = 0
    refused_unheard: int = 0
    """Nobody reads: the nav process does not run, or has not opened the channel yet."""
    repaired: int = 0
    """Places found half-written by a dead predecessor."""


@dataclass(frozen=True)
class CommandReaderStatistics:
    accepted: int = 0
    skipped_old: int = 0
    """Pushed before this reader opened."""
    crc_errors: int = 0
    reopened: int = 0


COMMAND_CODEC = PlainCodec(PushedCommand)
ACK_CODEC = PlainCodec(CommandAck)
_GEOMETRY = Geometry(COMMAND_CODEC.layout, RING_SLOTS)


class CommandWriter:
    """The one live writer of commands; a GUI may keep it, or open it for one push.

    Raises DeviceError on opening if another live process has it open.
    """

    def __init__(self, path: Path, ack_path: Path) -> None:
        self._path, self._ack_path = path, ack_path
        self._buffer = slots.private_buffer(COMMAND_CODEC.head_bytes)
        self._ack = Reader(ack_path, ACK_CODEC)
        self._pushed = self._full = self._unheard = self._repaired = 0
        self._mapping: Mapping | None = None
        self._claim()

    @property
    def statistics(self) -> CommandWriterStatistics:
        return CommandWriterStatistics(self._pushed, self._full, self._unheard, self._repaired)

    @property
    def last_sequence(self) -> int:
        """Of the newest command in the ring: the reader has it when its `CommandAck.consumed` is as high."""
        return self._sequence - 1

    @property
    def heard(self) -> bool:
        """A live process reads the commands."""
        return files.is_claimed(self._ack_path)

    def push(self, command: Command) -> bool:
        """True: the reader will get it, or has that very STOP waiting. False: nobody reads, or the ring is full.

        Raises:
            DeviceError: a command the layout cannot hold, or another process has claimed the channel since.
        """
        mapping = self._held()
        if not self.heard:
            self._unheard += 1
            return False
        # Only now: whatever is pushed later than the reader opened, it must take.
        pushed = PushedCommand(command.stamp_s, time.monotonic_ns(), command)
        encoded = COMMAND_CODEC.encode(pushed, self._buffer, PAYLOAD_AT)
        stop = command.kind is CommandKind.STOP
        waiting = self._waiting(mapping)
        if waiting >= RING_SLOTS - (0 if stop else 1):
            self._full += not stop
            return stop
        index = self._sequence & (RING_SLOTS - 1)
        slots.store(mapping, index, self._sequence, self._buffer, encoded)
        slots.publish(mapping, self._sequence)
        self._sequence += 1
        self._pushed += 1
        return True

    def close(self) -> None:
        """What was pushed stays to be read. May be called twice."""
        mapping, self._mapping = self._mapping, None
        if mapping is not None:
            mapping.close()
        self._ack.close()

    def _waiting(self, mapping: Mapping) -> int:
        """Commands in the ring that the reader has not acknowledged."""
        ack = self._ack.latest()
        consumed = ack.consumed if ack is not None else 0
        words, waiting = mapping.words, 0
        for index in range(RING_SLOTS):
            at = (mapping.geometry.slot_at(index) + SEQUENCE_AT) >> 2
            waiting += (words[at + 1] << 32 | words[at]) > consumed
        return waiting

    def _held(self) -> Mapping:
        mapping = self._mapping
        if mapping is None:
            raise DeviceError(f"{self._path.name} is closed; open it again before pushing")
        if mapping.removed:
            mapping.close()
            mapping = self._claim()
        return mapping

    def _claim(self) -> Mapping:
        mapping = files.claim(self._path, _GEOMETRY)
        try:
            reign = slots.take_over(mapping, COMMAND_CODEC.head_bytes, os.getpid(), time.monotonic_ns())
            mapping.reserve(_GEOMETRY.slot_bytes)
        except BaseException:
            mapping.close()
            raise
        self._sequence = reign.generation
        self._repaired += reign.repaired
        self._mapping = mapping
        return mapping

    def __enter__(self) -> CommandWriter:
        return self

    def __exit__(self, *exception: object) -> None:
        self.close()

    def __del__(self) -> None:
        if getattr(self, "_mapping", None) is not None:
            self.close()


class CommandReader:
    """The one live reader of commands. Raises DeviceError on opening if another live process reads them."""

    def __init__(self, path: Path, ack_path: Path) -> None:
        self._path = path
        # Before the claim: a writer that sees the claim pushes later than this.
        self._opened_ns = time.monotonic_ns()
        self._mapping: Mapping | None = None
        self._cursor = 0
        self._seen_low = -1
        self._accepted = self._skipped = self._crc_errors = self._reopened = 0
        try:
            self._ack: Writer[CommandAck] = Writer(ack_path, ACK_CODEC)
        except DeviceError as error:
            raise DeviceError(f"commands can have one reader: {error}") from error
        self._backlog: list[Command] = []
        self._backlog = self.pop_all()

    @property
    def statistics(self) -> CommandReaderStatistics:
        return CommandReaderStatistics(self._accepted, self._skipped, self._crc_errors, self._reopened)

    def pop_all(self) -> list[Command]:
        """Commands that came since the last call, oldest first; none twice.

        Raises:
            DeviceError: a live writer uses another layout, or the file is not a channel.
        """
        commands, self._backlog = self._backlog + self._take(), []
        self._ack.write(CommandAck(time.monotonic(), self._cursor))
        return commands

    def close(self) -> None:
        """Whoever pushes now is told that nobody reads. May be called twice."""
        mapping, self._mapping = self._mapping, None
        if mapping is not None:
            mapping.close()
        self._ack.close()

    def _take(self) -> list[Command]:
        for _ in range(2):
            if self._mapping is None:
                self._mapping, self._seen_low = files.open_for_reading(self._path, _GEOMETRY), -1
            if self._mapping is None:
                return []
            low = self._mapping.words[header.PUBLISHED]
            if low != self._seen_low:
                self._seen_low = low
                return self._take_until(self._mapping, low)
            if files.inode_of(self._path) in (None, self._mapping.inode):
                return []
            self._mapping.close()
            self._mapping = None
            self._reopened += 1
        return []

    def _take_until(self, mapping: Mapping, low: int) -> list[Command]:
        commands = []
        unread = min((low - self._cursor) & LOW, RING_SLOTS)
        for back in range(unread - 1, -1, -1):
            pushed = self._load(mapping, (low - back) & LOW)
            if pushed is None:
                continue
            if pushed.pushed_ns < self._opened_ns:
                self._skipped += 1
            else:
                self._accepted += 1
                commands.append(pushed.command)
        return commands

    def _load(self, mapping: Mapping, low: int) -> PushedCommand | None:
        """The command whose sequence ends in `low`, if it is one this reader has not had.

        A place not yet taken is tried again, for on AArch64 `published` may be seen before what it publishes.
        """
        for _ in range(TRIES):
            loaded = slots.load(mapping, low & (RING_SLOTS - 1), low)
            if isinstance(loaded, Fault):
                self._crc_errors += loaded is Fault.CRC
                continue
            if loaded.sequence <= self._cursor:
                return None
            self._cursor = loaded.sequence
            return COMMAND_CODEC.decode(loaded.data, PAYLOAD_IN_DATA, None)
        return None

    def __enter__(self) -> CommandReader:
        return self

    def __exit__(self, *exception: object) -> None:
        self.close()

    def __del__(self) -> None:
        if getattr(self, "_mapping", None) is not None:
            self.close()
