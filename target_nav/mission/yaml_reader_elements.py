"""YAML nodes into elements: a node's name, its ports, its children; and where each of them is written.

What leaves a hole is refused: the mission without it would be found wrong for other reasons as well.
"""

from __future__ import annotations

import re
from collections.abc import Iterable
from dataclasses import dataclass
from functools import lru_cache
from xml.parsers import expat

from target_nav.mission.model import Attribute
from target_nav.mission.parse import MAX_DEPTH, MAX_ELEMENTS, Element
from target_nav.mission.problems import Position, Report
from target_nav.mission.yaml_reader_nodes import Refused, YamlMapping, YamlNode, YamlScalar, YamlSequence

CHILDREN = "children"
TEXT = "text"
"""In `TreeNodesModel`: what stands between a port's tags in XML, its description."""

_ASCII_NAME = re.compile(r"[A-Za-z_][A-Za-z0-9_.-]*")
_NOT_IN_XML = re.compile("[\\x00-\\x08\\x0b\\x0c\\x0e-\\x1f\\ud800-\\udfff\\ufffe\\uffff]")


@dataclass
class Anchor:
    """Where an element, or one of its ports, is written: what a comment can belong to.

    `column` is that of the element's dash, or of its key where it has none; `children_column` that of its children.
    """

    line: int
    column: int
    element: Element
    is_port: bool
    children_column: int | None = None


@lru_cache(maxsize=1000)
def is_xml_name(name: str) -> bool:
    """Whether a text can be the name of a tag or of an attribute."""
    if _ASCII_NAME.fullmatch(name):
        return True
    if not name or re.search(r"[\s<>/=&'\"]", name):
        return False
    try:
        expat.ParserCreate("utf-8").Parse(f"<{name}/>".encode(), True)
    except (expat.ExpatError, UnicodeEncodeError):
        return False
    return True


