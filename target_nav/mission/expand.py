"""Every use of every tree, written out: SubTrees replaced by what they name, keys by the entries they mean.

The result is a tree of `Instance`s, one for each behaviour to be built. It is made even of a mission with errors, as
far as it can be, so that the errors of the wiring are told together with the others.
"""

from __future__ import annotations

from collections.abc import Iterator

from target_nav.mission.bind import Binder, port_attributes, touched_by
from target_nav.mission.includes import Library
from target_nav.mission.instance import Instance, PortUse
from target_nav.mission.model import NodeDef, PortModel
from target_nav.mission.problems import Position, Report, did_you_mean, listed
from target_nav.mission.registry import NodeRegistry
from target_nav.mission.scope import Binding, Constant, Reference, Scope
from target_nav.mission.values import BadValue, key_in

__all__ = [
    "AUTOREMAP",
    "MAX_DEPTH",
    "MAX_NODES",
    "Expander",
    "Instance",
    "PortUse",
    "autoremap_of",
    "is_port_name",
    "mandatory_ports",
    "port_attributes",
    "subtree_arguments",
]

MAX_NODES = 5000
MAX_DEPTH = 150
"""Nodes and depth of a mission with its subtrees written out."""

AUTOREMAP = "_autoremap"


def is_port_name(name: str) -> bool:
    """Whether an attribute of a SubTree is one of its parameters."""
    return not name.startswith("_")


def subtree_arguments(node: NodeDef, library: Library) -> Iterator[tuple[str, str, Position]]:
    """What a SubTree is given: (parameter, text, where); the model's defaults stand in for what is not said."""
    said = [each for each in node.attributes if is_port_name(each.name)]
    for attribute in said:
        yield attribute.name, attribute.value, attribute.position
    model = library.models.get((node.form.value, node.id))
    if model is not None and not autoremap_of(node):
        names = {each.name for each in said}
        for port in model.ports:
            if port.name not in names and port.default is not None:
                yield port.name, port.default, port.position


def mandatory_ports(node: NodeDef, library: Library) -> list[PortModel]:
    """What the tree's model asks for and this use of it does not give."""
    model = library.models.get((node.form.value, node.id))
    if model is None or autoremap_of(node):
        return []
    given = {name for name, _, _ in subtree_arguments(node, library)}
    return [port for port in model.ports if port.name not in given]


def autoremap_of(node: NodeDef) -> bool:
    attribute = node.attribute(AUTOREMAP)
    return attribute is not None and attribute.value.strip() in ("true", "True", "TRUE", "1")


class _TooLarge(Exception):
    """The message continues a sentence that begins with the tree's name."""


class Expander:
    def __init__(self, library: Library, registry: NodeRegistry, report: Report) -> None:
        self._library = library
        self._registry = registry
        self._report = report
        self._binder = Binder(registry, report)
        self._count = 0

    def expand(self) -> Instance | None:
        """The main tree, or None when there is none or it cannot be written out."""
        main = self._library.trees.get(self._library.main_tree or "")
        if main is None or main.root is None:
            return None
        try:
            return self._node(main.root, Scope(), (main.id,), 1)
        except _TooLarge as error:
            self._report.error(main.position, f'tree "{main.id}" {error}, with its subtrees written out')
            return None

    def _node(self, node: NodeDef, scope: Scope, chain: tuple[str, ...], depth: int) -> Instance:
        """`chain` are the trees this node is in, outermost first."""
        self._count += 1
        if self._count > MAX_NODES:
            raise _TooLarge(f"has more than {MAX_NODES} nodes")
        if depth > MAX_DEPTH:
            raise _TooLarge(f"is more than {MAX_DEPTH} nodes deep")
        if node.is_subtree:
            return self._subtree(node, scope, chain, depth)
        instance = Instance(node, scope, self._registry.resolve(node.id))
        self._binder.bind(instance)
        instance.children = [self._node(child, scope, chain, depth + 1) for child in node.children]
        return instance

    def _subtree(self, node: NodeDef, scope: Scope, chain: tuple[str, ...], depth: int) -> Instance:
        instance = Instance(node, scope)
        self._binder.bind(instance)
        tree = self._library.trees.get(node.id)
        if tree is None or tree.root is None or tree.id in chain:
            # told by the check of the definitions
            instance.touched = [touched_by(each, scope) for each in node.attributes]
            return instance
        bindings: dict[str, Binding] = {}
        unknown = [port.name for port in mandatory_ports(node, self._library)]
        for name, text, position in subtree_arguments(node, self._library):
            try:
                key = key_in(text, name)
            except BadValue:
                unknown.append(name)
                continue
            bindings[name] = Constant(text, position) if key is None else Reference(key)
        inner = scope.child(node.name, bindings, autoremap_of(node))
        instance.children = [self._node(tree.root, inner, (*chain, tree.id), depth + 1)]
        instance.touched = [inner.resolve(name)[0].path for name in unknown]
        for attribute in node.attributes:
            if is_port_name(attribute.name) and attribute.name not in inner.used:
                near, known = did_you_mean(attribute.name, inner.used), listed(sorted(inner.used))
                self._report.error(
                    attribute.position,
                    f"SubTree {node.id}: nothing in it uses {attribute.name}{near}; its keys: {known}",
                )
        return instance
