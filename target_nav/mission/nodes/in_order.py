"""Children one after the other: Sequence, Fallback, their Async kinds, SequenceWithMemory."""

from __future__ import annotations

from typing import ClassVar

from py_trees import composites
from py_trees.behaviour import Behaviour
from py_trees.common import Status

from target_nav.mission.nodes.base import ControlNode
from target_nav.mission.nodes.halting import halt, is_active
from target_nav.mission.nodes.ticking import SKIPPED, Visited, tick_node

_RUNNING = Status.RUNNING


class _InOrder(ControlNode):
    """Ticks children from the one it stopped at, as long as they return `GOES_ON`."""

    GOES_ON: ClassVar[Status]
    PAUSES: ClassVar[bool] = False
    """Whether a child that returns `GOES_ON` in its first tick ends the node's tick."""
    _index = 0
    _skipped = 0

    def reset(self) -> None:
        self._index = self._skipped = 0

    def step(self, visited: Visited) -> Status:
        children, goes_on, pauses = self.children, self.GOES_ON, self.PAUSES
        count = len(children)
        while self._index < count:
            child = self.current_child = children[self._index]
            first_tick = pauses and not is_active(child)
            status = tick_node(child, visited)
            if status is _RUNNING:
                return status
            if status is goes_on:
                self._index += 1
                if first_tick and self._index < count:
                    return _RUNNING
            elif status is SKIPPED:
                self._index += 1
                self._skipped += 1
            else:
                return self._finish(status)
        return self._finish(SKIPPED if self._skipped == count else goes_on)

    def _finish(self, status: Status) -> Status:
        if self._skipped:
            # a child that was skipped can be active still, the others cannot
            self.settle()
        self._index = self._skipped = 0
        return status


class Sequence(_InOrder, composites.Sequence):
    """Ticks its children in order. SUCCESS when all have succeeded, FAILURE as soon as one fails.

    While a child is RUNNING so is the sequence, and the next tick goes on with that child. After FAILURE it begins
    with the first again.
    """

    GOES_ON = Status.SUCCESS

    def __init__(self, name: str, children: list[Behaviour]) -> None:
        composites.Sequence.__init__(self, name, memory=True, children=children)


class AsyncSequence(Sequence):
    """A Sequence that is RUNNING until the next tick when a child succeeds at once, so that it can be halted there."""

    PAUSES = True


class Fallback(_InOrder, composites.Selector):
    """Ticks its children in order. SUCCESS as soon as one succeeds, FAILURE when all have failed.

    While a child is RUNNING so is the fallback, and the next tick goes on with that child.
    """

    GOES_ON = Status.FAILURE

    def __init__(self, name: str, children: list[Behaviour]) -> None:
        composites.Selector.__init__(self, name, memory=True, children=children)


class AsyncFallback(Fallback):
    """A Fallback that is RUNNING until the next tick when a child fails at once, so that it can be halted there."""

    PAUSES = True


class SequenceWithMemory(ControlNode, composites.Sequence):
    """A Sequence that, after FAILURE or a halt, goes on with the child that failed or was halted.

    A child that succeeds in its first tick ends the sequence's tick (RUNNING); the next child comes with the next one.
    """

    _index = 0
    _skipped = 0

    def __init__(self, name: str, children: list[Behaviour]) -> None:
        composites.Sequence.__init__(self, name, memory=True, children=children)
        self._fresh = True

    def reset(self) -> None:
        # The place is kept on purpose; only the count of skipped children begins anew.
        self._fresh = True

    def step(self, visited: Visited) -> Status:
        if self._fresh:
            self._skipped, self._fresh = 0, False
        while self._index < len(self.children):
            child = self.current_child = self.children[self._index]
            first_tick = not is_active(child)
            status = tick_node(child, visited)
            if status is Status.RUNNING:
                return status
            if status is Status.FAILURE:
                for each in self.children[self._index + 1 :]:
                    halt(each)
                self._fresh = True
                return status
            self._index += 1
            if status is SKIPPED:
                self._skipped += 1
            elif first_tick and self._index < len(self.children):
                return Status.RUNNING
        status = SKIPPED if self._skipped == len(self.children) else Status.SUCCESS
        self._index = 0
        self._fresh = True
        self.settle()
        return status
