"""Instances into py_trees behaviours, with their ports and scripts wired to the blackboard."""

from __future__ import annotations

from typing import Any

from py_trees.behaviour import Behaviour
from py_trees.blackboard import Blackboard, Client
from py_trees.common import Access
from py_trees.ports import PortsMixin

from target_nav.errors import MissionError
from target_nav.mission.btcpp import POSTCONDITIONS, PRECONDITIONS
from target_nav.mission.expand import Instance, PortUse
from target_nav.mission.nodes import MissionNode, SubTree
from target_nav.mission.nodes.base import Source
from target_nav.mission.nodes.conditions import Conditions, attach
from target_nav.mission.nodes.entries import Board, BoardEntry, Constant, FromEntry
from target_nav.mission.registry import NodeSpec
from target_nav.mission.script import Enums, Run, Script, ScriptError, bind, truth
from target_nav.mission.values import BadValue, to_literal
from target_nav.mission.wiring import Traffic, port_types, traffic_of


def build(root: Instance, enums: Enums | None = None) -> Behaviour:
    """The tree of an instance that was found free of errors. `enums` are the names of constants in scripts.

    Raises:
        MissionError: the constructor of a behaviour given by import path failed.
    """
    return _Builder(root, enums or {}).node(root)


class _Builder:
    def __init__(self, root: Instance, enums: Enums) -> None:
        self._enums = enums
        traffic = traffic_of(root)
        self._live = {path for path, uses in traffic.items() if _changes(uses)}
        """Entries that a SubTree's constant is only the beginning of."""
        self._board = Board(
            types={path: types[0] for path, uses in traffic.items() if len(types := port_types(uses)) == 1},
            declared={
                use.entry.path
                for uses in traffic.values()
                for _, use in (*uses.readers, *uses.writers)
                if use.kind == "port"
            },
        )
        for path, uses in traffic.items():
            self._begin(path, uses)

    def _begin(self, path: str, uses: Traffic) -> None:
        """Puts a SubTree's constant on the blackboard, if somebody looks for it there."""
        every = [use for _, use in (*uses.readers, *uses.writers)]
        initial = next((use.entry.initial for use in every if use.entry.initial is not None), None)
        if initial is None or (path not in self._live and all(use.kind == "port" for use in every)):
            return
        value: Any = initial.text
        if path in self._board.types:
            value = to_literal(initial.text, "", self._board.types[path], None)
        Blackboard.set(path, value)

    def node(self, instance: Instance) -> Behaviour:
        children = [self.node(child) for child in instance.children]
        name, spec = instance.definition.name, instance.spec
        if spec is None:
            behaviour: Behaviour = SubTree(name, children[0], instance.definition.id)
        elif spec.kind == "Control":
            behaviour = _make(spec, name, children)
        elif spec.kind == "Decorator":
            behaviour = _make(spec, name, children[0])
        elif spec.by_constructor:
            behaviour = _construct(spec, instance)
        else:
            behaviour = _make(spec, name)
        entries = _Entries(behaviour, self._board)
        if isinstance(behaviour, MissionNode):
            self._wire(behaviour, instance, entries)
        elif isinstance(behaviour, PortsMixin):
            self._wire_leaf(behaviour, instance)
        self._attach_conditions(behaviour, instance, entries)
        return behaviour

    # -- built-ins ---------------------------------------------------------------------------------------------------

    def _wire(self, node: MissionNode, instance: Instance, entries: _Entries) -> None:
        spec = instance.spec
        node.origin = str(instance.definition.position)
        if spec is None:
            return
        sources: dict[str, Source] = {
            port: Constant(value) for port, value in self._literals(instance, spec).items()
        }
        for use in self._bound(instance):
            entry = entries.get(use.entry.path, Access.READ)
            sources[use.port] = FromEntry(entry, use.port, use.data_type, use.limits)
        node.sources = sources
        node.sinks = {use.port: entries.get(use.entry.path, Access.WRITE) for use in instance.outputs}
        node.entries = {
            port: entries.get(entry.path, Access.READ if spec.keys[port] == "watches" else Access.WRITE)
            for port, entry in instance.keys.items()
        }
        node.scripts = {
            port: self._run(instance, port, entries, use == "decides")
            for port, use in spec.scripts.items()
            if port in instance.scripts
        }
        node.enums = self._enums

    def _attach_conditions(self, behaviour: Behaviour, instance: Instance, entries: _Entries) -> None:
        before = {
            name: self._run(instance, name, entries, True)
            for name in PRECONDITIONS
            if name in instance.scripts
        }
        after = {
            name: self._run(instance, name, entries, False)
            for name in POSTCONDITIONS
            if name in instance.scripts
        }
        if before or after:
            attach(behaviour, Conditions(before, after))

    def _run(self, instance: Instance, port: str, entries: _Entries, decides: bool) -> Run:
        script = instance.scripts[port]

        def entry_of(name: str) -> BoardEntry:
            writes = any(name in each.writes for each in instance.scripts.values())
            return entries.get(instance.variables[name].path, Access.WRITE if writes else Access.READ)

        run = bind(script, entry_of, self._enums)
        return _telling(run, decides, script, instance, port)

    # -- leaves ------------------------------------------------------------------------------------------------------

    def _wire_leaf(self, leaf: PortsMixin, instance: Instance) -> None:
        """Literals go to entries of the leaf's own, as py_trees' ports keep them, but with their type.

        (py_trees writes a literal into the key itself, with its dots replaced, and converts it back.)
        """
        assert instance.spec is not None
        scope = instance.scope.path
        remappings = {use.port: use.entry.path for use in (*instance.outputs, *self._bound(instance))}
        literals = self._literals(instance, instance.spec)
        remappings |= {
            port: f"{scope.rstrip('/')}/{type(leaf).__name__}_{leaf.id.hex[:8]}/{port}" for port in literals
        }
        leaf.setup_ports(port_remappings=remappings, subtree_namespace=scope)
        for port, value in literals.items():
            Blackboard.set(remappings[port], value)

    def _literals(self, instance: Instance, spec: NodeSpec) -> dict[str, Any]:
        """The literals of a node, those that a SubTree passes down to it included."""
        literals = dict(instance.literals)
        for use in instance.inputs:
            if use.entry.initial is not None and use.entry.path not in self._live:
                literals[use.port] = to_literal(use.entry.initial.text, use.port, use.data_type, None)
        return literals

    def _bound(self, instance: Instance) -> list[PortUse]:
        """The inputs that are read from the blackboard."""
        return [use for use in instance.inputs if use.entry.initial is None or use.entry.path in self._live]


