"""What the attributes of a node are bound to: literals, blackboard entries, scripts and the entries that they name."""

from __future__ import annotations

from collections.abc import Iterator

from target_nav.mission.btcpp import CONDITIONS, PRECONDITIONS
from target_nav.mission.document import METADATA
from target_nav.mission.instance import Instance, PortUse
from target_nav.mission.model import Attribute, NodeDef
from target_nav.mission.problems import Position, Report
from target_nav.mission.registry import NodeRegistry, NodeSpec
from target_nav.mission.scope import Constant, Scope
from target_nav.mission.script import ScriptError, check_kinds, parse_script
from target_nav.mission.values import BadValue, key_in, to_literal


def port_attributes(node: NodeDef) -> Iterator[Attribute]:
    """The attributes that must be ports: all but what editors leave behind and what is told of elsewhere."""
    for attribute in node.attributes:
        if attribute.name not in METADATA and attribute.name not in CONDITIONS:
            yield attribute


def touched_by(attribute: Attribute, scope: Scope) -> str:
    """The path of the key, if it is one, that belongs to something nobody knows.

    It counts as used and as written, so that an error is told once and not again in its consequences.
    """
    try:
        key = key_in(attribute.value, attribute.name)
    except BadValue:
        return ""
    return scope.resolve(key)[0].path if key is not None else ""


class Binder:
    def __init__(self, registry: NodeRegistry, report: Report) -> None:
        self._registry = registry
        self._report = report

    def bind(self, instance: Instance) -> None:
        """Fills the instance. What the check of the definitions has told is left out in silence."""
        self._conditions(instance)
        if instance.spec is not None:
            self._ports(instance, instance.spec)
        elif not instance.definition.is_subtree:
            instance.touched = [touched_by(each, instance.scope) for each in instance.definition.attributes]

    def _ports(self, instance: Instance, spec: NodeSpec) -> None:
        for attribute in port_attributes(instance.definition):
            port = attribute.name
            if port not in spec.inputs and port not in spec.outputs:
                instance.touched.append(touched_by(attribute, instance.scope))
                continue
            try:
                if port in spec.scripts or port in spec.keys or spec.by_constructor:
                    self._fixed(instance, spec, attribute)
                else:
                    self._port(instance, spec, attribute)
            except (BadValue, ScriptError):
                # told by the check of the definitions
                continue

    def _port(self, instance: Instance, spec: NodeSpec, attribute: Attribute) -> None:
        port = attribute.name
        key = key_in(attribute.value, port)
        information, limits = spec.port(port), spec.limits.get(port)
        if key is None:
            if port in spec.inputs:
                instance.literals[port] = to_literal(attribute.value, port, information.data_type, limits)
            return
        entry, owner = instance.scope.resolve(key)
        text, strict = attribute.value, not spec.built_in
        use = PortUse(
            port, entry, owner, text, attribute.position, information.data_type, limits, strict=strict
        )
        (instance.inputs if port in spec.inputs else instance.outputs).append(use)

    def _fixed(self, instance: Instance, spec: NodeSpec, attribute: Attribute) -> None:
        """A script, the name of an entry, or a constructor's argument: known before anything runs."""
        port, text, position = attribute.name, attribute.value, attribute.position
        key = key_in(text, port)
        if key is not None and spec.keys.get(port) == "watches":
            text = key
        elif key is not None:
            given = self._given(instance, spec, attribute, key)
            if given is None:
                return
            text, position = given.text, given.position
        try:
            if port in spec.scripts:
                self._script(instance, port, text, position, spec.scripts[port] == "decides")
            elif port in spec.keys:
                self._key(instance, spec, port, text, position, bound=key is not None)
            else:
                instance.literals[port] = to_literal(text, port, spec.inputs[port].data_type, None)
        except (BadValue, ScriptError) as error:
            if position == attribute.position:
                raise
            self._report.error(
                position,
                f'"{text}" goes to {port} of {instance.definition.id} ({attribute.position}); {error}',
            )

    def _given(self, instance: Instance, spec: NodeSpec, attribute: Attribute, key: str) -> Constant | None:
        """The constant that a SubTree gives for `key`; nothing else will do."""
        entry, owner = instance.scope.resolve(key)
        port, text, position = attribute.name, attribute.value, attribute.position
        if entry.initial is not None:
            instance.fixed.append(PortUse(port, entry, owner, text, position))
            return entry.initial
        instance.touched.append(entry.path)
        if port in spec.keys:
            instead = f'it is the name of an entry; write {port}="{key}"'
        else:
            instead = "it must be known before the mission runs; write it out, or let a SubTree give it as a constant"
        self._report.error(position, f'{instance.definition.id}: {port} is "{text}"; {instead}')
        return None

    def _key(
        self, instance: Instance, spec: NodeSpec, port: str, text: str, position: Position, bound: bool
    ) -> None:
        key = key_in(f"{{{text}}}", port)
        assert key is not None, "it stands in braces"
        entry, owner = instance.scope.resolve(key)
        instance.keys[port] = entry
        watched = bound and spec.keys[port] == "watches"
        use = PortUse(port, entry, owner, text, position, kind="port" if watched else "key")
        (instance.writes if spec.keys[port] == "writes" else instance.reads).append(use)

    def _conditions(self, instance: Instance) -> None:
        for attribute in instance.definition.attributes:
            if attribute.name in CONDITIONS:
                decides = attribute.name in PRECONDITIONS
                try:
                    self._script(instance, attribute.name, attribute.value, attribute.position, decides)
                except ScriptError:
                    # told by the check of the definitions
                    continue

    def _script(self, instance: Instance, port: str, text: str, position: Position, decides: bool) -> None:
        script = parse_script(text)
        enums = self._registry.enums
        check_kinds(script, enums, decides)
        instance.scripts[port] = script
        for name in (*script.reads, *script.writes):
            if name not in enums:
                instance.variables[name] = instance.scope.resolve(name)[0]
        for name in script.reads:
            if name not in enums:
                entry, owner = instance.scope.resolve(name)
                instance.reads.append(PortUse(port, entry, owner, name, position, kind="script"))
        for name in script.writes:
            entry, owner = instance.scope.resolve(name)
            creates = name in script.creates
            instance.writes.append(
                PortUse(port, entry, owner, name, position, kind="script", creates=creates)
            )
