"""LoopInt, LoopBool, LoopDouble, LoopString: the child once for each item of a list."""

from __future__ import annotations

from collections import deque
from collections.abc import MutableSequence
from enum import Enum
from typing import Any, ClassVar

from py_trees.common import Status
from py_trees.ports import PortInformation

from target_nav.mission.nodes.base import DecoratorNode
from target_nav.mission.nodes.ticking import SKIPPED, Visited, tick_node
from target_nav.mission.values import BadValue, from_blackboard


class Result(Enum):
    """A status as a mission writes it."""

    SUCCESS = Status.SUCCESS
    FAILURE = Status.FAILURE
    RUNNING = Status.RUNNING
    SKIPPED = SKIPPED


def _inputs(item: Any) -> dict[str, PortInformation]:
    return {
        "queue": PortInformation(
            list[item],
            True,
            "written out, or an entry that holds one; items are taken out of it",
        ),
        "if_empty": PortInformation(Result, False, "the result when no item is left", Result.SUCCESS),
    }


def _outputs(item: Any) -> dict[str, PortInformation]:
    return {"value": PortInformation(item, False, "the item")}


class _Loop(DecoratorNode):
    BEGINS = False
    ITEM: ClassVar[Any]
    _items: MutableSequence[Any] | None = None
    _child_running = False

    def step(self, visited: Visited) -> Status:
        if not self.active:
            self._child_running = False
            self._items = None
        if not self._child_running:
            items = self._queue()
            if not items:
                result: Result = self.input("if_empty")
                return result.value
            self._give(items.popleft() if isinstance(items, deque) else items.pop(0))
        status = tick_node(self.decorated, visited)
        self._child_running = status is Status.RUNNING
        return Status.FAILURE if status is Status.FAILURE else Status.RUNNING

    def _queue(self) -> MutableSequence[Any]:
        """What is left: of a literal list for this run, of an entry's list itself, which others may fill meanwhile."""
        if not self.is_literal("queue"):
            self._items = self.input("queue")
        elif self._items is None:
            self._items = list(self.input("queue"))
        return self._items

    def _give(self, item: Any) -> None:
        sink = self.sinks.get("value")
        try:
            item = from_blackboard(item, self.ITEM)
            if sink is not None:
                sink.write(item)
        except BadValue as error:
            raise self.error(f"queue has the item {item!r}; {error}") from error


class LoopInt(_Loop):
    """Ticks its child once for each whole number of a list, RUNNING meanwhile. FAILURE as soon as the child fails."""

    ITEM = int
    INPUT_PORTS, OUTPUT_PORTS = _inputs(int), _outputs(int)


class LoopBool(_Loop):
    """LoopInt with true and false."""

    ITEM = bool
    INPUT_PORTS, OUTPUT_PORTS = _inputs(bool), _outputs(bool)


class LoopDouble(_Loop):
    """LoopInt with any numbers."""

    ITEM = float
    INPUT_PORTS, OUTPUT_PORTS = _inputs(float), _outputs(float)


class LoopString(_Loop):
    """LoopInt with texts."""

    ITEM = str
    INPUT_PORTS, OUTPUT_PORTS = _inputs(str), _outputs(str)
