"""TryCatch: children in order, and one that cleans up when one of them fails. Of BehaviorTree.CPP 4.9."""

from __future__ import annotations

from py_trees import composites
from py_trees.behaviour import Behaviour
from py_trees.common import Status
from py_trees.ports import PortInformation

from target_nav.mission.nodes.base import ControlNode
from target_nav.mission.nodes.halting import halt
from target_nav.mission.nodes.ticking import SKIPPED, Visited, tick_node


class TryCatch(ControlNode, composites.Sequence):
    """Ticks all children but the last as a Sequence. When one fails, the last is ticked until it ends; then FAILURE.

    Success of all is SUCCESS, and the last child is not ticked at all.
    """

    CHILDREN = (2, None)
    INPUT_PORTS = {
        "catch_on_halt": PortInformation(
            bool, False, "true: the last child gets one tick also when the others are halted", False
        )
    }
    _index = 0
    _skipped = 0
    _catching = False

    def __init__(self, name: str, children: list[Behaviour]) -> None:
        composites.Sequence.__init__(self, name, memory=True, children=children)

    def reset(self) -> None:
        self._index = self._skipped = 0
        self._catching = False

    def stop(self, new_status: Status = Status.INVALID) -> None:
        if (
            new_status is Status.INVALID
            and self.active
            and not self._catching
            and self.input("catch_on_halt")
        ):
            for child in self.children[:-1]:
                halt(child)
            # What is RUNNING after this tick is halted with the rest.
            tick_node(self.children[-1], [])
        super().stop(new_status)

    def step(self, visited: Visited) -> Status:
        last = len(self.children) - 1
        while not self._catching and self._index < last:
            child = self.current_child = self.children[self._index]
            status = tick_node(child, visited)
            if status is Status.RUNNING:
                return status
            if status is Status.FAILURE:
                self.settle()
                self._catching = True
            elif status is SKIPPED:
                self._skipped += 1
            self._index += 1
        if self._catching:
            return self._catch(visited)
        status = SKIPPED if self._skipped == last else Status.SUCCESS
        self.settle()
        self.reset()
        return status

    def _catch(self, visited: Visited) -> Status:
        self.current_child = self.children[-1]
        if tick_node(self.children[-1], visited) is Status.RUNNING:
            return Status.RUNNING
        self.settle()
        self.reset()
        return Status.FAILURE
