"""A mission in YAML into the same elements that the XML reader makes, each with its line and column.

The notation has one rule: a node is `Name: ports`, where XML has `<Name ports/>`, and children are a list. All that
follows (document model, checks, build) works on the elements and does not know which notation they came from. The page
docs/missions-yaml.md is for who writes it.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, field

from target_nav.mission.document import FORMAT, METADATA, ROOT_ATTRIBUTES
from target_nav.mission.model import Attribute
from target_nav.mission.parse import MAX_BYTES, Element
from target_nav.mission.problems import Position, Report, did_you_mean, listed
from target_nav.mission.yaml_reader_elements import Anchor, ElementReader
from target_nav.mission.yaml_reader_nodes import (
    Refused,
    YamlMapping,
    YamlNode,
    YamlScalar,
    YamlSequence,
    compose,
)

SUFFIXES = (".yaml", ".yml")
INCLUDE, TREES, MODELS = "include", "trees", "TreeNodesModel"
SECTIONS = (INCLUDE, TREES, MODELS)


@dataclass
class YamlMission:
    """A file's root element; its scalars' and elements' places, in the order of the file."""

    root: Element
    anchors: list[Anchor] = field(default_factory=list)
    scalars: list[YamlScalar] = field(default_factory=list)


def parse_yaml_bytes(data: bytes, shown: str, report: Report) -> Element | None:
    """A YAML mission's root element, or None after reporting why there is none. Takes any bytes, raises nothing."""
    mission = read_yaml(data, shown, report)
    return mission.root if mission is not None else None


def read_yaml(data: bytes, shown: str, report: Report) -> YamlMission | None:
    """The same, with the places of everything."""
    text = decoded(data, shown, report)
    if text is None:
        return None
    try:
        node = compose(text, shown)
        return _Reader(shown, report).mission(node)
    except Refused as refused:
        report.error(refused.position, refused.message)
        return None


def decoded(data: bytes, shown: str, report: Report) -> str | None:
    """A file's text with line ends of one kind, or None after reporting why it is none."""
    if len(data) > MAX_BYTES:
        report.error(Position(shown), f"is larger than {MAX_BYTES} bytes, the most a mission file may have")
        return None
    try:
        text = data.removeprefix(b"\xef\xbb\xbf").decode("utf-8")
    except UnicodeDecodeError as error:
        # the byte order mark is not counted in `start`, which is an offset in what is left of it
        good = error.object[: error.start].decode("utf-8")
        position = Position(shown, good.count("\n") + 1, len(good) - good.rfind("\n"))
        report.error(
            position, f"is not UTF-8 (byte 0x{error.object[error.start]:02x}); save the file as UTF-8"
        )
        return None
    return text.replace("\r\n", "\n").replace("\r", "\n")


