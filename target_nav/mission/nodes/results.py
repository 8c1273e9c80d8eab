"""Decorators that change a result: Inverter, ForceSuccess, ForceFailure; and RunOnce, which keeps one."""

from __future__ import annotations

from typing import ClassVar

from py_trees.common import Status
from py_trees.ports import PortInformation

from target_nav.mission.nodes.base import DecoratorNode
from target_nav.mission.nodes.ticking import SKIPPED, Visited, tick_node


class _ResultOf(DecoratorNode):
    RESULT_OF: ClassVar[dict[Status, Status]]

    def step(self, visited: Visited) -> Status:
        status = tick_node(self.decorated, visited)
        return self.RESULT_OF.get(status, status)


class Inverter(_ResultOf):
    """SUCCESS for FAILURE and FAILURE for SUCCESS."""

    RESULT_OF = {Status.SUCCESS: Status.FAILURE, Status.FAILURE: Status.SUCCESS}


class ForceSuccess(_ResultOf):
    """SUCCESS, however its child ends."""

    RESULT_OF = {Status.SUCCESS: Status.SUCCESS, Status.FAILURE: Status.SUCCESS}


class ForceFailure(_ResultOf):
    """FAILURE, however its child ends."""

    RESULT_OF = {Status.SUCCESS: Status.FAILURE, Status.FAILURE: Status.FAILURE}


class RunOnce(DecoratorNode):
    """Ticks its child until it ends, once in the tree's life. Later it is skipped, or returns the same result again."""

    INPUT_PORTS = {
        "then_skip": PortInformation(
            bool, False, "true: skip later ticks; false: repeat the first result", True
        )
    }
    _result: Status | None = None

    def step(self, visited: Visited) -> Status:
        if self._result is not None:
            self.active = False
            return SKIPPED if self.input("then_skip") else self._result
        status = tick_node(self.decorated, visited)
        if status in (Status.SUCCESS, Status.FAILURE):
            self._result = status
        return status
