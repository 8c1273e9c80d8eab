"""Every use of every tree, written out: SubTrees replaced by what they name, keys by the entries they mean.

The result is a tree of `Instance`s, one for each behaviour to be built. It is made even of a mission with errors, as
far as it can be, so that the errors of the wiring are told together with the others.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field
from typing import Any

from target_nav.mission.btcpp import CONDITIONS
from target_nav.mission.document import METADATA
from target_nav.mission.includes import Library
from target_nav.mission.model import Attribute, NodeDef, PortModel
from target_nav.mission.problems import Position, Report, did_you_mean, listed
from target_nav.mission.registry import NodeRegistry, NodeSpec
from target_nav.mission.scope import Binding, Constant, Entry, Reference, Scope
from target_nav.mission.values import BadValue, key_in, to_literal

MAX_NODES = 5000
MAX_DEPTH = 150
"""Nodes and depth of a mission with its subtrees written out."""

AUTOREMAP = "_autoremap"


@dataclass(frozen=True)
class PortUse:
    """A port bound to a blackboard entry. `owner` is the scope the entry belongs to, `text` what the mission says."""

    port: str
    entry: Entry
    owner: Scope
    text: str
    position: Position


@dataclass(eq=False)
class Instance:
    """One behaviour to be built. `spec` is None for a SubTree and for a node nobody knows.

    `literals` are typed; `inputs` and `outputs` are the ports that go to the blackboard. `touched` are entries of
    which it is not known whether they are read or written, because of an error.
    """

    definition: NodeDef
    scope: Scope
    spec: NodeSpec | None = None
    literals: dict[str, Any] = field(default_factory=dict)
    inputs: list[PortUse] = field(default_factory=list)
    outputs: list[PortUse] = field(default_factory=list)
    touched: list[str] = field(default_factory=list)
    children: list[Instance] = field(default_factory=list)

    def walk(self) -> Iterator[Instance]:
        yield self
        for child in self.children:
            yield from child.walk()


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


def port_attributes(node: NodeDef) -> Iterator[Attribute]:
    """The attributes that must be ports: all but what editors leave behind and what is told of elsewhere."""
    for attribute in node.attributes:
        if attribute.name not in METADATA and attribute.name not in CONDITIONS:
            yield attribute


class _TooLarge(Exception):
    """The message continues a sentence that begins with the tree's name."""


class Expander:
    def __init__(self, library: Library, registry: NodeRegistry, report: Report) -> None:
        self._library = library
        self._registry = registry
        self._report = report
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
        instance = Instance(node, scope, self._registry.find(node.id))
        if instance.spec is not None:
            self._bind(instance, instance.spec)
        else:
            instance.touched = [self._touch(each, scope) for each in node.attributes]
        instance.children = [self._node(child, scope, chain, depth + 1) for child in node.children]
        return instance

    def _subtree(self, node: NodeDef, scope: Scope, chain: tuple[str, ...], depth: int) -> Instance:
        instance = Instance(node, scope)
        tree = self._library.trees.get(node.id)
        if tree is None or tree.root is None or tree.id in chain:
            # told by the check of the definitions
            instance.touched = [self._touch(each, scope) for each in node.attributes]
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

    @staticmethod
    def _touch(attribute: Attribute, scope: Scope) -> str:
        """The path of the key, if it is one, that belongs to something nobody knows.

        It counts as used and as written, so that an error is told once and not again in its consequences.
        """
        try:
            key = key_in(attribute.value, attribute.name)
        except BadValue:
            return ""
        return scope.resolve(key)[0].path if key is not None else ""

    def _bind(self, instance: Instance, spec: NodeSpec) -> None:
        for attribute in port_attributes(instance.definition):
            port = attribute.name
            if port not in spec.inputs and port not in spec.outputs:
                instance.touched.append(self._touch(attribute, instance.scope))
                continue
            try:
                key = key_in(attribute.value, port)
                if key is None:
                    if port in spec.inputs:
                        information = spec.inputs[port]
                        limits = spec.limits.get(port)
                        instance.literals[port] = to_literal(
                            attribute.value, port, information.data_type, limits
                        )
                    continue
            except BadValue:
                # told by the check of the definitions
                continue
            entry, owner = instance.scope.resolve(key)
            use = PortUse(port, entry, owner, attribute.value, attribute.position)
            (instance.inputs if port in spec.inputs else instance.outputs).append(use)
