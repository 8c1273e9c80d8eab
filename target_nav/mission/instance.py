"""One behaviour to be built, and what of it is bound to the blackboard."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field
from typing import Any, Literal

from target_nav.mission.model import NodeDef
from target_nav.mission.problems import Position
from target_nav.mission.registry import NodeSpec
from target_nav.mission.scope import Entry, Scope
from target_nav.mission.script import Script


@dataclass(frozen=True)
class PortUse:
    """Something of a node that is bound to a blackboard entry. `owner` is the scope the entry belongs to.

    `kind` is `port`, or `script` for a name in one, or `key` for a port that names an entry; `text` is what the mission
    says. `strict`: only exactly `data_type` will do (a leaf's port). `creates`: whether writing makes the entry.
    """

    port: str
    entry: Entry
    owner: Scope
    text: str
    position: Position
    data_type: Any = object
    limits: tuple[float, float] | None = None
    kind: Literal["port", "script", "key"] = "port"
    strict: bool = False
    creates: bool = True


@dataclass(eq=False)
class Instance:
    """One behaviour to be built. `spec` is None for a SubTree and for a node nobody knows.

    `literals` are typed; `inputs` and `outputs` are the ports that go to the blackboard. `reads` and `writes` are what
    scripts and named entries do there besides. `fixed` are entries whose constants the mission was built with.
    `touched` are entries of which it is not known whether they are read or written, because of an error.
    """

    definition: NodeDef
    scope: Scope
    spec: NodeSpec | None = None
    literals: dict[str, Any] = field(default_factory=dict)
    inputs: list[PortUse] = field(default_factory=list)
    outputs: list[PortUse] = field(default_factory=list)
    reads: list[PortUse] = field(default_factory=list)
    writes: list[PortUse] = field(default_factory=list)
    fixed: list[PortUse] = field(default_factory=list)
    scripts: dict[str, Script] = field(default_factory=dict)
    """By attribute."""
    variables: dict[str, Entry] = field(default_factory=dict)
    """By their names in the scripts."""
    keys: dict[str, Entry] = field(default_factory=dict)
    """By the port that names them."""
    touched: list[str] = field(default_factory=list)
    children: list[Instance] = field(default_factory=list)

    def walk(self) -> Iterator[Instance]:
        yield self
        for child in self.children:
            yield from child.walk()
