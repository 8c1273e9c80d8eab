"""Whether a blackboard entry was written since one looked last, be it with the same value.

py_trees does not count writes, so the first node that asks replaces the blackboard's dictionary by one that does, for
the entries that are asked for. Every write passes there, a leaf's as well as the nav loop's.
"""

from __future__ import annotations

from typing import Any

from py_trees.blackboard import Blackboard


class _CountingStorage(dict[str, Any]):
    def __init__(self, content: dict[str, Any]) -> None:
        super().__init__(content)
        self.counts: dict[str, int] = {}

    def __setitem__(self, key: str, value: Any) -> None:
        super().__setitem__(key, value)
        if key in self.counts:
            self.counts[key] += 1


class UpdateWatch:
    """Looks at one entry. The first look finds an update if the entry has a value."""

    def __init__(self, path: str) -> None:
        storage = Blackboard.storage
        if not isinstance(storage, _CountingStorage):
            storage = Blackboard.storage = _CountingStorage(storage)
        self._storage = storage
        self._path = path
        self._seen = 0
        storage.counts.setdefault(path, int(path in storage))

    def look(self) -> bool:
        if self._path not in self._storage:
            return False
        seen, self._seen = self._seen, self._storage.counts[self._path]
        return seen != self._seen
