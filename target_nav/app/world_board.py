"""The nav loop's side of the blackboard: it writes what the leaves read and reads what they write."""

from __future__ import annotations

from typing import Any

import py_trees
from py_trees.common import Access

from target_nav.state import keys
from target_nav.state.keys import Key

NAV_LOOP = "nav loop"


class WorldBoard:
    """Registers every key that the table gives to the nav loop; `None` is written first where a key is optional."""

    def __init__(self) -> None:
        self._client = py_trees.blackboard.Client(name=NAV_LOOP)
        for key in keys.ALL:
            self._client.register_key(key=key.name, access=Access.WRITE)
            if key.optional:
                self._client.set(key.name, None)

    def write(self, key: Key, value: Any) -> None:
        self._client.set(key.name, value)

    def read(self, key: Key) -> Any:
        return self._client.get(key.name)

    def close(self) -> None:
        """Forget all keys, so that the next mission of this process starts on an empty board."""
        self._client.unregister()
        py_trees.blackboard.Blackboard.clear()
