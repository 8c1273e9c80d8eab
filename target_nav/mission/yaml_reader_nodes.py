"""YAML text into nodes that know where they stand: scalars as they are written, mappings, sequences.

Nothing is resolved: `0.10` stays `0.10` and `no` stays `no`, because what a value means is its port's business. What a
mission never needs and a hostile file does is refused while reading: anchors and aliases (a few bytes can stand for
gigabytes), tags, several documents, deep nesting, keys that are no text, the same key twice.
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import dataclass, field
from typing import Any, TypeAlias

import yaml

from target_nav.mission.parse import MAX_DEPTH, MAX_ELEMENTS
from target_nav.mission.problems import Position

MAX_LEVELS = 4 * MAX_DEPTH
"""An XML tag takes up to three levels of YAML: the mapping that names it, its attributes, its list of children."""

MAX_EVENTS = 12 * MAX_ELEMENTS

# YAML's own rule (PyYAML's two readers word it differently), and the byte order mark, which they do not agree on.
_NOT_PRINTABLE = re.compile(
    "[^\\x09\\x0a\\x0d\\x20-\\x7e\\x85\\xa0-\\ud7ff\\ue000-\\ufefe\\uff00-\\ufffd\\U00010000-\\U0010ffff]"
)

# libyaml's parser is ten times as fast, and comes with PyYAML's wheels.
_LOADER: type = getattr(yaml, "CSafeLoader", yaml.SafeLoader)


@dataclass(frozen=True)
class YamlScalar:
    """A text. `is_empty` when nothing at all was written, which is not the same as `""`."""

    text: str
    position: Position
    end: Position
    """Behind its last character."""
    is_empty: bool
    is_block: bool
    """Written with | or >, on lines of its own."""


@dataclass
class YamlMapping:
    """`entries` in the order of the file. `is_flow` when it was written with braces."""

    position: Position
    is_flow: bool
    entries: list[tuple[YamlScalar, YamlNode]] = field(default_factory=list)


@dataclass
class YamlSequence:
    """Its position is that of its first dash, and all dashes of a list stand in one column."""

    position: Position
    is_flow: bool
    items: list[YamlNode] = field(default_factory=list)


YamlNode: TypeAlias = "YamlScalar | YamlMapping | YamlSequence"


class Refused(Exception):
    """Why a text cannot be read, and where."""

    def __init__(self, position: Position, message: str) -> None:
        super().__init__(message)
        self.position = position
        self.message = message


def compose(text: str, shown: str) -> YamlNode | None:
    """The one document of a text, or None when there is nothing in it.

    Raises:
        Refused: it is not YAML, or has what no mission needs.
    """
    odd = _NOT_PRINTABLE.search(text)
    if odd is not None:
        before = text[: odd.start()]
        position = Position(shown, before.count("\n") + 1, odd.start() - (before.rfind("\n") + 1) + 1)
        raise Refused(position, f"has the character U+{ord(odd.group()):04X}, which no YAML file may have")
    return _Composer(shown).read(text)


class _Composer:
    def __init__(self, shown: str) -> None:
        self._shown = shown
        self._count = 0
        self._keys: dict[int, dict[str, Position]] = {}

    def read(self, text: str) -> YamlNode | None:
        try:
            events: Iterator[yaml.Event] = yaml.parse(text, Loader=_LOADER)
            return self._document(events)
        except yaml.MarkedYAMLError as error:
            mark, why = _explain(error, text)
            raise Refused(self._at(mark), f"is not well-formed YAML: {why}") from None
        except (yaml.YAMLError, ValueError, OverflowError) as error:
            # PyYAML's own reader lets chr() raise on "\UFFFFFFFF".
            raise Refused(Position(self._shown), f"is not well-formed YAML: {error}") from None

    def _at(self, mark: Any) -> Position:
        """A mark of either of PyYAML's readers (their types differ), or None, as a position."""
        if mark is None:
            return Position(self._shown)
        return Position(self._shown, mark.line + 1, mark.column + 1)

    def _document(self, events: Iterator[yaml.Event]) -> YamlNode | None:
        root: YamlNode | None = None
        open_: list[YamlMapping | YamlSequence] = []
        waiting: list[YamlScalar | None] = []  # for each open node: the key whose value comes next
        documents = 0
        for event in events:
            if isinstance(event, yaml.DocumentStartEvent):
                documents += 1
                if documents > 1:
                    raise Refused(
                        self._at(event.start_mark), "has a second document (---); a file is one mission"
                    )
            if isinstance(event, (yaml.MappingEndEvent, yaml.SequenceEndEvent)):
                self._keys.pop(id(open_.pop()), None)
                waiting.pop()
            if not isinstance(event, yaml.NodeEvent):
                continue
            node = self._node(event, len(open_))
            if not open_:
                root = node
            else:
                waiting[-1] = self._put(node, open_[-1], waiting[-1])
            if not isinstance(node, YamlScalar):
                open_.append(node)
                waiting.append(None)
        return root

    def _put(
        self, node: YamlNode, parent: YamlMapping | YamlSequence, key: YamlScalar | None
    ) -> YamlScalar | None:
        """Puts a node where it belongs; returns the key that then waits for its value."""
        if isinstance(parent, YamlSequence):
            parent.items.append(node)
            return None
        if key is not None:
            parent.entries.append((key, node))
            return None
        if not isinstance(node, YamlScalar):
            raise Refused(node.position, "a key must be a text, not a list or a mapping")
        keys = self._keys.setdefault(id(parent), {})
        first = keys.setdefault(node.text, node.position)
        if first is not node.position:
            raise Refused(node.position, f'a second "{node.text}"; the first is in line {first.line}')
        return node

    def _node(self, event: yaml.NodeEvent, depth: int) -> YamlNode:
        at = self._at(event.start_mark)
        self._count += 1
        if self._count > MAX_EVENTS:
            raise Refused(at, f"has more than {MAX_EVENTS} values, the most a mission file may have")
        if isinstance(event, yaml.AliasEvent):
            raise Refused(at, f"*{event.anchor} stands for another place; write it out, or use a SubTree")
        if event.anchor is not None:
            raise Refused(
                at, f"&{event.anchor} marks a place to be used again; missions have none, use a SubTree"
            )
        if isinstance(event, yaml.ScalarEvent):
            if event.tag is not None:
                raise Refused(at, f"has the tag {event.tag}; missions have no tags")
            nothing = event.style in (None, "") and event.value == ""
            end = self._at(event.end_mark)
            return YamlScalar(event.value, at, end, nothing, is_block=event.style in ("|", ">"))
        if depth >= MAX_LEVELS:
            raise Refused(at, f"is nested more than {MAX_LEVELS} deep; is a bracket missing?")
        assert isinstance(event, (yaml.MappingStartEvent, yaml.SequenceStartEvent)), (
            "there are no other node events"
        )
        if event.tag is not None:
            raise Refused(at, f"has the tag {event.tag}; missions have no tags")
        flow = bool(event.flow_style)
        return YamlMapping(at, flow) if isinstance(event, yaml.MappingStartEvent) else YamlSequence(at, flow)


def _explain(error: yaml.MarkedYAMLError, text: str) -> tuple[Any, str]:
    """Where and why, in the same words for PyYAML's two readers, and what to do."""
    problem, context = error.problem or error.context or "unknown error", error.context or ""
    mark = error.problem_mark or error.context_mark
    if "cannot start any token" in problem and mark is not None:
        character = text.split("\n")[mark.line][mark.column : mark.column + 1]
        if character == "\t":
            return mark, "a tab in the indentation; use spaces"
        return mark, f"{character} cannot begin a text; put the text in quotes"
    if "mapping values are not allowed" in problem:
        return mark, '": " inside a text, or a line with a wrong indentation; a text with ": " needs quotes'
    if "unexpected end of stream" in problem:
        return error.context_mark or mark, "a quote is not closed"
    if "flow" in context:
        return error.context_mark or mark, "a bracket is not closed, or a comma is missing"
    if "block" in context:
        return mark, "this line does not fit those before it; is it indented as they are?"
    return mark, problem
