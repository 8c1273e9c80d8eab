"""Past ticks to scrub through: bounded in number and in bytes, whatever a run does.

Frames that follow each other are nearly the same, so they are packed twenty at a time: a tenth of the memory.
"""

from __future__ import annotations

import zlib
from collections import deque
from dataclasses import dataclass
from typing import Any

CHUNK = 20
MOST_FRAMES = 3600
"""Six minutes at 10 Hz."""
MOST_BYTES = 2_500_000
MOST_PICTURE_BYTES = 1_000_000


@dataclass(frozen=True, slots=True)
class Mark:
    """What a strip shows of a frame. `stale`: some source was too old to be believed."""

    stamp_s: float
    state: str
    leaf: str
    stale: bool


class Timeline:
    """Numbers count from 0 and never repeat. Not thread-safe."""

    def __init__(
        self,
        most_frames: int = MOST_FRAMES,
        most_bytes: int = MOST_BYTES,
        most_picture_bytes: int = MOST_PICTURE_BYTES,
    ) -> None:
        self._most_frames, self._most_bytes = most_frames, most_bytes
        self._most_picture_bytes = most_picture_bytes
        self._marks: deque[Mark] = deque()
        self._chunks: deque[bytes] = deque()
        self._open: list[str] = []
        self._bytes = 0
        self._pictures: deque[tuple[int, bytes]] = deque()
        self._picture_bytes = 0
        self.end = 0
        """Number of the next frame."""
        self._unpacked: tuple[int, list[str]] = (-1, [])

    @property
    def begin(self) -> int:
        """Number of the oldest frame there is; `end` when there is none."""
        return self.end - len(self._marks)

    @property
    def size_bytes(self) -> int:
        """Of what is packed, with the pictures."""
        return self._bytes + self._picture_bytes

    def add(self, mark: Mark, frame: str, picture: bytes | None = None) -> int:
        """The frame's number. `picture` is a JPEG that goes with this frame and those after it."""
        number = self.end
        self.end += 1
        self._marks.append(mark)
        self._open.append(frame)
        if picture is not None:
            self._pictures.append((number, picture))
            self._picture_bytes += len(picture)
        if len(self._open) == CHUNK:
            packed = zlib.compress("\n".join(self._open).encode(), 6)
            self._open = []
            self._chunks.append(packed)
            self._bytes += len(packed)
        while len(self._chunks) > 1 and (
            self._bytes > self._most_bytes or self.end - self.begin > self._most_frames
        ):
            self._bytes -= len(self._chunks.popleft())
            for _ in range(CHUNK):
                self._marks.popleft()
        while self._pictures and (
            self._picture_bytes > self._most_picture_bytes or self._pictures[0][0] < self.begin - CHUNK
        ):
            self._picture_bytes -= len(self._pictures.popleft()[1])
        return number

    def frame(self, number: int) -> str | None:
        """A frame as it was added; None when it is not kept any more, or not yet there."""
        if not self.begin <= number < self.end:
            return None
        first_open = self.end - len(self._open)
        if number >= first_open:
            return self._open[number - first_open]
        chunk = (number - self.begin) // CHUNK
        if self._unpacked[0] != number // CHUNK:
            self._unpacked = (number // CHUNK, zlib.decompress(self._chunks[chunk]).decode().split("\n"))
        return self._unpacked[1][number % CHUNK]

    def picture(self, number: int) -> bytes | None:
        """The picture that was newest at that frame, if one is kept."""
        found = None
        for at, picture in self._pictures:
            if at > number:
                break
            found = picture
        return found

    def marks(self, since: int, most: int | None = None) -> list[list[Any]]:
        """[number, stamp_s, state, leaf, stale] of the frames from `since` on, at most `most`."""
        first = max(since, self.begin)
        last = self.end if most is None else min(self.end, first + most)
        offset = self.begin
        return [
            [number, round(mark.stamp_s, 2), mark.state, mark.leaf, int(mark.stale)]
            for number, mark in ((n, self._marks[n - offset]) for n in range(first, last))
        ]
