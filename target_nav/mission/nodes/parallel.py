"""Children side by side: Parallel, ParallelAll."""

from __future__ import annotations

from py_trees import composites
from py_trees.behaviour import Behaviour
from py_trees.common import ParallelPolicy, Status
from py_trees.ports import PortInformation

from target_nav.mission.nodes.base import ControlNode
from target_nav.mission.nodes.halting import is_active
from target_nav.mission.nodes.ticking import SKIPPED, Visited, tick_node


class Parallel(ControlNode, composites.Parallel):
    """Ticks every child that has not finished. SUCCESS when `success_count` have succeeded, FAILURE when
    `failure_count` have failed or success has become impossible; the children still running are then halted.

    A negative count is from the end: -1 is all children.
    """

    INPUT_PORTS = {
        "success_count": PortInformation(int, False, "children that must succeed; -1: all of them", -1),
        "failure_count": PortInformation(int, False, "children that must fail; -1: all of them", 1),
    }

    def __init__(self, name: str, children: list[Behaviour]) -> None:
        # The policy is for py_trees' displays only: children that have succeeded are not ticked again.
        composites.Parallel.__init__(self, name, ParallelPolicy.SuccessOnAll(synchronise=True), children)
        self._clear()

    def _clear(self) -> None:
        self._finished: set[int] = set()
        self._successes = self._failures = 0

    def reset(self) -> None:
        self._clear()

    def step(self, visited: Visited) -> Status:
        count = len(self.children)
        wanted = self.input("success_count")
        success, failure = threshold(self, "success_count"), threshold(self, "failure_count")
        skipped = 0
        for index, child in enumerate(self.children):
            if index not in self._finished:
                status = tick_node(child, visited)
                if status is SKIPPED:
                    skipped += 1
                elif status is not Status.RUNNING:
                    self._finished.add(index)
                    self._successes += status is Status.SUCCESS
                    self._failures += status is Status.FAILURE
            if self._successes >= success or (wanted < 0 and self._successes + skipped >= success):
                return self._end(child, Status.SUCCESS)
            if count - self._failures < success or self._failures == failure:
                return self._end(child, Status.FAILURE)
        self.current_child = next(
            (each for each in reversed(self.children) if is_active(each)), self.children[-1]
        )
        return SKIPPED if skipped == count else Status.RUNNING

    def _end(self, decided_by: Behaviour, status: Status) -> Status:
        self.current_child = decided_by
        self._clear()
        self.settle()
        return status


class ParallelAll(ControlNode, composites.Parallel):
    """Ticks every child that has not finished, until all have. FAILURE if at least `max_failures` failed, else SUCCESS.

    A negative number is from the end: -1 is all children.
    """

    INPUT_PORTS = {
        "max_failures": PortInformation(int, False, "failures that make it FAILURE; -1: all of them", 1)
    }

    def __init__(self, name: str, children: list[Behaviour]) -> None:
        composites.Parallel.__init__(self, name, ParallelPolicy.SuccessOnAll(synchronise=True), children)
        self._clear()

    def _clear(self) -> None:
        self._finished: set[int] = set()
        self._failures = 0

    def reset(self) -> None:
        self._clear()

    def step(self, visited: Visited) -> Status:
        most = threshold(self, "max_failures")
        skipped = 0
        for index, child in enumerate(self.children):
            if index in self._finished:
                continue
            status = tick_node(child, visited)
            if status is SKIPPED:
                skipped += 1
            elif status is not Status.RUNNING:
                self._finished.add(index)
                self._failures += status is Status.FAILURE
        count = len(self.children)
        self.current_child = next(
            (each for each in reversed(self.children) if is_active(each)), self.children[-1]
        )
        if skipped == count:
            return SKIPPED
        if skipped + len(self._finished) < count:
            return Status.RUNNING
        self.settle()
        status = Status.FAILURE if self._failures >= most else Status.SUCCESS
        self._clear()
        return status


def threshold(node: ControlNode, port: str) -> int:
    """A number of children that a port gives, negative ones from the end."""
    value: int = node.input(port)
    count = len(node.children)
    if value > count:
        raise node.error(f"{port} is {value}, but it has {count} children")
    return max(count + value + 1, 0) if value < 0 else value
