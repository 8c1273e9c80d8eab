"""The comments of a YAML mission, put on the parts they belong to.

YAML readers drop comments, so the text is looked through for them: a `#` at the beginning of a line or after a space,
outside of every scalar. Comment lines that follow each other in one column are one comment.
"""

from __future__ import annotations

import re
from bisect import bisect_right
from collections.abc import Iterator
from dataclasses import dataclass

from target_nav.mission.convert_source import Part, Source, end_of, parts_of, tidy_comment
from target_nav.mission.yaml_reader import YamlMission
from target_nav.mission.yaml_reader_elements import Anchor
from target_nav.mission.yaml_reader_nodes import YamlScalar

_MARK = re.compile(r"(?:^|(?<=[ \t]))#")


@dataclass(frozen=True)
class _Comment:
    """Line and column count from 1. `own` when nothing else stands on the line."""

    line: int
    column: int
    text: str
    own: bool


def source_of_yaml(text: str, mission: YamlMission) -> Source:
    """A file with its comments. `text` is what `mission` was read from."""
    root, by_element = parts_of(mission.root)
    source = Source(root)
    placer = _Placer(source, by_element, mission.anchors)
    for comment in _comments(text, mission.scalars):
        placer.place(comment)
    return source


def _comments(text: str, scalars: list[YamlScalar]) -> Iterator[_Comment]:
    lines = text.split("\n")
    covered = _covered(scalars)
    block: list[str] = []
    block_line = block_column = 0
    for number, line in enumerate([*lines, ""], start=1):
        found = _mark_in(line, covered.get(number, []))
        own = found is not None and not line[:found].strip()
        continues = own and block and found is not None and found + 1 == block_column
        if block and not continues:
            tidy = tidy_comment(block)
            if tidy:
                yield _Comment(block_line, block_column, tidy, True)
            block = []
        if found is None:
            continue
        content = line[found + 1 :].removeprefix(" ")
        if own:
            if not block:
                block_line, block_column = number, found + 1
            block.append(content)
        elif content.strip():
            yield _Comment(number, found + 1, tidy_comment([content]), False)


def _covered(scalars: list[YamlScalar]) -> dict[int, list[tuple[int, int]]]:
    """By line: the columns, from 0, that belong to scalars."""
    spans: dict[int, list[tuple[int, int]]] = {}
    for scalar in scalars:
        line, column = scalar.position.line, scalar.position.column - 1
        last_line, last_column = scalar.end.line, scalar.end.column - 1
        if scalar.is_block:
            # the line of the | itself may carry a comment
            line, column = line + 1, 0
        for number in range(line, last_line + 1):
            begin = column if number == line else 0
            end = last_column if number == last_line else 1_000_000
            if end > begin:
                spans.setdefault(number, []).append((begin, end))
    return spans


def _mark_in(line: str, spans: list[tuple[int, int]]) -> int | None:
    for match in _MARK.finditer(line):
        at = match.start()
        if not any(begin <= at < end for begin, end in spans):
            return at
    return None


class _Placer:
    def __init__(self, source: Source, by_element: dict[int, Part], anchors: list[Anchor]) -> None:
        self._source = source
        self._anchors = anchors
        self._lines = [anchor.line for anchor in anchors]
        self._parts = by_element
        self._anchor_of = {id(by_element[id(a.element)]): a for a in anchors if not a.is_port}
        self._parent: dict[int, Part] = {}
        for part in source.root.walk():
            for child in part.children:
                self._parent[id(child)] = part

    def place(self, comment: _Comment) -> None:
        if not comment.own and self._beside(comment):
            return
        index = bisect_right(self._lines, comment.line)
        following = self._anchors[index] if index < len(self._anchors) else None
        if following is None:
            self._enclosing(comment, index, None, self._source.footer)
            return
        part = self._parts[id(following.element)]
        if following.is_port or comment.column <= following.column:
            part.before.append(comment.text)
        else:
            self._enclosing(comment, index, part, part.before)

    def _beside(self, comment: _Comment) -> bool:
        """Puts it on the outermost element of its line; beside a port it belongs to the port's node."""
        first = bisect_right(self._lines, comment.line - 1)
        here = self._anchors[first : bisect_right(self._lines, comment.line)]
        if not here:
            return False
        part = self._parts[id(here[0].element)]
        if here[0].is_port or part.beside:
            part.before.append(comment.text)
        else:
            part.beside = comment.text
        return True

    def _enclosing(self, comment: _Comment, index: int, following: Part | None, otherwise: list[str]) -> None:
        """Puts it at the end of the innermost list that it is indented like, of those that are closed after it."""
        still_open = {id(part) for part in self._upwards(following)}
        part = next(
            (self._parts[id(a.element)] for a in reversed(self._anchors[:index]) if not a.is_port), None
        )
        for candidate in self._upwards(part):
            anchor = self._anchor_of.get(id(candidate))
            if id(candidate) in still_open or anchor is None:
                break
            if anchor.children_column is not None and comment.column >= anchor.children_column:
                end_of(candidate).append(comment.text)
                return
            if anchor.children_column is None and comment.column > anchor.column:
                candidate.before.append(comment.text)
                return
        otherwise.append(comment.text)

    def _upwards(self, part: Part | None) -> Iterator[Part]:
        while part is not None:
            yield part
            part = self._parent.get(id(part))