class ElementReader:
    """Makes the elements of one file. After `refuse`, `broken` says that they are not all there."""

    def __init__(self, report: Report) -> None:
        self._report = report
        self.broken = False
        self._count = 0
        self.anchors: list[Anchor] = []
        self._anchor_of: dict[int, Anchor] = {}

    def refuse(self, at: Position, message: str) -> None:
        self.broken = True
        self._report.error(at, message)

    def items(self, node: YamlSequence, depth: int, in_model: bool = False) -> Iterable[Element]:
        """The nodes of a list. `depth` is how deep they are in the file, `in_model` whether in `TreeNodesModel`."""
        for item in node.items:
            column = self.column(node, item.position)
            if isinstance(item, YamlScalar) and not item.is_empty:
                yield from self.node(item, None, depth, column, in_model)
            elif isinstance(item, YamlMapping) and len(item.entries) == 1:
                name, below = item.entries[0]
                yield from self.node(name, below, depth, column, in_model)
            elif isinstance(item, YamlMapping) and item.entries:
                first, second = item.entries[0][0], item.entries[1][0]
                self.refuse(
                    second.position,
                    f"{second.text} stands beside {first.text}; a port of {first.text} is indented further, "
                    "another node needs a dash",
                )
            else:
                self.refuse(item.position, "here must be a node: its name, or its name with ports")

    def node(
        self, name: YamlScalar, below: YamlNode | None, depth: int, column: int, in_model: bool = False
    ) -> Iterable[Element]:
        """One node, or none after refusing it. `below` is what stands behind its colon, `column` where it begins."""
        if not is_xml_name(name.text):
            self.refuse(name.position, f'"{name.text}" cannot be the name of a node')
            return
        element = self.element(name.text, name.position, depth, column)
        if isinstance(below, YamlSequence):
            self.children_at(element, self._list_column(below, column))
            element.children.extend(self.items(below, depth + 1, in_model))
        elif isinstance(below, YamlMapping):
            self._fill(element, below, depth, in_model)
        elif below is not None and not below.is_empty:
            self.refuse(
                below.position,
                f'{name.text} is given the text "{below.text}"; ports have names, as in {name.text}: {{port: value}}',
            )
        yield element

    def _fill(self, element: Element, node: YamlMapping, depth: int, in_model: bool) -> None:
        ports: list[tuple[YamlScalar, YamlNode]] = []
        for key, value in node.entries:
            if key.text == CHILDREN and isinstance(value, YamlMapping):
                self.refuse(value.position, f"{CHILDREN} is a list; put a dash in front of each node")
            elif key.text == CHILDREN and isinstance(value, YamlSequence):
                self.children_at(element, self._list_column(value, node.position.column))
                element.children.extend(self.items(value, depth + 1, in_model))
            elif in_model and key.text == TEXT and isinstance(value, YamlScalar):
                self.anchor(key.position, element, is_port=True)
                element.text = self.text(value).strip()
            else:
                ports.append((key, value))
        element.attributes = tuple(self.attributes(element, ports))

    def attributes(
        self, element: Element, entries: Iterable[tuple[YamlScalar, YamlNode]]
    ) -> Iterable[Attribute]:
        for key, value in entries:
            self.anchor(key.position, element, is_port=True)
            yield from self.attribute(key, value)

    def attribute(self, key: YamlScalar, value: YamlNode) -> Iterable[Attribute]:
        """One port, or none after refusing it."""
        name = key.text
        if not is_xml_name(name):
            self.refuse(key.position, f'"{name}" cannot be the name of a port')
        elif isinstance(value, YamlScalar) and value.is_empty:
            self.refuse(key.position, f'{name} has no value; an empty text is written ""')
        elif isinstance(value, YamlScalar):
            yield Attribute(name, self.text(value), key.position)
        elif isinstance(value, YamlMapping) and value.is_flow:
            inside = value.entries[0][0].text if len(value.entries) == 1 else "key"
            self.refuse(
                value.position,
                f'{name} is a mapping; a key of the blackboard has quotes round it: "{{{inside}}}"',
            )
        else:
            what = "a mapping" if isinstance(value, YamlMapping) else "a list"
            self.refuse(
                value.position,
                f'{name} is {what}; a port is a text, a number or a "{{key}}", and nodes are a list under {CHILDREN}',
            )

    def text(self, scalar: YamlScalar) -> str:
        """A scalar's text, which XML must be able to hold as well."""
        odd = _NOT_IN_XML.search(scalar.text)
        if odd is not None:
            self.refuse(
                scalar.position, f"has the character U+{ord(odd.group()):04X}, which no mission may have"
            )
        return scalar.text

    # -- places -------------------------------------------------------------------------------------------------------

    def element(self, tag: str, position: Position, depth: int, column: int) -> Element:
        """A new element without anything in it.

        Raises:
            Refused: there are too many of them, or it is too deep.
        """
        self._count += 1
        if self._count > MAX_ELEMENTS:
            raise Refused(position, f"has more than {MAX_ELEMENTS} nodes, the most a mission file may have")
        if depth > MAX_DEPTH:
            raise Refused(position, f"{tag} is nested more than {MAX_DEPTH} deep; use a SubTree")
        element = Element(tag, (), position)
        self.anchor(position, element, is_port=False, column=column)
        return element

    # What follows is for comments only.

    def anchor(self, position: Position, element: Element, is_port: bool, column: int | None = None) -> None:
        anchor = Anchor(position.line, column or position.column, element, is_port)
        self.anchors.append(anchor)
        if not is_port:
            self._anchor_of[id(element)] = anchor

    def children_at(self, element: Element, column: int) -> None:
        """Says in which column the element's children begin."""
        self._anchor_of[id(element)].children_column = column

    @staticmethod
    def column(node: YamlSequence, item: Position) -> int:
        """Of an item's dash."""
        return item.column if node.is_flow else node.position.column

    @staticmethod
    def _list_column(node: YamlSequence, otherwise: int) -> int:
        return otherwise if node.is_flow else node.position.column
