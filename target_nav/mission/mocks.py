"""Leaves that do as they are told, in the place of a mission's own: for testing the tree without its skills.

As BehaviorTree.CPP's substitution rules, by pattern of name or path. A mocked leaf keeps its name, its ports and its
place in the tree, so that displays, remappings and conditions on it stay as they are; only what it does is replaced.
A mocked SubTree or control node answers for everything below it, which is then never ticked.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

from py_trees.behaviour import Behaviour
from py_trees.blackboard import Blackboard
from py_trees.common import Status
from py_trees.ports import PortsMixin

from behaviours.motion import MotionLeaf
from target_nav.mission.nodes import MissionNode, Visited
from target_nav.state import keys
from target_nav.state.types import STOP, MotionRequest, NavState, Twist2D

ROUNDING_S = 1e-6
RESULTS = (Status.SUCCESS, Status.FAILURE, Status.RUNNING)


@dataclass(frozen=True)
class MockSpec:
    """How a mock answers.

    Attributes:
        pattern: which behaviours it stands in for
        returns: one status a tick, in turn; the last one again and again
        after_s: RUNNING for so long each time it begins, before `returns` is asked
        message: what it says beside its status
        writes: values by output port, or by key of the blackboard (`/why`), written when it ends
        twist: what it asks of the wheels while RUNNING, if it stands in for a motion leaf
    """

    pattern: str
    returns: Sequence[Status] = (Status.SUCCESS,)
    after_s: float = 0.0
    message: str = ""
    writes: Mapping[str, Any] = field(default_factory=dict)
    twist: Twist2D = STOP

    def __post_init__(self) -> None:
        if not self.returns:
            raise ValueError(f"the mock of {self.pattern!r} returns nothing; give one status at least")


class Mock:
    """Stands in for one behaviour from now on. `begun` and `halted` count what was done to it."""

    def __init__(self, behaviour: Behaviour, spec: MockSpec) -> None:
        self.behaviour, self.spec = behaviour, spec
        self.begun = self.halted = 0
        self._next = 0
        self._begun_s = 0.0
        if isinstance(behaviour, MissionNode):
            behaviour.__dict__.update(step=self._step, reset=self._reset)
        else:
            behaviour.__dict__.update(
                initialise=self._initialise, update=self._update, terminate=self._terminate
            )

    def _step(self, visited: Visited) -> Status:
        if self.behaviour.status is not Status.RUNNING:
            self._initialise()
        status = self._update()
        if status is not Status.RUNNING:
            self._end(status)
        return status

    def _reset(self) -> None:
        self.halted += 1

    def _initialise(self) -> None:
        self.begun += 1
        self._begun_s = _now_s()

    def _update(self) -> Status:
        self.behaviour.feedback_message = self.spec.message or "mocked"
        if _now_s() < self._begun_s + self.spec.after_s - ROUNDING_S:
            status = Status.RUNNING
        else:
            status = self.spec.returns[min(self._next, len(self.spec.returns) - 1)]
            self._next += 1
        if status is Status.RUNNING and isinstance(self.behaviour, MotionLeaf):
            self._ask_for_motion(self.behaviour)
        return status

    def _terminate(self, new_status: Status) -> None:
        if isinstance(self.behaviour, MotionLeaf):
            request = Blackboard.storage.get(keys.REQUEST.name)
            if request is not None and request.owner == self.behaviour.id.hex:
                Blackboard.set(keys.REQUEST.name, None)
        if new_status is Status.INVALID:
            self._reset()
        else:
            self._end(new_status)

    def _ask_for_motion(self, leaf: MotionLeaf) -> None:
        state: NavState = leaf.STATE
        request = MotionRequest(
            leaf.id.hex, state, self.spec.twist, leaf.feedback_message, near_target=leaf.NEAR_TARGET
        )
        Blackboard.set(keys.REQUEST.name, request)

    def _end(self, status: Status) -> None:
        for name, value in self.spec.writes.items():
            if name.startswith("/"):
                Blackboard.set(name, value)
            elif isinstance(self.behaviour, PortsMixin):
                self.behaviour._set_output(name, value)


def unknown_outputs(behaviour: Behaviour, spec: MockSpec) -> list[str]:
    """What `spec` writes and the behaviour has no output port for."""
    ports = behaviour.output_ports() if isinstance(behaviour, PortsMixin) else {}
    return [name for name in spec.writes if not name.startswith("/") and name not in ports]


def _now_s() -> float:
    return float(Blackboard.storage.get(keys.NOW_S.name, 0.0))
