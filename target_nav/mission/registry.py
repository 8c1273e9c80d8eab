"""The words a mission may use: BehaviorTree.CPP's own nodes and the leaves, each with its ports and limits."""

from __future__ import annotations

import importlib
import inspect
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from enum import Enum
from functools import lru_cache
from typing import Any

from py_trees.behaviour import Behaviour
from py_trees.ports import PortInformation, PortsMixin

from target_nav.errors import MissionError
from target_nav.mission.btcpp import NOT_HERE, RENAMED
from target_nav.mission.import_path import ConstructedLeaf, ImportPathError, import_leaf, is_import_path
from target_nav.mission.model import SUBTREE, Form
from target_nav.mission.nodes import BUILT_INS
from target_nav.mission.nodes.base import KeyUse, ScriptUse
from target_nav.mission.problems import did_you_mean, listed


class NodeKind(str, Enum):
    CONTROL = "Control"
    DECORATOR = "Decorator"
    LEAF = "leaf"

    @property
    def forms(self) -> tuple[Form, ...]:
        """How such a node may be written explicitly."""
        if self is NodeKind.CONTROL:
            return (Form.CONTROL,)
        if self is NodeKind.DECORATOR:
            return (Form.DECORATOR,)
        return (Form.ACTION, Form.CONDITION)


@dataclass(frozen=True)
class NodeSpec:
    """One word. `children` is the (least, most) number, most None for any. `limits` are by port; both inclusive."""

    name: str
    kind: NodeKind
    cls: type[Behaviour]
    children: tuple[int, int | None] = (0, 0)
    inputs: Mapping[str, PortInformation] = field(default_factory=dict)
    outputs: Mapping[str, PortInformation] = field(default_factory=dict)
    limits: Mapping[str, tuple[float, float]] = field(default_factory=dict)
    built_in: bool = False
    scripts: Mapping[str, ScriptUse] = field(default_factory=dict)
    """Inputs that hold a script."""
    keys: Mapping[str, KeyUse] = field(default_factory=dict)
    """Inputs that name a blackboard entry."""
    by_constructor: bool = False
    """Whether `inputs` are arguments of the class: given once, when the tree is built."""

    @property
    def doc(self) -> str:
        return inspect.cleandoc(self.cls.__doc__ or "")

    @property
    def ports(self) -> tuple[str, ...]:
        return (*self.inputs, *self.outputs)

    def port(self, name: str) -> PortInformation:
        return self.inputs[name] if name in self.inputs else self.outputs[name]


