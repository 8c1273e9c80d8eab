"""The same mission in BehaviorTree.CPP itself (`behaviortreepy`) and in target_nav, with the same scripted leaves.

A run is a list of rows, one a tick or halt: the root's letter, what was done to the leaves, in order, and what the main
tree's blackboard holds then. A row that ends with `error` is the last one: a script failed.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from itertools import cycle, permutations
from pathlib import Path
from typing import Any

from py_trees.behaviour import Behaviour
from py_trees.blackboard import Blackboard
from py_trees.common import Status

from target_nav.errors import MissionError
from target_nav.mission import NodeRegistry, load_mission
from target_nav.mission.nodes import Precondition, Visited, halt_tree, tick_node
from target_nav.mission.script import ScriptError, as_text
from tests.unit.mission.random_scripts import START
from tests.unit.mission.random_trees import TICKS, Trial
from tests.unit.mission.random_trees import make_plain_trial as make_trial
from tests.unit.mission.scripted import LETTER, ScriptedLeaf, scripted_leaves

EVERYWHERE = frozenset(f"/{letter}{digit}" for letter in "dtiubxpqjrscvk" for digit in range(10)) | {
    "/_d9",
    "/c_d",
    "/c_i",
}
"""Entries that may be missing when they are read: that is an error at run time, and to be compared."""

__all__ = [
    "REFUSED",
    "TICKS",
    "Trial",
    "first_difference",
    "load_here",
    "make_trial",
    "run_here",
    "run_there",
]

Row = list[str]

REFUSED: list[Row] = [["refused"]]
"""The mission could not be loaded."""


def _scopes() -> list[str]:
    """Every way in which three subtrees can be nested."""
    names = ("T0", "T1", "T2")
    return [f"/{'/'.join(way)}" for length in (1, 2, 3) for way in permutations(names, length)]


PROVIDED = frozenset(f"{tree}{key}" for tree in ("", *_scopes()) for key in EVERYWHERE)


class PreconditionAsThere(Precondition):
    """BehaviorTree.CPP's, once its `if` was true, asks again only when its child has ended; no halt or skip will do."""

    def reset(self) -> None:
        pass

    def step(self, visited: Visited) -> Status:
        if not self._passed and not self.run("if"):
            return super().step(visited)
        self._passed = True
        status = tick_node(self.decorated, visited)
        self._passed = status not in (Status.SUCCESS, Status.FAILURE)
        return status


def registry_as_there(leaves: list[type[ScriptedLeaf]]) -> NodeRegistry:
    """With the intended differences taken back that would show up in random trees."""
    registry = NodeRegistry(leaves)
    spec = registry.find("Precondition")
    assert spec is not None
    registry._specs["Precondition"] = replace(spec, cls=PreconditionAsThere)
    return registry


def load_here(trial: Trial, folder: Path, log: list[str], as_there: bool = True) -> Behaviour:
    """A trial as target_nav's tree, its blackboard as it begins; its leaves write to `log`."""
    path = folder / "trial.xml"
    path.write_text(trial.xml, encoding="utf-8")
    for name, value in START.items():
        Blackboard.set(f"/{name}", value)
    leaves = scripted_leaves(trial.scripts, log)
    for leaf in leaves:
        if leaf.__name__ in trial.writes:
            _make_writing(leaf, *trial.writes[leaf.__name__])
    return load_mission(path, registry_as_there(leaves) if as_there else NodeRegistry(leaves), PROVIDED).root


def run_here(trial: Trial, folder: Path, as_there: bool = True) -> list[Row]:
    """What target_nav does; `as_there`: but for an intended difference that random trees would show."""
    log: list[str] = []
    try:
        root = load_here(trial, folder, log, as_there)
    except MissionError:
        return REFUSED

    def tick(number: int) -> str:
        Blackboard.set("/k0", number)
        root.tick_once()
        return LETTER[root.status]

    # Immediate leaves have neither a beginning nor a halt in BehaviorTree.CPP.
    def taken() -> Row:
        words = [word.replace(">", ":") if word[0] in "CW" else word for word in log]
        log.clear()
        return words

    def board() -> Row:
        return [
            f"{key[1:]}={_value_text(value)}"
            for key, value in sorted(Blackboard.storage.items())
            if key.count("/") == 1
        ]

    return _run(trial, tick, lambda: halt_tree(root), taken, board, MissionError)


