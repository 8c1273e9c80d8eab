"""Stops and forced results put on the nodes of a running tree from outside, and taken off again.

For debuggers. A hook is asked whenever its node is about to be ticked, also while the node is RUNNING. It lets the tick
go on, gives a result in its place, or holds: then the tick ends as if the node had returned RUNNING, the node itself
is left as it was, and whoever holds keeps the tree from being ticked until the hook has an answer.
"""

from __future__ import annotations

from collections.abc import Callable
from enum import Enum

from py_trees.behaviour import Behaviour
from py_trees.common import Status

from target_nav.mission.nodes.halting import halt
from target_nav.mission.nodes.ticking import TICK, Tick, Visited, adopt


class Answer(Enum):
    """What a hook says before a tick of its node."""

    GO_ON = "tick it"
    HOLD = "hold"
    SUCCESS = "SUCCESS instead"
    FAILURE = "FAILURE instead"


_RESULTS = {Answer.SUCCESS: Status.SUCCESS, Answer.FAILURE: Status.FAILURE}
FORCED = "forced by a debugger"


class NodeHook:
    """One hook on one node, from its making until `remove`. A node has one at most."""

    def __init__(self, node: Behaviour, ask: Callable[[], Answer]) -> None:
        self._node, self._ask = node, ask
        self._was_own = node.__dict__.get(TICK)
        self._tick: Tick = getattr(node, TICK, None) or adopt(node)
        setattr(node, TICK, self._hooked)

    def remove(self) -> None:
        """The node is ticked as before."""
        if self._was_own is None:
            # a method of the class, or what `adopt` would give it again
            self._node.__dict__.pop(TICK, None)
        else:
            setattr(self._node, TICK, self._was_own)

    def _hooked(self, visited: Visited) -> Status:
        answer = self._ask()
        if answer is Answer.GO_ON:
            return self._tick(visited)
        if answer is Answer.HOLD:
            return Status.RUNNING
        # what it was doing ends first: a motion leaf takes its request back
        halt(self._node)
        self._node.status = _RESULTS[answer]
        self._node.feedback_message = FORCED
        visited.append(self._node)
        return _RESULTS[answer]