class _Reader:
    def __init__(self, shown: str, report: Report) -> None:
        self._start = Position(shown)
        self._report = report
        self._elements = ElementReader(report)
        self._scalars: list[YamlScalar] = []

    def mission(self, node: YamlNode | None) -> YamlMission | None:
        if node is None or (isinstance(node, YamlScalar) and node.is_empty):
            self._elements.refuse(self._start, "is empty; a mission begins with BTCPP_format: 4")
            return None
        self._collect_scalars(node)
        if not isinstance(node, YamlMapping):
            self._elements.refuse(
                node.position, f"a mission is keys with values: {listed((*ROOT_ATTRIBUTES, *SECTIONS))}"
            )
            return None
        root = Element("root", (), self._start)
        attributes: list[Attribute] = []
        sections: dict[str, tuple[YamlScalar, YamlNode]] = {}
        for key, value in node.entries:
            if key.text in SECTIONS:
                sections[key.text] = (key, value)
            elif key.text in ROOT_ATTRIBUTES or key.text.startswith(("xmlns", "xsi:")):
                self._elements.anchor(key.position, root, is_port=True)
                attributes.extend(self._elements.attribute(key, value))
            else:
                known = (*ROOT_ATTRIBUTES, *SECTIONS)
                near = did_you_mean(key.text, known)
                self._report.error(key.position, f'unknown key "{key.text}"{near}; allowed: {listed(known)}')
        if all(key.text != "BTCPP_format" for key, _ in node.entries):
            self._report.error(self._start, f"BTCPP_format is missing; write BTCPP_format: {FORMAT}")
            attributes.append(Attribute("BTCPP_format", FORMAT, self._start))
        root.attributes = tuple(attributes)
        for name, read in ((INCLUDE, self._includes), (TREES, self._trees), (MODELS, self._models)):
            if name in sections:
                root.children.extend(read(*sections[name]))
        if self._elements.broken:
            return None
        # sections may stand in any order, anchors must be in that of the file
        anchors = sorted(self._elements.anchors, key=lambda anchor: (anchor.line, anchor.is_port))
        return YamlMission(root, anchors, self._scalars)

    def _collect_scalars(self, node: YamlNode) -> None:
        stack: list[YamlNode] = [node]
        while stack:
            current = stack.pop()
            if isinstance(current, YamlScalar):
                self._scalars.append(current)
            elif isinstance(current, YamlSequence):
                stack.extend(current.items)
            else:
                for pair in current.entries:
                    stack.extend(pair)

    # -- the file's sections -----------------------------------------------------------------------------------------

    def _includes(self, key: YamlScalar, node: YamlNode) -> Iterable[Element]:
        if not isinstance(node, YamlSequence):
            self._elements.refuse(key.position, "include is a list of paths, each with a dash in front")
            return
        for item in node.items:
            if isinstance(item, YamlScalar):
                path = Attribute("path", self._elements.text(item), item.position)
                element = self._elements.element(
                    "include", item.position, 2, self._elements.column(node, item.position)
                )
                element.attributes = (path,)
                yield element
            elif isinstance(item, YamlMapping):
                element = self._elements.element(
                    "include", item.position, 2, self._elements.column(node, item.position)
                )
                element.attributes = tuple(self._elements.attributes(element, item.entries))
                yield element
            else:
                self._elements.refuse(item.position, "an include is a path, or path and ros_pkg")

    def _trees(self, key: YamlScalar, node: YamlNode) -> Iterable[Element]:
        if not isinstance(node, YamlMapping):
            self._elements.refuse(key.position, "trees is a mapping: the name of each tree with its node")
            return
        for identifier, value in node.entries:
            tree = self._elements.element("BehaviorTree", identifier.position, 2, identifier.position.column)
            said = [Attribute("ID", self._elements.text(identifier), identifier.position)]
            roots: list[tuple[YamlScalar, YamlNode | None]] = []
            if isinstance(value, YamlScalar) and not value.is_empty:
                roots.append((value, None))
            elif isinstance(value, YamlMapping):
                private = [(name, text) for name, text in value.entries if name.text in METADATA]
                said.extend(self._elements.attributes(tree, private))
                roots.extend((name, below) for name, below in value.entries if name.text not in METADATA)
            elif isinstance(value, YamlSequence):
                self._elements.refuse(
                    value.position,
                    f"tree {identifier.text} is a list; a tree is one node, for instance a Sequence",
                )
                roots = []
            tree.attributes = tuple(said)
            if len(roots) == 1:
                name, below = roots[0]
                block = isinstance(value, YamlMapping) and not value.is_flow
                column = value.position.column if block else identifier.position.column + 2
                self._elements.children_at(tree, column)
                tree.children.extend(self._elements.node(name, below, 3, column))
            elif not isinstance(value, YamlSequence):
                names = f" ({listed(name.text for name, _ in roots)})" if roots else ""
                self._elements.refuse(
                    identifier.position,
                    f"tree {identifier.text} has {len(roots)} nodes{names}; it must have exactly one",
                )
            yield tree

    def _models(self, key: YamlScalar, node: YamlNode) -> Iterable[Element]:
        if not isinstance(node, YamlSequence):
            self._elements.refuse(key.position, f"{MODELS} is a list of nodes, each with a dash in front")
            return
        models = self._elements.element(MODELS, key.position, 2, key.position.column)
        models.children.extend(self._elements.items(node, 3, in_model=True))
        self._elements.children_at(models, node.position.column)
        yield models
