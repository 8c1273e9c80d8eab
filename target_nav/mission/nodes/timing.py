"""Nodes that know the time: Timeout, Delay, Sleep. The time is the mission's clock on the blackboard, never the wall's.

Time passes from tick to tick only, so a node that waits 1 s ends with the first tick that is 1 s or more later.
"""

from __future__ import annotations

from py_trees.behaviour import Behaviour
from py_trees.blackboard import Client
from py_trees.common import Access, Status
from py_trees.ports import PortInformation

from target_nav.errors import MissionError
from target_nav.mission.nodes.base import DecoratorNode
from target_nav.mission.nodes.halting import halt, is_active
from target_nav.mission.nodes.leaves import LeafNode
from target_nav.mission.nodes.ticking import Visited, tick_node
from target_nav.state.keys import NOW_S

MOST_MSEC = 2**32 - 1
"""BehaviorTree.CPP's milliseconds are unsigned int."""

ROUNDING_S = 1e-6
"""Twenty ticks of 0.05 s add up to 1 s only nearly."""


class Clock:
    """The mission's clock, with the countdown of one node."""

    def __init__(self, owner: Behaviour) -> None:
        self._owner = owner
        self._client: Client = owner.attach_blackboard_client(name=f"{owner.name} (clock)")
        self._client.register_key(key=NOW_S.name, access=Access.READ)
        self._end_s: float | None = None

    @property
    def started(self) -> bool:
        return self._end_s is not None

    def start(self, msec: int) -> None:
        self._end_s = self._now_s() + msec / 1000.0

    def clear(self) -> None:
        self._end_s = None

    def is_up(self) -> bool:
        return self._end_s is not None and self._now_s() >= self._end_s - ROUNDING_S

    def _now_s(self) -> float:
        try:
            return float(self._client.get(NOW_S.name))
        except KeyError:
            raise MissionError(
                f"{self._owner.name}: {NOW_S.name} is not on the blackboard; it must be written before every tick"
            ) from None


class Timeout(DecoratorNode):
    """Halts its child and returns FAILURE when it is still running after `msec`. 0 is no limit."""

    INPUT_PORTS = {"msec": PortInformation(int, True, "time limit in milliseconds; 0: none")}
    PORT_LIMITS = {"msec": (0, MOST_MSEC)}

    def __init__(self, name: str, child: Behaviour) -> None:
        super().__init__(name=name, child=child)
        self._clock = Clock(self)

    def reset(self) -> None:
        self._clock.clear()

    def step(self, visited: Visited) -> Status:
        msec = self.input("msec")
        if not self._clock.started:
            self._clock.start(msec)
            self.feedback_message = ""
        elif msec > 0 and self._clock.is_up() and is_active(self.decorated):
            halt(self.decorated)
            self._clock.clear()
            self.feedback_message = f"{self.decorated.name} took longer than {msec / 1000.0:g} s"
            return Status.FAILURE
        status = tick_node(self.decorated, visited)
        if status in (Status.SUCCESS, Status.FAILURE):
            self._clock.clear()
        return status


class Delay(DecoratorNode):
    """Waits `delay_msec`, RUNNING, then ticks its child."""

    INPUT_PORTS = {"delay_msec": PortInformation(int, True, "waiting time in milliseconds")}
    PORT_LIMITS = {"delay_msec": (0, MOST_MSEC)}

    def __init__(self, name: str, child: Behaviour) -> None:
        super().__init__(name=name, child=child)
        self._clock = Clock(self)
        self._waited = False

    def reset(self) -> None:
        self._clock.clear()
        self._waited = False

    def step(self, visited: Visited) -> Status:
        if not self._clock.started:
            self._clock.start(self.input("delay_msec"))
        self._waited = self._waited or self._clock.is_up()
        if not self._waited:
            return Status.RUNNING
        status = tick_node(self.decorated, visited)
        if status in (Status.SUCCESS, Status.FAILURE):
            self.reset()
        return status


class Sleep(LeafNode):
    """Waits `msec`, RUNNING, then SUCCESS."""

    INPUT_PORTS = {"msec": PortInformation(int, True, "waiting time in milliseconds")}
    PORT_LIMITS = {"msec": (0, MOST_MSEC)}

    def __init__(self, name: str) -> None:
        super().__init__(name)
        self._clock = Clock(self)

    def reset(self) -> None:
        self._clock.clear()

    def step(self, visited: Visited) -> Status:
        if not self._clock.started:
            self._clock.start(self.input("msec"))
        if not self._clock.is_up():
            return Status.RUNNING
        self._clock.clear()
        return Status.SUCCESS
