"""One tick of any node: a mission's own, a leaf, or a whole tree of py_trees.

A leaf is ticked without py_trees' generators and debug messages, which cost more than all the rest of its tick.
"""

from __future__ import annotations

from collections.abc import Callable
from types import MethodType

from py_trees.behaviour import Behaviour
from py_trees.common import Status

from target_nav.errors import MissionError

Visited = list[Behaviour]
"""What a tick passed through, in the order in which it was done with."""

Tick = Callable[[Visited], Status]

SKIPPED = Status.INVALID
SKIPPED_MESSAGE = "skipped"
# An enum's members are looked up in a class each time; a tick asks for them hundreds of times.
_SUCCESS, _FAILURE, _RUNNING, _INVALID = Status.SUCCESS, Status.FAILURE, Status.RUNNING, Status.INVALID

TICK = "mission_tick"
"""The attribute by which a mission ticks a behaviour. A leaf gets it with its first tick, see `adopt`."""


def tick_node(node: Behaviour, visited: Visited) -> Status:
    """Ticks a node once; INVALID means that it was skipped.

    Raises:
        MissionError: a leaf returned something that is no result, or a script failed.
    """
    tick: Tick = getattr(node, TICK, None) or adopt(node)
    return tick(visited)


def adopt(leaf: Behaviour) -> Tick:
    """Gives a leaf, or a whole tree of py_trees, what `tick_node` calls."""
    function: Callable[[Behaviour, Visited], Status]
    if type(leaf).tick is not Behaviour.tick:
        function = _tick_foreign
    elif type(leaf).stop is not Behaviour.stop:
        function = _tick_leaf_with_stop
    else:
        function = _tick_leaf
    tick: Tick = MethodType(function, leaf)
    setattr(leaf, TICK, tick)
    return tick


def _tick_leaf(leaf: Behaviour, visited: Visited) -> Status:
    if leaf.status is not _RUNNING:
        leaf.initialise()
    status = leaf.update()
    if status is _SUCCESS or status is _FAILURE:
        # what Behaviour.stop does but for writing a debug message, which costs more than all the rest of a leaf's tick
        leaf.terminate(status)
    elif status is not _RUNNING:
        raise _no_result(leaf, status)
    leaf.status = status
    visited.append(leaf)
    return status


def _tick_leaf_with_stop(leaf: Behaviour, visited: Visited) -> Status:
    if leaf.status is not _RUNNING:
        leaf.initialise()
    status = leaf.update()
    if status is _SUCCESS or status is _FAILURE:
        leaf.stop(status)
    elif status is not _RUNNING:
        raise _no_result(leaf, status)
    leaf.status = status
    visited.append(leaf)
    return status


def _tick_foreign(tree: Behaviour, visited: Visited) -> Status:
    visited.extend(tree.tick())
    if tree.status is _INVALID:
        raise _no_result(tree, tree.status)
    return tree.status


def _no_result(leaf: Behaviour, status: object) -> MissionError:
    # A forgotten `return` must not pass for "skipped", which lets a sequence go on.
    return MissionError(
        f"leaf {leaf.name!r} ({type(leaf).__name__}) returned {status!r}; it must return SUCCESS, FAILURE or RUNNING"
    )
