"""Switch2 to Switch6: one child for each case, and one for all others."""

from __future__ import annotations

from enum import Enum
from typing import Any, ClassVar

from py_trees import composites
from py_trees.behaviour import Behaviour
from py_trees.common import Status
from py_trees.ports import PortInformation

from target_nav.mission.nodes.base import ControlNode
from target_nav.mission.nodes.halting import halt
from target_nav.mission.nodes.ticking import SKIPPED, Visited, tick_node
from target_nav.mission.script import ScriptError, as_text, number_in
from target_nav.mission.script.arithmetic import EPSILON, Enums, text_as_number


def is_case(value: Any, case: Any, enums: Enums) -> bool:
    """Whether a value is meant by a case: the same text, the same number, or the enum's constant of that number.

    `3` is 3 and 3.0, `RED` is what the constant RED is, `true` is true.
    """
    if isinstance(value, Enum) and isinstance(case, str) and value.name == case:
        return True
    if isinstance(value, bool) and case in ("true", "false"):
        return value is (case == "true")
    try:
        if as_text(value) == as_text(case):
            return True
        numbers = [_number(each, enums) for each in (value, case)]
    except ScriptError:
        return False
    return abs(numbers[0] - numbers[1]) <= EPSILON


def _number(value: Any, enums: Enums) -> float:
    if isinstance(value, str):
        return float(enums[value]) if value in enums else text_as_number(value, None)
    number = number_in(value)
    if number is None:
        raise ScriptError("no number")
    return float(number)


class _Switch(ControlNode, composites.Selector):
    CASES: ClassVar[int]
    BEGINS = False
    _running: Behaviour | None = None

    def __init__(self, name: str, children: list[Behaviour]) -> None:
        composites.Selector.__init__(self, name, memory=False, children=children)

    def reset(self) -> None:
        self._running = None

    def step(self, visited: Visited) -> Status:
        child = self.current_child = self.children[self._choice()]
        if self._running is not None and self._running is not child:
            halt(self._running)
        status = tick_node(child, visited)
        if status is Status.RUNNING:
            self._running = child
            return status
        self._running = None
        if status is not SKIPPED:
            self.settle()
        return status

    def _choice(self) -> int:
        value = self.input_or_none("variable")
        if value is not None:
            for index in range(self.CASES):
                case = self.input_or_none(f"case_{index + 1}")
                if case is not None and is_case(value, case, self.enums):
                    return index
        return self.CASES


def _ports(cases: int) -> dict[str, PortInformation]:
    ports = {
        "variable": PortInformation(
            object, True, "what is compared with the cases; without a value: the last child"
        )
    }
    for number in range(1, cases + 1):
        ports[f"case_{number}"] = PortInformation(
            object, True, f"when child {number} is ticked: a number, a text or a constant"
        )
    return ports


class Switch2(_Switch):
    """Ticks the child whose case the variable is, or the last one. A change of child halts the one that was RUNNING."""

    CASES, CHILDREN, INPUT_PORTS = 2, (3, 3), _ports(2)


class Switch3(_Switch):
    """Switch2 with 3 cases."""

    CASES, CHILDREN, INPUT_PORTS = 3, (4, 4), _ports(3)


class Switch4(_Switch):
    """Switch2 with 4 cases."""

    CASES, CHILDREN, INPUT_PORTS = 4, (5, 5), _ports(4)


class Switch5(_Switch):
    """Switch2 with 5 cases."""

    CASES, CHILDREN, INPUT_PORTS = 5, (6, 6), _ports(5)


class Switch6(_Switch):
    """Switch2 with 6 cases."""

    CASES, CHILDREN, INPUT_PORTS = 6, (7, 7), _ports(6)
