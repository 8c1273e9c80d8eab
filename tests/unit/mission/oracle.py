"""Random trees, ticked by BehaviorTree.CPP itself (`behaviortreepy`) and by target_nav with the same scripted leaves.

A run is a list of rows, one a tick or halt: the root's letter and what was done to the leaves, in order. Two kinds of
leaves: stateful ones (`A0`: begun, ticked, halted) and immediate ones (`C0`: SUCCESS or FAILURE in one tick).
"""

from __future__ import annotations

import random
from collections.abc import Callable
from dataclasses import dataclass, field
from itertools import cycle
from pathlib import Path
from typing import Any

from target_nav.mission import NodeRegistry, load_mission
from target_nav.mission.nodes import halt
from tests.unit.mission.scripted import LETTER, document, scripted_leaves

TICKS = 12

CONTROLS = ("Sequence", "Fallback", "SequenceWithMemory", "ReactiveSequence", "ReactiveFallback", "Parallel")
DECORATORS = (
    "Inverter",
    "ForceSuccess",
    "ForceFailure",
    "KeepRunningUntilFailure",
    "Repeat",
    "RetryUntilSuccessful",
    "RunOnce",
    "Timeout",
)


@dataclass
class Trial:
    """One generated tree. `scripts` are of the leaves; `halts` are the ticks after which the tree is halted."""

    xml: str
    scripts: dict[str, str]
    halts: frozenset[int]


@dataclass
class _Maker:
    rng: random.Random
    scripts: dict[str, str] = field(default_factory=dict)
    trees: list[str] = field(default_factory=list)

    def leaf(self) -> str:
        if self.rng.random() < 0.15:
            return self.rng.choice(("<AlwaysSuccess/>", "<AlwaysFailure/>", '<Sleep msec="0"/>'))
        name = f"A{len(self.scripts)}"
        self.scripts[name] = "".join(self.rng.choices("SFR", (3, 2, 3), k=self.rng.randint(1, 5)))
        return f"<{name}/>"

    def condition(self) -> str:
        """Immediate, because a stateful leaf that has finished keeps its result there; see docs/mission-language.md."""
        name = f"C{len(self.scripts)}"
        self.scripts[name] = "".join(self.rng.choices("SF", k=self.rng.randint(1, 5)))
        return self.rng.choice((f"<{name}/>", f"<{name}/>", f"<Inverter><{name}/></Inverter>"))

    def node(self, depth: int) -> str:
        roll = self.rng.random()
        if depth <= 0 or roll < 0.15:
            return self.leaf() if roll < 0.12 else self.condition()
        if roll < 0.55:
            return self.control(depth)
        if roll < 0.65:
            return self.branching(depth)
        if roll < 0.72 and len(self.trees) < 3:
            return self.subtree(depth)
        return self.decorator(depth)

    def children(self, depth: int, least: int = 1, most: int = 4) -> list[str]:
        return [self.node(depth - 1) for _ in range(self.rng.randint(least, most))]

    def control(self, depth: int) -> str:
        tag, children, attributes = self.rng.choice(CONTROLS), self.children(depth), ""
        if tag == "Parallel":
            count = len(children)
            if self.rng.random() < 0.7:
                attributes += f' success_count="{self.rng.randint(-count, count)}"'
            if self.rng.random() < 0.7:
                attributes += f' failure_count="{self.rng.randint(-count, count)}"'
        return f"<{tag}{attributes}>{''.join(children)}</{tag}>"

    def branching(self, depth: int) -> str:
        tag = self.rng.choice(("IfThenElse", "WhileDoElse"))
        branches = self.children(depth, 1, 2)
        return f"<{tag}>{self.condition()}{''.join(branches)}</{tag}>"

    def decorator(self, depth: int) -> str:
        tag = self.rng.choice(DECORATORS)
        attributes = {
            "Repeat": f' num_cycles="{self.rng.choice((-1, 0, 1, 2, 3))}"',
            "RetryUntilSuccessful": f' num_attempts="{self.rng.choice((-1, 0, 1, 2, 3))}"',
            "RunOnce": self.rng.choice(("", ' then_skip="false"', ' then_skip="true"')),
            "Timeout": f' msec="{self.rng.choice((0, 1_000_000))}"',
        }.get(tag, "")
        return f"<{tag}{attributes}>{self.node(depth - 1)}</{tag}>"

    def subtree(self, depth: int) -> str:
        name = f"T{len(self.trees)}"
        self.trees.append("")
        self.trees[int(name[1:])] = f'<BehaviorTree ID="{name}">{self.node(depth - 1)}</BehaviorTree>'
        return f'<SubTree ID="{name}"/>'


