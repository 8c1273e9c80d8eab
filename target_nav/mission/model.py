"""A mission as it is written: frozen, with the position of every part, and with nothing decided yet.

Every notation (XML now) is read into this model, and every later stage works on it alone.
"""

from __future__ import annotations

from dataclasses import dataclass
from enum import Enum
from pathlib import Path

from target_nav.mission.problems import Position

SUBTREE = "SubTree"


class Form(str, Enum):
    """How a node was written: `<Node/>`, or explicitly as `<Action ID="Node"/>` and its like."""

    COMPACT = ""
    ACTION = "Action"
    CONDITION = "Condition"
    CONTROL = "Control"
    DECORATOR = "Decorator"
    SUBTREE = SUBTREE


@dataclass(frozen=True)
class Attribute:
    name: str
    value: str
    position: Position


@dataclass(frozen=True)
class NodeDef:
    """One node. `id` is the registered name, or the tree's ID where `form` is SUBTREE; empty if the file has none.

    `name` is what a person sees, `named` whether the mission says it. `attributes` are without `ID` and `name`.
    """

    id: str
    form: Form
    name: str
    named: bool
    attributes: tuple[Attribute, ...]
    children: tuple[NodeDef, ...]
    position: Position

    @property
    def is_subtree(self) -> bool:
        return self.form is Form.SUBTREE

    def attribute(self, name: str) -> Attribute | None:
        return next((each for each in self.attributes if each.name == name), None)


@dataclass(frozen=True)
class TreeDef:
    """One `<BehaviorTree>`. `root` is None where the file has no usable child; that has been reported."""

    id: str
    root: NodeDef | None
    position: Position


@dataclass(frozen=True)
class IncludeDef:
    path: Attribute
    ros_pkg: Attribute | None
    position: Position


@dataclass(frozen=True)
class PortModel:
    """One port of a `<TreeNodesModel>` entry. `direction` is input, output or inout."""

    name: str
    direction: str
    default: str | None
    position: Position


@dataclass(frozen=True)
class NodeModel:
    """One entry of `<TreeNodesModel>`, which Groot2 writes for its palette; SubTree entries also give defaults."""

    form: Form
    id: str
    ports: tuple[PortModel, ...]
    position: Position


@dataclass(frozen=True)
class MissionFile:
    """One file. `path` is where it was read, `shown` how it is called in messages."""

    path: Path
    shown: str
    main_tree: Attribute | None
    includes: tuple[IncludeDef, ...]
    trees: tuple[TreeDef, ...]
    models: tuple[NodeModel, ...]
    position: Position