def _make_writing(leaf: type[ScriptedLeaf], key: str, value: float) -> None:
    update = leaf.update

    def update_and_write(self: ScriptedLeaf) -> Status:
        Blackboard.set(f"/{key}", value)
        return update(self)

    leaf.update = update_and_write  # type: ignore[method-assign]


def _value_text(value: object) -> str:
    try:
        return as_text(value)
    except ScriptError:
        return repr(value)


def run_there(trial: Trial, bt: Any) -> list[Row]:
    """What BehaviorTree.CPP does; `bt` is the module `behaviortreepy`."""
    status = {"S": bt.NodeStatus.SUCCESS, "F": bt.NodeStatus.FAILURE, "R": bt.NodeStatus.RUNNING}
    letter = {value: key for key, value in status.items()} | {bt.NodeStatus.SKIPPED: "-"}
    log: list[str] = []
    factory = bt.BehaviorTreeFactory()
    for name, script in trial.scripts.items():
        results = cycle(script)

        def call(node: Any, mark: str, name: str = name, results: Any = results) -> Any:
            if name in trial.writes:
                key, value = trial.writes[name]
                board = node.config().blackboard
                (board.set_double if isinstance(value, float) else board.set_int)(f"@{key}", value)
            result = next(results)
            log.append(f"{name}{mark}{result}")
            return status[result]

        def halted(node: Any, name: str = name) -> None:
            log.append(f"{name}!")

        if name[0] in "CW":
            factory.register_simple_condition(name, lambda node, call=call: call(node, ":"))
        else:
            factory.register_simple_stateful_action(
                name, lambda node, call=call: call(node, ">"), lambda node, call=call: call(node, ":"), halted
            )
    # Before the tree is made: its ports would give entries types of their own.
    entries = bt.Blackboard.create()
    setters = {
        bool: entries.set_bool,
        int: entries.set_int,
        float: entries.set_double,
        str: entries.set_string,
    }
    for name, value in START.items():
        setters[type(value)](name, value)
    try:
        factory.register_behavior_tree_from_text(trial.xml)
        tree = factory.create_tree("Main", entries)
    except RuntimeError:
        return REFUSED

    def taken() -> Row:
        words = list(log)
        log.clear()
        return words

    def board() -> Row:
        rows = []
        for key in sorted(entries.get_keys()):
            try:
                rows.append(f"{key}={entries.get_string(key)}")
            except RuntimeError:
                # a port is bound to it, but it has no value
                continue
        return rows

    def tick(number: int) -> str:
        entries.set_int("k0", number)
        return letter[tree.tick_exactly_once()]

    return _run(trial, tick, tree.halt_tree, taken, board, RuntimeError)


def _run(
    trial: Trial,
    tick: Callable[[int], str],
    halt: Callable[[], None],
    taken: Callable[[], Row],
    board: Callable[[], Row],
    failure: type[Exception],
) -> list[Row]:
    rows: list[Row] = []
    for number in range(TICKS):
        try:
            rows.append([tick(number), *taken(), *board()])
            if number in trial.halts:
                halt()
                rows.append(["halt", *taken(), *board()])
        except failure:
            rows.append([*taken(), *board(), "error"])
            break
    return rows


def first_difference(here: list[Row], there: list[Row]) -> str:
    """Empty when both did the same, else a text for a person."""
    for number, (ours, theirs) in enumerate(zip(here, there)):
        if ours != theirs:
            return f"row {number}: here {' '.join(ours)} | BehaviorTree.CPP {' '.join(theirs)}"
    return "" if len(here) == len(there) else f"{len(here)} rows here, {len(there)} there"