def make_trial(seed: int, depth: int = 4) -> Trial:
    rng = random.Random(seed)
    maker = _Maker(rng)
    root = maker.control(depth) if rng.random() < 0.8 else maker.node(depth)
    halts = frozenset(tick for tick in range(TICKS) if rng.random() < 0.15)
    return Trial(document(root, *maker.trees), maker.scripts, halts)


def run_here(trial: Trial, folder: Path) -> list[list[str]]:
    """What target_nav does."""
    log: list[str] = []
    path = folder / "trial.xml"
    path.write_text(trial.xml, encoding="utf-8")
    root = load_mission(path, NodeRegistry(scripted_leaves(trial.scripts, log))).root

    def tick() -> str:
        root.tick_once()
        return LETTER[root.status]

    # Immediate leaves have neither a beginning nor a halt in BehaviorTree.CPP.
    def taken() -> list[str]:
        words = [word.replace(">", ":") if word.startswith("C") else word for word in log]
        log.clear()
        return words

    return _run(trial, tick, lambda: halt(root), taken)


def run_there(trial: Trial, bt: Any) -> list[list[str]]:
    """What BehaviorTree.CPP does; `bt` is the module `behaviortreepy`."""
    status = {"S": bt.NodeStatus.SUCCESS, "F": bt.NodeStatus.FAILURE, "R": bt.NodeStatus.RUNNING}
    letter = {value: key for key, value in status.items()} | {bt.NodeStatus.SKIPPED: "-"}
    log: list[str] = []
    factory = bt.BehaviorTreeFactory()
    for name, script in trial.scripts.items():
        results = cycle(script)

        def call(node: Any, mark: str, name: str = name, results: Any = results) -> Any:
            result = next(results)
            log.append(f"{name}{mark}{result}")
            return status[result]

        def halted(node: Any, name: str = name) -> None:
            log.append(f"{name}!")

        if name.startswith("C"):
            factory.register_simple_condition(name, lambda node, call=call: call(node, ":"))
        else:
            factory.register_simple_stateful_action(
                name, lambda node, call=call: call(node, ">"), lambda node, call=call: call(node, ":"), halted
            )
    factory.register_behavior_tree_from_text(trial.xml)
    tree = factory.create_tree("Main")

    def taken() -> list[str]:
        words = list(log)
        log.clear()
        return words

    return _run(trial, lambda: letter[tree.tick_exactly_once()], tree.halt_tree, taken)


def _run(
    trial: Trial, tick: Callable[[], str], halt: Callable[[], None], taken: Callable[[], list[str]]
) -> list[list[str]]:
    rows = []
    for number in range(TICKS):
        rows.append([tick(), *taken()])
        if number in trial.halts:
            halt()
            rows.append(["halt", *taken()])
    return rows


def first_difference(here: list[list[str]], there: list[list[str]]) -> str:
    """Empty when both did the same, else a text for a person."""
    for number, (ours, theirs) in enumerate(zip(here, there, strict=True)):
        if ours != theirs:
            return f"row {number}: here {' '.join(ours)} | BehaviorTree.CPP {' '.join(theirs)}"
    return ""
