"""Finds behaviours of a tree by the patterns that scenarios and mocks use."""

from __future__ import annotations

from collections.abc import Sequence
from fnmatch import fnmatchcase

from py_trees.behaviour import Behaviour

from target_nav.mission.nodes import SubTree
from target_nav.mission.problems import did_you_mean
from target_nav.mission.tree_paths import paths_of


class TreeIndex:
    """Fixed for one tree: behaviours from the root down, each with a path that is unique in the tree.

    A pattern with a `/` is one of paths (`*/Approach/*`), any other one of names or classes (`TurnSearch`). `*` also
    stands for a `/`.
    """

    def __init__(self, root: Behaviour) -> None:
        paths = paths_of(root)
        self.nodes: tuple[Behaviour, ...] = tuple(paths)
        self.paths: tuple[str, ...] = tuple(paths.values())
        self._path_of = paths
        self._found: dict[str, tuple[int, ...]] = {}

    def path_of(self, node: Behaviour) -> str:
        return self._path_of[node]

    def find(self, pattern: str) -> Sequence[int]:
        """Positions in `nodes`."""
        if pattern not in self._found:
            self._found[pattern] = tuple(
                i for i, node in enumerate(self.nodes) if _fits(pattern, node, self.paths[i])
            )
        return self._found[pattern]

    def fits(self, pattern: str, path: str) -> bool:
        """Whether the behaviour at `path` is one that the pattern means."""
        return any(self.paths[i] == path for i in self.find(pattern))

    def explain_unknown(self, pattern: str) -> str:
        """For a message: nothing fits the pattern, and what is near."""
        known = (
            self.paths if "/" in pattern else dict.fromkeys(name for n in self.nodes for name in _names(n))
        )
        return f"no behaviour of the mission is {pattern!r}{did_you_mean(pattern, known)}"


def _names(node: Behaviour) -> tuple[str, ...]:
    # a SubTree is also known by the tree that it uses
    return (node.name, type(node).__name__, *([node.tree_id] if isinstance(node, SubTree) else []))


def _fits(pattern: str, node: Behaviour, path: str) -> bool:
    if "/" in pattern:
        return fnmatchcase(path, pattern)
    return any(fnmatchcase(name, pattern) for name in _names(node))
