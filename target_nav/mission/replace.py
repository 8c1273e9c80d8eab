"""Loads a mission in the place of one that is still on the blackboard, and leaves nothing of that one behind."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from pathlib import Path

from py_trees.behaviour import Behaviour
from py_trees.blackboard import Blackboard

from target_nav.mission.load import LoadedMission, load_mission
from target_nav.mission.registry import NodeRegistry
from target_nav.state import keys

TABLE = frozenset(key.name for key in keys.ALL)


def replace_mission(
    path: str | Path,
    old: Behaviour,
    swap: Callable[[LoadedMission], None],
    registry: NodeRegistry | None = None,
    provided_keys: Iterable[str] = (),
) -> LoadedMission:
    """Loads the mission at `path`; if that succeeds `swap` halts `old` and takes the new one over.

    The new mission begins on a board that has the nav loop's entries and what it sets itself, as if it had been there
    first. `old` is halted on the entries that it knows, and its clients are taken off the board.

    Raises:
        MissionError: the mission has errors. Board and old mission are as they were.
    """
    provided = frozenset(provided_keys)
    before = _take_entries(provided)
    try:
        new = load_mission(path, registry, provided)
    except BaseException:
        _take_entries(provided)
        _put(before)
        raise
    begins_with = _take_entries(provided)
    _put(before)
    swap(new)
    for node in old.iterate():
        for client in node.blackboards:
            client.unregister(clear=False)
    _take_entries(provided)
    _put(begins_with)
    return new


def _take_entries(provided: frozenset[str]) -> dict[str, object]:
    """Removes the mission's own entries from the board, and gives them back."""
    storage = Blackboard.storage
    own = {path: value for path, value in storage.items() if path not in TABLE and path not in provided}
    for path in own:
        del storage[path]
    return own


def _put(entries: dict[str, object]) -> None:
    for path, value in entries.items():
        Blackboard.storage[path] = value
