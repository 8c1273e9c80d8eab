"""Looks at a ticked tree from outside: which leaf runs, what each behaviour said, how long each leaf took."""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import dataclass

import py_trees
from py_trees.common import Status

from target_nav.mission.tree_paths import paths_of


@dataclass(frozen=True)
class SlowestLeaf:
    name: str
    duration_s: float


class TreeProbe:
    """Fixed for one tree: its behaviours in depth-first order, each with a path that is unique in the tree."""

    def __init__(self, root: py_trees.behaviour.Behaviour) -> None:
        self._root = root
        paths = paths_of(root)
        self._nodes, self._paths = tuple(paths), tuple(paths.values())
        self._last_key: tuple[Status, ...] = ()
        self._last: dict[str, str] = {}
        self.slowest = SlowestLeaf("", 0.0)
        for node, path in zip(self._nodes, self._paths, strict=True):
            if not node.children:
                self._time(node, path)

    def _time(self, leaf: py_trees.behaviour.Behaviour, path: str) -> None:
        # measured here and not in the leaf, because leaves never read a clock
        update: Callable[[], Status] = leaf.update

        def timed() -> Status:
            begin_s = time.perf_counter()
            status = update()
            duration_s = time.perf_counter() - begin_s
            if duration_s > self.slowest.duration_s:
                self.slowest = SlowestLeaf(path, duration_s)
            return status

        leaf.update = timed  # type: ignore[method-assign]

    def statuses(self) -> dict[str, str]:
        """Path to status name, of the behaviours that are not INVALID. The same dict while nothing changes."""
        key = tuple(node.status for node in self._nodes)
        if key != self._last_key:
            self._last_key = key
            visited = zip(self._paths, key, strict=True)
            self._last = {path: status.name for path, status in visited if status is not Status.INVALID}
        return self._last

    def layout(self) -> list[tuple[py_trees.behaviour.Behaviour, str]]:
        """Every behaviour with its path, depth first."""
        return list(zip(self._nodes, self._paths, strict=True))

    def running_leaf(self) -> str:
        """Name of the deepest behaviour that decided the last tick; empty before the first."""
        tip = self._root.tip()
        return tip.name if tip is not None else ""
