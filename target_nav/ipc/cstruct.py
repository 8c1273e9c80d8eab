"""Memory as a C compiler lays it out: members, offsets, padding, and a fingerprint of all of it.

Python packs by these offsets and the C++ header is generated from them, so a layout is declared once. Members lie at
their natural alignment, as they do in a plain C++ struct on x86-64 and AArch64, and no `#pragma pack` is needed.
"""

from __future__ import annotations

import dataclasses
import zlib
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

SCALARS: dict[str, tuple[str, int]] = {
    "double": ("d", 8),
    "int64_t": ("q", 8),
    "uint64_t": ("Q", 8),
    "int32_t": ("i", 4),
    "uint32_t": ("I", 4),
    "uint8_t": ("B", 1),
    "bool": ("?", 1),
    "char": ("s", 1),
}
"""C type -> (letter of Python's `struct`, bytes)."""


@dataclass(frozen=True)
class Member:
    """`count` values of a scalar or of another struct, `offset` bytes from the struct's beginning.

    `counted` marks the last member of a payload, of which only as many as are in use are stored.
    """

    name: str
    of: str | CStruct
    count: int = 1
    offset: int = 0
    counted: bool = False
    meaning: str = ""
    """Of an enum's number, so that renumbering counts as another layout."""

    @property
    def item_bytes(self) -> int:
        return self.of.size if isinstance(self.of, CStruct) else SCALARS[self.of][1]

    @property
    def align(self) -> int:
        return self.of.align if isinstance(self.of, CStruct) else SCALARS[self.of][1]

    @property
    def size(self) -> int:
        return self.item_bytes * self.count

    @property
    def type_name(self) -> str:
        return self.of.name if isinstance(self.of, CStruct) else self.of


@dataclass(frozen=True)
class CStruct:
    name: str
    members: tuple[Member, ...]
    size: int
    align: int

    def __getitem__(self, name: str) -> Member:
        for member in self.members:
            if member.name == name:
                return member
        raise KeyError(f"{self.name} has no member {name}")

    def format(self, leave_out: str = "") -> str:
        """Format for Python's `struct`: little-endian, padding spelled out, nested structs flattened.

        It ends where the member `leave_out` begins, or at the struct's end.
        """
        parts, at = _format(self, leave_out)
        end = self[leave_out].offset if leave_out else self.size
        return "<" + parts + _padding(end - at)

    def text(self) -> str:
        """All that a reader must agree on, as one line a member."""
        lines = [f"struct {self.name} {self.size}"]
        lines += [f"{m.offset} {m.type_name} {m.name}[{m.count}] {m.meaning}" for m in self.members]
        return "\n".join([*(s.text() for s in self.nested()), *lines])

    def nested(self) -> Iterator[CStruct]:
        for member in self.members:
            if isinstance(member.of, CStruct):
                yield member.of

    @property
    def fingerprint(self) -> int:
        return zlib.crc32(self.text().encode())


def declare(name: str, members: Sequence[Member]) -> CStruct:
    """A struct with its members placed one after the other at their natural alignment."""
    placed, at, widest = [], 0, 1
    for member in members:
        at = round_up(at, member.align)
        placed.append(dataclasses.replace(member, offset=at))
        at += member.size
        widest = max(widest, member.align)
    return CStruct(name, tuple(placed), round_up(at, widest), widest)


def round_up(value: int, step: int) -> int:
    return -(-value // step) * step


def _padding(count: int) -> str:
    return f"{count}x" if count else ""


def _format(struct: CStruct, leave_out: str) -> tuple[str, int]:
    parts, at = "", 0
    for member in struct.members:
        if member.name == leave_out:
            break
        parts += _padding(member.offset - at)
        if isinstance(member.of, CStruct):
            inner, end = _format(member.of, "")
            parts += (inner + _padding(member.of.size - end)) * member.count
        else:
            letter = SCALARS[member.of][0]
            parts += f"{member.count}{letter}" if member.count > 1 or letter == "s" else letter
        at = member.offset + member.size
    return parts, at
