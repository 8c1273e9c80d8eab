"""Leaves that do what a test tells them, and write down what is done to them."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from itertools import cycle
from pathlib import Path
from typing import Any

import py_trees
from py_trees.common import Status
from py_trees.ports import PortInformation, PortsMixin

from target_nav.mission import NodeRegistry, load_mission
from target_nav.mission.nodes import halt

STATUS = {"S": Status.SUCCESS, "F": Status.FAILURE, "R": Status.RUNNING}
LETTER = {Status.SUCCESS: "S", Status.FAILURE: "F", Status.RUNNING: "R", Status.INVALID: "-"}


class ScriptedLeaf(PortsMixin, py_trees.behaviour.Behaviour, register=False):
    """Returns the letters of `SCRIPT` in turn, from the start again after the last.

    `log` gets `A>R` when A is begun and returned RUNNING, `A:S` for a later tick, `A!` when A is halted.
    """

    INPUT_PORTS: dict[str, PortInformation] = {}
    OUTPUT_PORTS: dict[str, PortInformation] = {}
    SCRIPT = "S"
    LOG: list[str] = []

    def __init__(self, name: str) -> None:
        super().__init__(name=name)
        self._script = cycle(self.SCRIPT)
        self._mark = ":"

    def initialise(self) -> None:
        self._mark = ">"

    def update(self) -> Status:
        letter = next(self._script)
        self.LOG.append(f"{type(self).__name__}{self._mark}{letter}")
        self._mark = ":"
        return STATUS[letter]

    def terminate(self, new_status: Status) -> None:
        if new_status is Status.INVALID:
            self.LOG.append(f"{type(self).__name__}!")


def scripted_leaves(scripts: dict[str, str], log: list[str]) -> list[type[ScriptedLeaf]]:
    """One leaf class a name, all writing to `log`."""
    return [
        type(name, (ScriptedLeaf,), {"SCRIPT": script, "LOG": log}, register=False)
        for name, script in scripts.items()
    ]


def leaf_class(
    name: str,
    inputs: dict[str, PortInformation] | None = None,
    outputs: dict[str, PortInformation] | None = None,
    limits: dict[str, tuple[float, float]] | None = None,
) -> type[ScriptedLeaf]:
    """A leaf with ports. It reads all of its inputs in every tick and keeps them in `seen`."""

    def update(self: Any) -> Status:
        self.seen = {port: self.get_input(port) for port in self.INPUT_PORTS}
        return Status.SUCCESS

    body: dict[str, Any] = {
        "INPUT_PORTS": inputs or {},
        "OUTPUT_PORTS": outputs or {},
        "PORT_LIMITS": limits or {},
        "update": update,
        "__doc__": f"Test leaf {name}.",
    }
    return type(name, (ScriptedLeaf,), body, register=False)


def document(*trees: str, main: str | None = "Main") -> str:
    """A mission file. A tree that is not a whole `<BehaviorTree>` becomes tree Main."""
    whole = (
        tree if "<BehaviorTree" in tree else f'<BehaviorTree ID="Main">{tree}</BehaviorTree>'
        for tree in trees
    )
    attribute = f' main_tree_to_execute="{main}"' if main else ""
    return f'<root BTCPP_format="4"{attribute}>{"".join(whole)}</root>'


def set_clock(now_s: float) -> None:
    py_trees.blackboard.Blackboard.set("/clock/now_s", now_s)


class Trace:
    """A mission of scripted leaves, and what happens in it tick by tick.

    `tick()` gives the root's letter and what was done to the leaves: `["R", "A>S", "B>R"]`.
    """

    def __init__(
        self,
        folder: Path,
        scripts: dict[str, str],
        *trees: str,
        xml: str = "",
        provided: Iterable[str] = (),
        enums: dict[str, int] | None = None,
    ) -> None:
        self._log: list[str] = []
        path = folder / "mission.xml"
        path.write_text(xml or document(*trees), encoding="utf-8")
        registry = NodeRegistry(scripted_leaves(scripts, self._log), enums)
        self.mission = load_mission(path, registry, provided)
        self.root = self.mission.root
        self._now_s = 0.0
        set_clock(0.0)

    def _taken(self) -> list[str]:
        taken = list(self._log)
        self._log.clear()
        return taken

    def tick(self, now_s: float | None = None) -> list[str]:
        if now_s is not None:
            set_clock(now_s)
        self.root.tick_once()
        return [LETTER[self.root.status], *self._taken()]

    def ticks(self, count: int) -> list[list[str]]:
        return [self.tick() for _ in range(count)]

    def ticks_at(self, times_s: Iterable[float]) -> list[list[str]]:
        return [self.tick(now_s) for now_s in times_s]

    def halt(self) -> list[str]:
        halt(self.root)
        return self._taken()


def spaced(*rows: str) -> list[list[str]]:
    """An expected trace: one row a tick, words between spaces."""
    return [row.split() for row in rows]


def names(nodes: Sequence[py_trees.behaviour.Behaviour]) -> list[str]:
    return [node.name for node in nodes]
