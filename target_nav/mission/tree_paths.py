"""Behaviours by path: names from the root down, `#2` where siblings share one.

`/Main/Find/TurnSearch`. The same file gives the same paths in every run, which ids do not; so recordings, scenarios and
pictures speak of behaviours by their paths.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from typing import TypeVar

from py_trees.behaviour import Behaviour

Node = TypeVar("Node")


def unique_paths(
    root: Node, name_of: Callable[[Node], str], children_of: Callable[[Node], Iterable[Node]]
) -> Iterator[tuple[Node, str]]:
    """Each node of a tree of any kind with its path, depth first."""
    taken: set[str] = set()

    def collect(node: Node, prefix: str) -> Iterator[tuple[Node, str]]:
        path = unique = f"{prefix}/{name_of(node)}"
        number = 2
        while unique in taken:
            unique, number = f"{path}#{number}", number + 1
        taken.add(unique)
        yield node, unique
        for child in children_of(node):
            yield from collect(child, unique)

    return collect(root, "")


def paths_of(root: Behaviour) -> dict[Behaviour, str]:
    """The path of each behaviour, depth first."""
    return dict(unique_paths(root, lambda node: node.name, lambda node: node.children))
