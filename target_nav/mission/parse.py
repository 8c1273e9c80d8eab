"""XML into elements that know where they stand, line and column, for every attribute too.

expat gives the place of a tag but not of its attributes, so the raw text of the tag is scanned for those. What a
mission never needs is refused before it can do harm: document types (and with them entities), other encodings than
UTF-8, files beyond `MAX_BYTES` or `MAX_ELEMENTS` and nesting beyond `MAX_DEPTH`.
"""

from __future__ import annotations

import bisect
import re
from dataclasses import dataclass, field
from pathlib import Path
from xml.parsers import expat

from target_nav.mission.model import Attribute
from target_nav.mission.problems import Position, Report

MAX_BYTES = 1_000_000
MAX_ELEMENTS = 20_000
MAX_DEPTH = 64

_ATTRIBUTE = re.compile(rb"""\s+([^\s=]+)\s*=\s*(?:"[^"]*"|'[^']*')""")
_TAG_NAME = re.compile(rb"<[^\s/>]+")
_NEWLINE = re.compile(rb"\r\n|\r|\n")


@dataclass
class Element:
    """One tag. Filled while it is being read, then only looked at. `text` is what stands between its child tags."""

    tag: str
    attributes: tuple[Attribute, ...]
    position: Position
    children: list[Element] = field(default_factory=list)
    text: str = ""

    def attribute(self, name: str) -> Attribute | None:
        return next((each for each in self.attributes if each.name == name), None)


class _Refused(Exception):
    def __init__(self, byte: int, message: str) -> None:
        super().__init__(message)
        self.byte = byte
        self.message = message


def parse_file(path: Path, shown: str, report: Report) -> Element | None:
    """The root element, or None after reporting why there is none."""
    data = read_bytes(path, shown, report)
    return parse_bytes(data, shown, report) if data is not None else None


def read_bytes(path: Path, shown: str, report: Report) -> bytes | None:
    """A file's content, cut off behind what is allowed; or None after reporting why it cannot be read."""
    start = Position(shown)
    try:
        if not path.is_file():
            report.error(start, "there is no such file")
            return None
        with path.open("rb") as stream:
            return stream.read(MAX_BYTES + 1)
    except (OSError, ValueError) as error:
        report.error(start, f"cannot be read: {_reason(error)}")
        return None


def _reason(error: Exception) -> str:
    return error.strerror if isinstance(error, OSError) and error.strerror else str(error)


def parse_bytes(data: bytes, shown: str, report: Report) -> Element | None:
    """The same for a file's content. Takes any bytes, raises nothing."""
    if len(data) > MAX_BYTES:
        report.error(Position(shown), f"is larger than {MAX_BYTES} bytes, the most a mission file may have")
        return None
    data = data.removeprefix(b"\xef\xbb\xbf")
    try:
        data.decode("utf-8")
    except UnicodeDecodeError as error:
        places = _Places(data[: error.start], shown)
        report.error(
            places.at(error.start), f"is not UTF-8 (byte 0x{data[error.start]:02x}); save the file as UTF-8"
        )
        return None
    return _Reader(data, shown, report).read()


class _Places:
    """Byte offsets as lines and columns."""

    def __init__(self, data: bytes, shown: str) -> None:
        self._data = data
        self._shown = shown
        self._starts = [0, *(match.end() for match in _NEWLINE.finditer(data))]
        # Places are asked for in the order of the file: counting on from the last one keeps a file that is all one
        # line from taking quadratic time.
        self._last_byte, self._last_column = 0, 1

    def at(self, byte: int) -> Position:
        line = bisect.bisect_right(self._starts, byte)
        begin, column = self._starts[line - 1], 1
        if begin <= self._last_byte <= byte:
            begin, column = self._last_byte, self._last_column
        column += len(self._data[begin:byte].decode("utf-8", errors="ignore"))
        self._last_byte, self._last_column = byte, column
        return Position(self._shown, line, column)


class _Reader:
    def __init__(self, data: bytes, shown: str, report: Report) -> None:
        self._data = data
        self._report = report
        self._places = _Places(data, shown)
        self._count = 0
        self._open: list[Element] = []
        self._root: Element | None = None
        self._parser = expat.ParserCreate("utf-8")
        self._parser.ordered_attributes = True
        self._parser.buffer_text = True
        self._parser.StartElementHandler = self._start
        self._parser.EndElementHandler = self._end
        self._parser.CharacterDataHandler = self._characters
        self._parser.StartDoctypeDeclHandler = self._doctype
        self._parser.XmlDeclHandler = self._declaration

    def read(self) -> Element | None:
        try:
            self._parser.Parse(self._data, True)
        except _Refused as refused:
            self._report.error(self._places.at(refused.byte), refused.message)
            return None
        except expat.ExpatError as error:
            byte = min(max(self._parser.ErrorByteIndex, 0), len(self._data))
            self._report.error(self._places.at(byte), f"is not well-formed XML: {self._explain(error)}")
            return None
        return self._root

    def _explain(self, error: expat.ExpatError) -> str:
        text = expat.ErrorString(error.code) or "unknown error"
        byte = self._parser.ErrorByteIndex
        if text == expat.errors.XML_ERROR_INVALID_TOKEN and {*self._data[max(byte - 1, 0) : byte + 1]} & {
            *b"<&"
        }:
            # BehaviorTree.CPP's reader takes them; Groot2 and other readers of XML do not.
            return f"{text}; in an attribute write &lt; for < and &amp; for &"
        if text == expat.errors.XML_ERROR_TAG_MISMATCH and self._open:
            opened = self._open[-1]
            return f"{text}; <{opened.tag}> of line {opened.position.line} is still open"
        return text

    def _start(self, tag: str, pairs: list[str]) -> None:
        byte = self._parser.CurrentByteIndex
        self._count += 1
        if self._count > MAX_ELEMENTS:
            raise _Refused(byte, f"has more than {MAX_ELEMENTS} tags, the most a mission file may have")
        if len(self._open) >= MAX_DEPTH:
            raise _Refused(byte, f"<{tag}> is nested more than {MAX_DEPTH} deep; use a SubTree")
        position = self._places.at(byte)
        names, values = pairs[::2], pairs[1::2]
        attributes = tuple(map(Attribute, names, values, self._attribute_positions(byte, len(names))))
        element = Element(tag, attributes, position)
        if self._open:
            self._open[-1].children.append(element)
        else:
            self._root = element
        self._open.append(element)

    def _attribute_positions(self, byte: int, count: int) -> list[Position]:
        name = _TAG_NAME.match(self._data, byte)
        end = name.end() if name else byte
        positions = []
        for _ in range(count):
            match = _ATTRIBUTE.match(self._data, end)
            if match is None:
                break
            positions.append(self._places.at(match.start(1)))
            end = match.end()
        return positions + [self._places.at(byte)] * (count - len(positions))

    def _end(self, tag: str) -> None:
        self._open.pop()

    def _characters(self, text: str) -> None:
        if self._open:
            self._open[-1].text += text.strip()

    def _doctype(self, name: str, system: str | None, public: str | None, internal: int) -> None:
        raise _Refused(
            max(self._data.find(b"<!DOCTYPE"), 0), "has a <!DOCTYPE>; missions have none, take it out"
        )

    def _declaration(self, version: str, encoding: str | None, standalone: int) -> None:
        if encoding is not None and encoding.lower() not in ("utf-8", "us-ascii", "ascii"):
            raise _Refused(
                self._parser.CurrentByteIndex, f'declares encoding "{encoding}"; save the file as UTF-8'
            )
