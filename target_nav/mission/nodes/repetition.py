"""Decorators that tick their child again: Repeat, RetryUntilSuccessful, KeepRunningUntilFailure.

A child that ends in its first tick is not begun again in the same tick: the decorator is RUNNING until the next one,
so no loop of a mission can hold up a tick.
"""

from __future__ import annotations

from typing import ClassVar

from py_trees.common import Status
from py_trees.ports import PortInformation

from target_nav.mission.nodes.base import DecoratorNode
from target_nav.mission.nodes.halting import halt, is_active
from target_nav.mission.nodes.ticking import SKIPPED, Visited, tick_node

MOST = 2**31 - 1
"""BehaviorTree.CPP counts in int."""


class _Counting(DecoratorNode):
    """Begins its child again after each `COUNTED` result, `PORT` times; -1 is for ever."""

    PORT: ClassVar[str]
    COUNTED: ClassVar[Status]
    ASKS_AGAIN: ClassVar[bool]
    """Whether a count that the child changes counts at once, not from the next tick on. As in BehaviorTree.CPP."""
    _count = 0

    def reset(self) -> None:
        self._count = 0

    def step(self, visited: Visited) -> Status:
        most = self.input(self.PORT)
        while self._goes_on(most):
            first_tick = not is_active(self.decorated)
            status = tick_node(self.decorated, visited)
            if status is SKIPPED:
                # skipped with its child; the count is kept
                halt(self.decorated)
                return status
            if status is Status.RUNNING:
                return status
            if status is not self.COUNTED:
                return self._end(status)
            self._count += 1
            if self.ASKS_AGAIN:
                most = self.input(self.PORT)
            if first_tick and self._goes_on(most):
                self.feedback_message = f"{self._count} of {most if most >= 0 else 'any number'}"
                return Status.RUNNING
        return self._end(self.COUNTED)

    def _goes_on(self, most: int) -> bool:
        return most == -1 or self._count < most

    def _end(self, status: Status) -> Status:
        self._count = 0
        self.feedback_message = ""
        # It is active still when the count was lowered while it ran.
        self.settle()
        return status


class Repeat(_Counting):
    """Ticks its child until it has succeeded `num_cycles` times in a row; FAILURE as soon as it fails once."""

    PORT = "num_cycles"
    COUNTED = Status.SUCCESS
    ASKS_AGAIN = False
    INPUT_PORTS = {"num_cycles": PortInformation(int, True, "successes until SUCCESS; -1: without end")}
    PORT_LIMITS = {"num_cycles": (-1, MOST)}


class RetryUntilSuccessful(_Counting):
    """Ticks its child until it succeeds; FAILURE when it has failed `num_attempts` times."""

    PORT = "num_attempts"
    COUNTED = Status.FAILURE
    ASKS_AGAIN = True
    INPUT_PORTS = {"num_attempts": PortInformation(int, True, "failures until FAILURE; -1: without end")}
    PORT_LIMITS = {"num_attempts": (-1, MOST)}


class KeepRunningUntilFailure(DecoratorNode):
    """Ticks its child again and again, RUNNING, until it fails."""

    def step(self, visited: Visited) -> Status:
        status = tick_node(self.decorated, visited)
        return Status.FAILURE if status is Status.FAILURE else Status.RUNNING
