"""Pre- and postconditions: scripts round the tick of any node, as attributes of its tag.

Before a node begins: `_failureIf`, `_successIf` and `_skipIf`, in this order; the first that is true gives its result
instead of the tick. Then, and before every tick while it runs: `_while`; when that is not true the node is skipped, and
halted first if it runs. After a result, one from a precondition included: `_onSuccess` or `_onFailure`, then `_post`.
After a halt: `_onHalted`.

A node without any has no cost: one that has some gets a tick of its own.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import Final

from py_trees.behaviour import Behaviour
from py_trees.common import Status

from target_nav.mission.nodes.base import MissionNode
from target_nav.mission.nodes.halting import forget, halt, is_active
from target_nav.mission.nodes.ticking import SKIPPED, SKIPPED_MESSAGE, TICK, Tick, Visited, adopt

_RESULTS: Final = {"_failureIf": Status.FAILURE, "_successIf": Status.SUCCESS, "_skipIf": SKIPPED}


@dataclass(frozen=True)
class Conditions:
    """Scripts by attribute name. Those before a tick return whether they hold."""

    before: dict[str, Callable[[], bool]]
    after: dict[str, Callable[[], object]]


def attach(node: Behaviour, conditions: Conditions) -> None:
    """Makes the conditions part of the node's ticks and halts."""
    tick: Tick = node.mission_tick if isinstance(node, MissionNode) else adopt(node)
    on_halted = conditions.after.get("_onHalted")
    conditioned = _Conditioned(node, tick, conditions)
    setattr(node, TICK, conditioned)
    if isinstance(node, MissionNode):
        node.on_halted = on_halted
        return
    # A leaf can be a whole mission; then py_trees ticks and stops it.
    node.__dict__.update(tick=conditioned.as_generator, tick_once=conditioned.once)
    if on_halted is not None:
        node.__dict__["stop"] = _stop_with(node, on_halted)


def _stop_with(leaf: Behaviour, on_halted: Callable[[], object]) -> Callable[[Status], None]:
    own = leaf.stop

    def stop(new_status: Status = Status.INVALID) -> None:
        was_active = is_active(leaf)
        own(new_status)
        if was_active and new_status is Status.INVALID:
            on_halted()

    return stop


class _Conditioned:
    def __init__(self, node: Behaviour, tick: Tick, conditions: Conditions) -> None:
        before, after = conditions.before, conditions.after
        self._node = node
        self._tick = tick
        self._instead = [(before[name], _RESULTS[name], name) for name in _RESULTS if name in before]
        self._while = before.get("_while")
        self._on_success = [after[name] for name in ("_onSuccess", "_post") if name in after]
        self._on_failure = [after[name] for name in ("_onFailure", "_post") if name in after]
        self._said = False

    def __call__(self, visited: Visited) -> Status:
        node = self._node
        if is_active(node):
            if self._while is not None and not self._while():
                halt(node)
                status = self._without_tick(SKIPPED, "_while", visited)
            else:
                status = self._ticked(visited)
        else:
            status = self._begin(visited)
        if status is Status.SUCCESS:
            for script in self._on_success:
                script()
        elif status is Status.FAILURE:
            for script in self._on_failure:
                script()
        return status

    def as_generator(self) -> Iterator[Behaviour]:
        visited: Visited = []
        self(visited)
        yield from visited

    def once(self) -> None:
        self([])

    def _begin(self, visited: Visited) -> Status:
        for holds, result, name in self._instead:
            if holds():
                return self._without_tick(result, name, visited)
        if self._while is not None and not self._while():
            return self._without_tick(SKIPPED, "_while", visited)
        return self._ticked(visited)

    def _ticked(self, visited: Visited) -> Status:
        if self._said:
            self._said, self._node.feedback_message = False, ""
        return self._tick(visited)

    def _without_tick(self, status: Status, name: str, visited: Visited) -> Status:
        node = self._node
        forget(node)
        node.status = status
        self._said = True
        node.feedback_message = f"{SKIPPED_MESSAGE}: {name}" if status is SKIPPED else f"not ticked: {name}"
        visited.append(node)
        return status
