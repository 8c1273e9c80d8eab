"""A condition and what follows from it: IfThenElse, WhileDoElse."""

from __future__ import annotations

from py_trees import composites
from py_trees.behaviour import Behaviour
from py_trees.common import Status

from target_nav.mission.nodes.base import ControlNode
from target_nav.mission.nodes.halting import halt
from target_nav.mission.nodes.ticking import SKIPPED, Visited, tick_node


class _Branching(ControlNode):
    """The first child is the condition, the second is for SUCCESS, the third, if there is one, for FAILURE.

    py_trees sees a selector, its word for what decides between children.
    """

    CHILDREN = (2, 3)

    def ask(self, visited: Visited) -> Status:
        self.current_child = self.children[0]
        status = tick_node(self.children[0], visited)
        if status is SKIPPED:
            raise self.error(
                f"its condition {self.children[0].name!r} was skipped; it must end with SUCCESS or FAILURE"
            )
        return status

    def follow(self, branch: Behaviour, visited: Visited) -> Status:
        self.current_child = branch
        return tick_node(branch, visited)


class IfThenElse(_Branching, composites.Selector):
    """Asks its first child once, then ticks the second (SUCCESS) or the third (FAILURE) until that ends.

    Without a third child, FAILURE of the first is the result.
    """

    def __init__(self, name: str, children: list[Behaviour]) -> None:
        composites.Selector.__init__(self, name, memory=True, children=children)
        self._branch: Behaviour | None = None

    def reset(self) -> None:
        self._branch = None

    def step(self, visited: Visited) -> Status:
        if self._branch is None:
            answer = self.ask(visited)
            if answer is Status.RUNNING:
                return answer
            if answer is Status.SUCCESS:
                self._branch = self.children[1]
            elif len(self.children) == 3:
                self._branch = self.children[2]
            else:
                return answer
        status = self.follow(self._branch, visited)
        if status is not Status.RUNNING:
            self._branch = None
            self.settle()
        return status


class WhileDoElse(_Branching, composites.Selector):
    """Asks its first child in every tick, and ticks the second while it succeeds, the third while it fails.

    A change of the answer halts the other branch. Without a third child, FAILURE of the first is the result.
    """

    def __init__(self, name: str, children: list[Behaviour]) -> None:
        composites.Selector.__init__(self, name, memory=False, children=children)

    def step(self, visited: Visited) -> Status:
        status = self.ask(visited)
        if status is Status.RUNNING:
            return status
        both = len(self.children) == 3
        if status is Status.SUCCESS:
            if both:
                halt(self.children[2])
            status = self.follow(self.children[1], visited)
        elif both:
            halt(self.children[1])
            status = self.follow(self.children[2], visited)
        if status is not Status.RUNNING:
            self.settle()
        return status