class NodeRegistry:
    """Starts with the built-ins. `register` adds leaves, `register_enum` constants of scripts.

    Other behaviours can be named by import path (`package.module:Class`); see `resolve`.
    """

    def __init__(
        self, leaves: Iterable[type[Behaviour]] = (), enums: Mapping[str, int] | None = None
    ) -> None:
        self._specs: dict[str, NodeSpec] = {}
        self._imported: dict[str, NodeSpec | ImportPathError] = {}
        self._enums: dict[str, int] = {}
        for built_in in BUILT_INS:
            kind = NodeKind(built_in.KIND)
            self._specs[built_in.__name__] = NodeSpec(
                built_in.__name__,
                kind,
                built_in,
                built_in.CHILDREN,
                built_in.INPUT_PORTS,
                built_in.OUTPUT_PORTS,
                built_in.PORT_LIMITS,
                True,
                built_in.SCRIPT_PORTS,
                built_in.KEY_PORTS,
            )
        for leaf in leaves:
            self.register(leaf)
        for name, value in (enums or {}).items():
            self.register_enum(name, value)

    def register(self, cls: type[Behaviour], name: str | None = None) -> NodeSpec:
        """Adds a leaf under its class name, or another.

        Raises:
            MissionError: it declares no ports, or ports that a mission could not write, or the name is taken.
        """
        spec = _leaf_spec(cls, name or cls.__name__)
        taken = self._specs.get(spec.name)
        if taken is not None and taken.cls is not cls:
            raise MissionError(
                f"leaf {spec.name!r} ({_where(cls)}): the name is taken by {_where(taken.cls)}"
            )
        self._specs[spec.name] = spec
        return spec

    def register_enum(self, name: str, value: int) -> None:
        """A name for a number in scripts and in a Switch's cases.

        Raises:
            MissionError: it cannot be a name, or means another number already.
        """
        if not name.isidentifier() or name.startswith(("true", "false")):
            raise MissionError(f"enum {name!r}: a script cannot have such a name")
        if self._enums.setdefault(name, value) != value:
            raise MissionError(f"enum {name!r}: is {self._enums[name]} already, and cannot be {value}")

    @property
    def enums(self) -> Mapping[str, int]:
        return self._enums

    def find(self, name: str) -> NodeSpec | None:
        """A registered word."""
        return self._specs.get(name)

    def resolve(self, name: str) -> NodeSpec | None:
        """A registered word, or the behaviour of an import path, whose module is then imported."""
        spec = self._specs.get(name)
        if spec is not None or not is_import_path(name):
            return spec
        if name not in self._imported:
            try:
                self._imported[name] = _imported_spec(name)
            except ImportPathError as error:
                self._imported[name] = error
        found = self._imported[name]
        return found if isinstance(found, NodeSpec) else None

    def specs(self) -> tuple[NodeSpec, ...]:
        return tuple(self._specs.values())

    def names(self) -> tuple[str, ...]:
        return tuple(self._specs)

    def explain_unknown(self, name: str) -> str:
        """Why `name` is no word, and which are: for a message that begins with the place."""
        if name in NOT_HERE:
            return f"{name} is not among BehaviorTree.CPP's built-in nodes; {NOT_HERE[name]}"
        if name in RENAMED:
            return f"{name} is of BehaviorTree.CPP 3; write {RENAMED[name]}"
        if is_import_path(name):
            return f"{name}: {self._imported.get(name, 'is no word here')}"
        near = did_you_mean(name, (*self._specs, SUBTREE))
        leaves = listed(sorted(spec.name for spec in self._specs.values() if not spec.built_in))
        return f"unknown node {name}{near}; available: {leaves}, and the built-in ones; see target-nav nodes"


@lru_cache(maxsize=1)
def default_registry() -> NodeRegistry:
    """The built-ins and the leaves of the package `behaviours`, with the constants that it has for scripts."""
    package = importlib.import_module("behaviours")
    leaves: tuple[type[Behaviour], ...] = getattr(package, "LEAVES", ())
    enums: Mapping[str, int] = getattr(package, "ENUMS", {})
    return NodeRegistry(leaves, enums)


def _imported_spec(path: str) -> NodeSpec:
    leaf = import_leaf(path)
    if isinstance(leaf, ConstructedLeaf):
        return NodeSpec(path, NodeKind.LEAF, leaf.cls, inputs=leaf.arguments, by_constructor=True)
    try:
        return _leaf_spec(leaf, path)
    except MissionError as error:
        raise ImportPathError(str(error)) from error


def _leaf_spec(cls: type[Behaviour], name: str) -> NodeSpec:
    if not (isinstance(cls, type) and issubclass(cls, Behaviour) and issubclass(cls, PortsMixin)):
        raise MissionError(f"leaf {name!r}: {cls!r} must be a py_trees behaviour with PortsMixin")
    inputs: Any = getattr(cls, "INPUT_PORTS", None)
    outputs: Any = getattr(cls, "OUTPUT_PORTS", None)
    if inputs is None or outputs is None:
        raise MissionError(
            f"leaf {name!r} ({_where(cls)}): INPUT_PORTS and OUTPUT_PORTS must both be declared"
        )
    limits: dict[str, tuple[float, float]] = dict(getattr(cls, "PORT_LIMITS", {}))
    for port in (*inputs, *outputs):
        if not port.isidentifier() or port.startswith("_") or port in ("name", "ID"):
            raise MissionError(f"leaf {name!r} ({_where(cls)}): a port cannot be called {port!r}")
    for port in limits:
        if port not in inputs and port not in outputs:
            raise MissionError(f"leaf {name!r} ({_where(cls)}): PORT_LIMITS names {port!r}, which is no port")
    return NodeSpec(name, NodeKind.LEAF, cls, (0, 0), inputs, outputs, limits)


def _where(cls: type) -> str:
    return f"{cls.__module__}.{cls.__qualname__}"
