"""Which blackboard entry a `{key}` means, in which subtree.

Every SubTree has a blackboard of its own, as in BehaviorTree.CPP; here it is a folder of py_trees' one blackboard:
key `x` of subtree `approach` is `/approach/x`, that of the main tree is `/x`. An attribute of the SubTree binds a key
inside to one outside (`{key}`) or to a constant; `_autoremap` binds every other key to the one of the same name
outside, except private ones (`_name`).
"""

from __future__ import annotations

import re
from dataclasses import dataclass, field
from typing import TypeAlias

from target_nav.mission.problems import Position

_UNSAFE = re.compile(r"[^A-Za-z0-9_-]+")


@dataclass(frozen=True)
class Constant:
    """Text that a SubTree was given instead of a key."""

    text: str
    position: Position


@dataclass(frozen=True)
class Reference:
    key: str


Binding: TypeAlias = "Constant | Reference"


@dataclass(frozen=True)
class Entry:
    """One blackboard entry. `path` is py_trees' key; `initial` is what a SubTree's attribute set it to, if one did."""

    path: str
    initial: Constant | None = None


@dataclass(eq=False)
class Scope:
    """The keys of one use of a tree. `path` is `/` for the main tree, else `/subtree/of/subtree`."""

    path: str = "/"
    parent: Scope | None = None
    bindings: dict[str, Binding] = field(default_factory=dict)
    autoremap: bool = False
    used: set[str] = field(default_factory=set)
    """Keys that something inside refers to."""
    _children: dict[str, int] = field(default_factory=dict)

    def child(self, label: str, bindings: dict[str, Binding], autoremap: bool) -> Scope:
        """A scope for a subtree called `label`. A label used before gets a number."""
        folder = _UNSAFE.sub("_", label).strip("_") or "subtree"
        count = self._children[folder] = self._children.get(folder, 0) + 1
        name = folder if count == 1 else f"{folder}_{count}"
        while count > 1 and name in self._children:
            count += 1
            name = f"{folder}_{count}"
        self._children.setdefault(name, 1)
        return Scope(self._join(name), self, bindings, autoremap)

    def root(self) -> Scope:
        return self if self.parent is None else self.parent.root()

    def resolve(self, key: str) -> tuple[Entry, Scope]:
        """The entry that `key` means here, and the scope that owns it."""
        if key.startswith("@"):
            return self.root().resolve(key[1:])
        self.used.add(key)
        if self.parent is not None:
            binding = self.bindings.get(key)
            if isinstance(binding, Reference):
                return self.parent.resolve(binding.key)
            if binding is None and self.autoremap and not key.startswith("_"):
                return self.parent.resolve(key)
            return Entry(self._join(key), binding), self
        return Entry(self._join(key)), self

    def _join(self, name: str) -> str:
        return f"{self.path.rstrip('/')}/{name}"
