"""Children from the first again in every tick: ReactiveSequence, ReactiveFallback."""

from __future__ import annotations

from typing import ClassVar

from py_trees import composites
from py_trees.behaviour import Behaviour
from py_trees.common import Status

from target_nav.mission.nodes.base import ControlNode
from target_nav.mission.nodes.halting import halt
from target_nav.mission.nodes.ticking import SKIPPED, Visited, tick_node


class _Reactive(ControlNode):
    """Ticks children from the first one, as long as they return `GOES_ON`; one RUNNING child halts all others."""

    GOES_ON: ClassVar[Status]

    def step(self, visited: Visited) -> Status:
        all_skipped = True
        for index, child in enumerate(self.children):
            self.current_child = child
            status = tick_node(child, visited)
            if status is SKIPPED:
                # so that it can be skipped again
                halt(child)
                continue
            all_skipped = False
            if status is Status.RUNNING:
                # those before it have just finished, so there is nothing to halt
                for later in self.children[index + 1 :]:
                    halt(later)
                return status
            if status is not self.GOES_ON:
                self.settle()
                return status
        self.settle()
        return SKIPPED if all_skipped else self.GOES_ON


class ReactiveSequence(_Reactive, composites.Sequence):
    """A Sequence that asks all children before the RUNNING one again in every tick.

    When one of them fails, or is RUNNING itself, the child that was RUNNING is halted.
    """

    GOES_ON = Status.SUCCESS

    def __init__(self, name: str, children: list[Behaviour]) -> None:
        composites.Sequence.__init__(self, name, memory=False, children=children)


class ReactiveFallback(_Reactive, composites.Selector):
    """A Fallback that asks all children before the RUNNING one again in every tick.

    When one of them succeeds, or is RUNNING itself, the child that was RUNNING is halted.
    """

    GOES_ON = Status.FAILURE

    def __init__(self, name: str, children: list[Behaviour]) -> None:
        composites.Selector.__init__(self, name, memory=False, children=children)
