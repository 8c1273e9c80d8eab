"""Nodes that run a script: Script, ScriptCondition, Precondition."""

from __future__ import annotations

from typing import ClassVar

from py_trees.common import Status
from py_trees.ports import PortInformation

from target_nav.mission.nodes.base import DecoratorNode
from target_nav.mission.nodes.leaves import LeafNode
from target_nav.mission.nodes.loops import Result
from target_nav.mission.nodes.ticking import Visited, tick_node


class Script(LeafNode):
    """Runs a script. SUCCESS at once."""

    INPUT_PORTS = {"code": PortInformation(str, True, "what is run")}
    SCRIPT_PORTS = {"code": "runs"}

    def step(self, visited: Visited) -> Status:
        self.run("code")
        return Status.SUCCESS


class ScriptCondition(LeafNode):
    """SUCCESS if a script's value is true, else FAILURE."""

    INPUT_PORTS = {"code": PortInformation(str, True, "what is asked")}
    SCRIPT_PORTS = {"code": "decides"}

    def step(self, visited: Visited) -> Status:
        return Status.SUCCESS if self.run("code") else Status.FAILURE


class Precondition(DecoratorNode):
    """If a script's value is true when it begins, ticks its child until that ends; otherwise it is what `else` says."""

    BEGINS: ClassVar[bool] = False
    INPUT_PORTS = {
        "if": PortInformation(str, True, "what is asked, once"),
        "else": PortInformation(Result, False, "the result when it is not true", Result.FAILURE),
    }
    SCRIPT_PORTS = {"if": "decides"}
    _passed = False

    def reset(self) -> None:
        self._passed = False

    def step(self, visited: Visited) -> Status:
        if not self._passed and not self.run("if"):
            result: Result = self.input("else")
            return result.value
        status = tick_node(self.decorated, visited)
        self._passed = status is Status.RUNNING
        return status
