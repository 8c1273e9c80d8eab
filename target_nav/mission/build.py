"""Instances into py_trees behaviours, with their ports wired to the blackboard."""

from __future__ import annotations

from typing import Any

from py_trees.behaviour import Behaviour
from py_trees.blackboard import Blackboard
from py_trees.ports import PortsMixin

from target_nav.mission.expand import Instance, PortUse
from target_nav.mission.nodes import MissionNode, SubTree
from target_nav.mission.nodes.sources import Constant, FromKey, Source
from target_nav.mission.registry import NodeSpec
from target_nav.mission.values import to_literal
from target_nav.mission.wiring import traffic_of


def build(root: Instance) -> Behaviour:
    """The tree of an instance that was found free of errors."""
    return _Builder(root).node(root)


class _Builder:
    def __init__(self, root: Instance) -> None:
        traffic = traffic_of(root)
        self._written = {path for path, uses in traffic.items() if uses.writers}

    def node(self, instance: Instance) -> Behaviour:
        children = [self.node(child) for child in instance.children]
        name, spec = instance.definition.name, instance.spec
        if spec is None:
            behaviour: Behaviour = SubTree(name, children[0], instance.definition.id)
        elif spec.kind == "Control":
            behaviour = _make(spec, name, children)
        elif spec.kind == "Decorator":
            behaviour = _make(spec, name, children[0])
        else:
            behaviour = _make(spec, name)
        if isinstance(behaviour, MissionNode):
            behaviour.origin = str(instance.definition.position)
            if spec is not None:
                behaviour.sources = self._sources(behaviour, instance, spec)
        elif isinstance(behaviour, PortsMixin):
            self._wire_leaf(behaviour, instance)
        return behaviour

    def _sources(self, behaviour: MissionNode, instance: Instance, spec: NodeSpec) -> dict[str, Source]:
        sources: dict[str, Source] = {
            port: Constant(value) for port, value in self._literals(instance, spec).items()
        }
        for use in self._entries(instance, spec):
            client = behaviour.attach_blackboard_client()
            information = spec.inputs[use.port]
            sources[use.port] = FromKey(
                client,
                use.entry.path,
                use.port,
                information.data_type,
                spec.limits.get(use.port),
                information.default_value,
            )
        return sources

    def _wire_leaf(self, leaf: PortsMixin, instance: Instance) -> None:
        """Literals go to entries of the leaf's own, as py_trees' ports keep them, but with their type.

        (py_trees writes a literal into the key itself, with its dots replaced, and converts it back.)
        """
        assert instance.spec is not None
        scope = instance.scope.path
        remappings = {use.port: use.entry.path for use in instance.outputs}
        remappings |= {use.port: use.entry.path for use in self._entries(instance, instance.spec)}
        literals = self._literals(instance, instance.spec)
        remappings |= {
            port: f"{scope.rstrip('/')}/{instance.definition.id}_{leaf.id.hex[:8]}/{port}"
            for port in literals
        }
        leaf.setup_ports(port_remappings=remappings, subtree_namespace=scope)
        for port, value in literals.items():
            Blackboard.set(remappings[port], value)

    def _literals(self, instance: Instance, spec: NodeSpec) -> dict[str, Any]:
        """The literals of a node, those that a SubTree passes down to it included."""
        literals = dict(instance.literals)
        for use in instance.inputs:
            if use.entry.initial is not None and use.entry.path not in self._written:
                information = spec.inputs[use.port]
                literals[use.port] = to_literal(use.entry.initial.text, use.port, information.data_type, None)
        return literals

    def _entries(self, instance: Instance, spec: NodeSpec) -> list[PortUse]:
        """The inputs that are read from the blackboard. An entry that a SubTree sets to begin with is set here."""
        entries = []
        for use in instance.inputs:
            if use.entry.initial is None:
                entries.append(use)
            elif use.entry.path in self._written:
                data_type = spec.inputs[use.port].data_type
                Blackboard.set(use.entry.path, to_literal(use.entry.initial.text, use.port, data_type, None))
                entries.append(use)
        return entries


def _make(spec: NodeSpec, *arguments: Any) -> Behaviour:
    # Built-ins take (name, children), (name, child) or (name); leaves take (name).
    make: Any = spec.cls
    behaviour: Behaviour = make(*arguments)
    return behaviour