class _Entries:
    """The entries of one behaviour: each once, all by one client, which is made with the first."""

    def __init__(self, behaviour: Behaviour, board: Board) -> None:
        self._behaviour = behaviour
        self._board = board
        self._client: Client | None = None
        self._entries: dict[tuple[str, Access], BoardEntry] = {}

    def get(self, path: str, access: Access) -> BoardEntry:
        if (path, access) not in self._entries:
            if self._client is None:
                self._client = self._behaviour.attach_blackboard_client()
            self._entries[path, access] = BoardEntry(self._board, self._client, path, access)
        return self._entries[path, access]


def _changes(uses: Traffic) -> bool:
    removed = any(use.kind == "key" for _, use in uses.readers)
    return bool(uses.writers) or removed


def _telling(run: Run, decides: bool, script: Script, instance: Instance, port: str) -> Run:
    """The script with errors that say where it stands; its value as a bool if it decides."""
    definition = instance.definition
    where = f'{definition.position}: error: {definition.name}: {port} is "{script.text}"'

    def told() -> Any:
        try:
            return truth(run()) if decides else run()
        except (ScriptError, BadValue) as error:
            raise MissionError(f"{where}; {error}") from error

    return told


def _make(spec: NodeSpec, *arguments: Any) -> Behaviour:
    # Built-ins take (name, children), (name, child) or (name); leaves take (name).
    make: Any = spec.cls
    behaviour: Behaviour = make(*arguments)
    return behaviour


def _construct(spec: NodeSpec, instance: Instance) -> Behaviour:
    definition = instance.definition
    make: Any = spec.cls
    name = definition.name if definition.named else spec.cls.__name__
    try:
        behaviour: Behaviour = make(name=name, **instance.literals)
    except Exception as error:
        raise MissionError(
            f"{definition.position}: error: {definition.id} cannot be made: {type(error).__name__}: {error}"
        ) from error
    return behaviour
