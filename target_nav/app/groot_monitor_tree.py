"""A running tree as Groot2 knows it: nodes by number, the tree as XML, blackboards by the name of their subtree.

Numbers go through the tree depth first, subtrees in their place, as BehaviorTree.CPP gives them. Attributes are those
of the mission's file; a tree that did not come from one is shown without.
"""

from __future__ import annotations

import math
import re
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any
from xml.etree import ElementTree
from xml.etree.ElementTree import Element, SubElement

from py_trees import composites, decorators
from py_trees.behaviour import Behaviour

from target_nav.mission import default_registry
from target_nav.mission.check import analyse
from target_nav.mission.document import METADATA
from target_nav.mission.instance import Instance
from target_nav.mission.nodes import SubTree
from target_nav.mission.scope import Scope
from target_nav.mission.values_text import value_text
from target_nav.mission.vocabulary import form_of, groot_model
from target_nav.state import keys

_TAG = re.compile(r"[A-Za-z_][A-Za-z0-9_.-]*")
MAIN = "MainTree"


@dataclass(eq=False)
class GrootTree:
    """`uids` by node; `entries` are the blackboard's, by subtree and name; `xml` is what Groot2 draws."""

    uids: dict[Behaviour, int] = field(default_factory=dict)
    entries: dict[str, dict[str, str]] = field(default_factory=dict)
    xml: str = ""

    def blackboards(self, wanted: str, board: Mapping[str, Any]) -> dict[str, dict[str, Any]]:
        """The values of the subtrees in `wanted`, which are parted by `;`. Names that are not there are left out."""
        return {
            name: {entry: plain(board[path]) for entry, path in self.entries[name].items() if path in board}
            for name in wanted.split(";")
            if name in self.entries
        }


def groot_tree(root: Behaviour, path: Path | None = None) -> GrootTree:
    """The tree `root`, with what the mission file at `path` says of it, if that is still the same tree."""
    instance: Instance | None = None
    name = MAIN
    if path is not None:
        analysis = analyse(path)
        if analysis.root is not None and _same_shape(root, analysis.root):
            instance, name = analysis.root, analysis.library.main_tree or MAIN
    return _Writer().write(name, root, instance)


def plain(value: Any) -> Any:
    """As MessagePack has it: numbers, truth and text as they are, everything else as a text for a person."""
    if isinstance(value, float):
        return value if math.isfinite(value) else str(value)
    if value is None or isinstance(value, (bool, int, str)):
        return value
    return value_text(value)


def _same_shape(node: Behaviour, instance: Instance) -> bool:
    return (
        node.name == instance.definition.name
        and len(node.children) == len(instance.children)
        and all(map(_same_shape, node.children, instance.children))
    )


class _Writer:
    def __init__(self) -> None:
        self._tree = GrootTree()
        self._document = Element("root", BTCPP_format="4")

    def write(self, name: str, root: Behaviour, instance: Instance | None) -> GrootTree:
        self._behaviour_tree(name, "", root, instance)
        model = ElementTree.fromstring(groot_model(default_registry()).split("?>", 1)[1]).find(
            "TreeNodesModel"
        )
        if model is not None:
            self._document.append(model)
        ElementTree.indent(self._document, "    ")
        self._tree.xml = ElementTree.tostring(self._document, encoding="unicode")
        return self._tree

    def _behaviour_tree(
        self, tree_id: str, full_path: str, root: Behaviour, instance: Instance | None
    ) -> None:
        element = SubElement(self._document, "BehaviorTree", ID=tree_id, _fullpath=full_path)
        self._entries(full_path or tree_id, instance, is_main=not full_path)
        self._node(element, root, instance, full_path)

    def _node(self, parent: Element, node: Behaviour, instance: Instance | None, full_path: str) -> None:
        uid = self._tree.uids[node] = len(self._tree.uids) + 1
        if isinstance(node, SubTree):
            inside = node.name if node.name != node.tree_id else f"{node.tree_id}::{uid}"
            inside = f"{full_path}/{inside}" if full_path else inside
            element = SubElement(parent, "SubTree", ID=node.tree_id, _fullpath=inside, _uid=str(uid))
            self._attributes(element, instance)
            inner = instance.children[0] if instance is not None else None
            self._behaviour_tree(node.tree_id, inside, node.children[0], inner)
            return
        element = SubElement(parent, *_tag(node, instance))
        element.set("name", node.name)
        element.set("_uid", str(uid))
        self._attributes(element, instance)
        for index, child in enumerate(node.children):
            self._node(element, child, instance.children[index] if instance is not None else None, full_path)

    def _attributes(self, element: Element, instance: Instance | None) -> None:
        for attribute in instance.definition.attributes if instance is not None else ():
            if attribute.name not in METADATA:
                element.set(attribute.name, attribute.value)

    def _entries(self, name: str, instance: Instance | None, is_main: bool) -> None:
        found: dict[str, str] = {}
        scope: Scope | None = instance.scope if instance is not None else None
        if scope is not None:
            found = {key: scope.resolve(key)[0].path for key in sorted(scope.used)}
        if is_main:
            found |= {key.name[1:]: key.name for key in keys.ALL}
        self._tree.entries[name] = found


def _tag(node: Behaviour, instance: Instance | None) -> tuple[str, dict[str, str]]:
    """The element's tag, and `ID` where a word cannot be a tag."""
    word = type(node).__name__ if instance is None else instance.definition.id
    spec = default_registry().find(word)
    if spec is not None and _TAG.fullmatch(word):
        return word, {}
    if isinstance(node, decorators.Decorator):
        return "Decorator", {"ID": word}
    if isinstance(node, composites.Composite):
        return "Control", {"ID": word}
    return (form_of(spec).value if spec is not None else "Action"), {"ID": word}
