"""Halting nodes, as BehaviorTree.CPP does it: a halt reaches exactly those that are running."""

from __future__ import annotations

from collections.abc import Sequence

from py_trees.behaviour import Behaviour
from py_trees.common import Status

# An enum's members are looked up in a class each time; a tick asks for them hundreds of times.
_RUNNING, _INVALID = Status.RUNNING, Status.INVALID


class StaysActive:
    """A node of which py_trees' status does not tell whether it runs: it may have been skipped in the last tick."""

    active: bool = False
    """BehaviorTree.CPP's RUNNING: from the first tick to a result or a halt, skipped ticks included."""


def is_active(node: Behaviour) -> bool:
    """Whether the node has begun and has not finished; only such a node is halted."""
    if node.status is _INVALID:
        # skipped, but active still
        return isinstance(node, StaysActive) and node.active
    return node.status is _RUNNING


def halt(node: Behaviour) -> None:
    """Stops the node if it is active; one that has finished only loses its status."""
    if is_active(node):
        node.stop(_INVALID)
    else:
        forget(node)


def halt_tree(root: Behaviour) -> None:
    """Halts a whole tree: what is active below a node that is not, too, as a skipped node can be."""
    halt(root)
    halt_below(root)


def halt_below(node: Behaviour) -> None:
    for child in node.children:
        if is_active(child):
            halt(child)
        halt_below(child)


def forget(node: Behaviour) -> None:
    """Clears what is left to be seen of a finished node and its descendants."""
    if node.status is not _INVALID:
        node.status = _INVALID
        if node.children:
            forget_all(node.children)


def forget_all(nodes: Sequence[Behaviour]) -> None:
    for node in nodes:
        if node.status is not _INVALID:
            node.status = _INVALID
            if node.children:
                forget_all(node.children)
