"""The comments of an XML mission, put on the parts they belong to."""

from __future__ import annotations

from xml.parsers import expat

from target_nav.mission.convert_source import Part, Source, end_of, parts_of, tidy_comment
from target_nav.mission.parse import Element

OPENING = "<!-- "


def source_of_xml(data: bytes, root: Element) -> Source:
    """A file with its comments. `root` is what `parse_bytes` made of the same bytes, known to be harmless."""
    made, _ = parts_of(root)
    return _Collector(data.removeprefix(b"\xef\xbb\xbf"), made).collect()


class _Collector:
    def __init__(self, data: bytes, root: Part) -> None:
        self._data = data
        self._source = Source(root)
        self._coming = root.walk()
        self._open: list[Part] = []
        self._pending: list[str] = []
        self._latest: Part | None = None
        """The part whose tag came last; None after a comment."""
        self._parser = expat.ParserCreate("utf-8")
        self._parser.StartElementHandler = self._start
        self._parser.EndElementHandler = self._end
        self._parser.CommentHandler = self._comment

    def collect(self) -> Source:
        self._parser.Parse(self._data, True)
        self._source.footer.extend(self._pending)
        return self._source

    def _start(self, tag: str, attributes: dict[str, str]) -> None:
        part = next(self._coming)
        part.before.extend(self._pending)
        self._pending.clear()
        self._open.append(part)
        self._latest = part

    def _end(self, tag: str) -> None:
        part = self._latest = self._open.pop()
        if not self._open:
            # what stands before </root> is written after it: YAML has no such place
            return
        end_of(part).extend(self._pending)
        self._pending.clear()

    def _comment(self, text: str) -> None:
        column = self._parser.CurrentColumnNumber
        lines = text.split("\n")
        if len(lines) > 1:
            # continuation lines are indented as far as the text of the first, or less
            indents = [len(line) - len(line.lstrip()) for line in lines[1:] if line.strip()]
            depth = min([column + len(OPENING), *indents])
            first = lines[0].strip()
            lines = [first, *(line.expandtabs()[depth:] for line in lines[1:])]
        tidy = tidy_comment(lines)
        if not tidy:
            return
        part = self._latest
        if (
            part is not None
            and part.tag != "root"
            and not part.beside
            and "\n" not in tidy
            and self._is_beside()
        ):
            part.beside = tidy
        else:
            self._pending.append(tidy)
        self._latest = None

    def _is_beside(self) -> bool:
        """Whether the comment begins on the line on which the tag before it ended."""
        byte = self._parser.CurrentByteIndex
        return self._data[max(0, byte - 100) : byte].rstrip(b" \t").endswith(b">")
