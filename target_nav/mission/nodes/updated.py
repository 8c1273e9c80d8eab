"""Nodes that ask whether an entry was written anew: WasEntryUpdated, SkipUnlessUpdated, WaitValueUpdate."""

from __future__ import annotations

from typing import ClassVar

from py_trees.common import Status
from py_trees.ports import PortInformation

from target_nav.mission.nodes.base import DecoratorNode
from target_nav.mission.nodes.leaves import LeafNode
from target_nav.mission.nodes.ticking import SKIPPED, Visited, tick_node
from target_nav.mission.nodes.updates import UpdateWatch

_ENTRY = {"entry": PortInformation(str, True, "the entry: {key}, or its name")}


class WasEntryUpdated(LeafNode):
    """SUCCESS if the entry was written since the last time this was asked, be it with the same value; else FAILURE."""

    INPUT_PORTS = _ENTRY
    KEY_PORTS = {"entry": "watches"}
    _watch: UpdateWatch | None = None

    def step(self, visited: Visited) -> Status:
        self._watch = self._watch or UpdateWatch(self.entries["entry"].path)
        return Status.SUCCESS if self._watch.look() else Status.FAILURE


class _Updated(DecoratorNode):
    INPUT_PORTS = _ENTRY
    KEY_PORTS = {"entry": "watches"}
    BEGINS = False
    OTHERWISE: ClassVar[Status]
    _watch: UpdateWatch | None = None
    _child_running = False

    def reset(self) -> None:
        self._child_running = False

    def step(self, visited: Visited) -> Status:
        self._watch = self._watch or UpdateWatch(self.entries["entry"].path)
        if not self._child_running and not self._watch.look():
            return self.OTHERWISE
        status = tick_node(self.decorated, visited)
        self._child_running = status is Status.RUNNING
        return status


class SkipUnlessUpdated(_Updated):
    """Ticks its child, until it ends, if the entry was written since the child began last; else it is skipped."""

    OTHERWISE = SKIPPED


class WaitValueUpdate(_Updated):
    """Ticks its child, until it ends, if the entry was written since the child began last; else it waits, RUNNING."""

    OTHERWISE = Status.RUNNING
