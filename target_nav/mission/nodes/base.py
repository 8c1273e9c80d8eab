"""How a mission's nodes are ticked and halted: BehaviorTree.CPP's rules on py_trees' behaviours.

A node's logic is one plain function, `step`, that ticks children through `tick_node` and returns a status. py_trees'
generator interface is derived from it: `tick` runs the step and then yields what was visited, children first, so
py_trees' visitors, displays and tree managers work on a mission as on any other tree.

py_trees' statuses stand for BehaviorTree.CPP's, with INVALID for both IDLE and SKIPPED: a child that comes back from
its tick INVALID was skipped. A leaf must not do that; only built-ins skip.

Where the two differ in what one sees, not in what is done: a child that finished keeps its status until its parent
begins anew, where BehaviorTree.CPP resets it at once. A halt reaches exactly the nodes that are running.
"""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Iterator, Mapping, Sequence
from typing import Any, ClassVar

from py_trees import composites, decorators
from py_trees.behaviour import Behaviour
from py_trees.common import Status
from py_trees.ports import PortInformation

from target_nav.errors import MissionError
from target_nav.mission.nodes.sources import Source

Visited = list[Behaviour]
"""What a tick passed through, in the order in which it was done with."""

SKIPPED = Status.INVALID
SKIPPED_MESSAGE = "skipped"
_LEAF_RESULTS = (Status.SUCCESS, Status.FAILURE, Status.RUNNING)


def tick_node(node: Behaviour, visited: Visited) -> Status:
    """Ticks a node once; INVALID means that it was skipped.

    Raises:
        MissionError: a leaf returned something that is no result.
    """
    if isinstance(node, MissionNode):
        return node.execute(visited)
    if type(node).tick is not Behaviour.tick:
        visited.extend(node.tick())
        return _result(node, node.status)
    if node.status is not Status.RUNNING:
        node.initialise()
    status = _result(node, node.update())
    if status is not Status.RUNNING:
        _end(node, status)
    node.status = status
    visited.append(node)
    return status


def _end(leaf: Behaviour, status: Status) -> None:
    if type(leaf).stop is Behaviour.stop:
        # what it does but for writing a debug message, which costs more than all the rest of a leaf's tick
        leaf.terminate(status)
    else:
        leaf.stop(status)


def _result(leaf: Behaviour, status: object) -> Status:
    # A forgotten `return` must not pass for "skipped", which lets a sequence go on.
    if isinstance(status, Status) and status in _LEAF_RESULTS:
        return status
    raise MissionError(
        f"leaf {leaf.name!r} ({type(leaf).__name__}) returned {status!r}; it must return SUCCESS, FAILURE or RUNNING"
    )


def is_active(node: Behaviour) -> bool:
    """Whether the node has begun and has not finished; only such a node is halted."""
    return node.active if isinstance(node, MissionNode) else node.status is Status.RUNNING


def halt(node: Behaviour) -> None:
    """Stops the node if it is active; one that has finished only loses its status."""
    if is_active(node):
        node.stop(Status.INVALID)
    else:
        forget(node)


def forget(node: Behaviour) -> None:
    """Clears what is left to be seen of a finished node and its descendants."""
    if node.status is not Status.INVALID:
        node.status = Status.INVALID
        for child in node.children:
            forget(child)


class MissionNode(Behaviour):
    """What control nodes and decorators have in common; combined with one of py_trees' classes."""

    KIND: ClassVar[str]
    CHILDREN: ClassVar[tuple[int, int | None]]
    INPUT_PORTS: ClassVar[dict[str, PortInformation]] = {}
    PORT_LIMITS: ClassVar[dict[str, tuple[float, float]]] = {}

    active: bool = False
    """BehaviorTree.CPP's RUNNING: from the first tick to a result or a halt, skipped ticks included."""
    origin: str = ""
    """Where the mission defines the node: file:line:column."""
    sources: Mapping[str, Source] = {}
    last_visited: Sequence[Behaviour] = ()
    """Of a node that was ticked as the root of a tree: what the last tick passed through."""

    @abstractmethod
    def step(self, visited: Visited) -> Status:
        """One tick: SUCCESS, FAILURE, RUNNING, or INVALID for skipped."""

    def reset(self) -> None:
        """Forgets what the node remembers from tick to tick; called when it is halted."""

    def input(self, port: str) -> Any:
        """The port's value: what the mission says, or the port's default."""
        source = self.sources.get(port)
        if source is None:
            return self.INPUT_PORTS[port].default_value
        try:
            return source.read()
        except ValueError as error:
            raise MissionError(f"{self.origin}: error: {self.name}: {port} {error}") from error

    def execute(self, visited: Visited) -> Status:
        """Ticks the node and, through it, its children."""
        if not self.active:
            for child in self.children:
                forget(child)
        self.active = True
        status = self.step(visited)
        if status is SKIPPED:
            self.feedback_message = SKIPPED_MESSAGE
        else:
            self.active = status is Status.RUNNING
            if self.feedback_message == SKIPPED_MESSAGE:
                self.feedback_message = ""
        self.status = status
        visited.append(self)
        return status

    def settle(self) -> None:
        """Halts the children that are still active, because the node is done."""
        for child in self.children:
            if is_active(child):
                child.stop(Status.INVALID)

    # -- py_trees' interface -----------------------------------------------------------------------------------------

    def tick(self) -> Iterator[Behaviour]:
        self.tick_once()
        yield from self.last_visited

    def tick_once(self) -> None:
        visited: Visited = []
        self.last_visited = visited
        self.execute(visited)

    def stop(self, new_status: Status = Status.INVALID) -> None:
        """With INVALID, py_trees' word for it, BehaviorTree.CPP's halt: children first, in order, then the node."""
        if new_status is Status.INVALID:
            for child in self.children:
                halt(child)
            self.reset()
            self.feedback_message = ""
            self.last_visited = ()
        self.terminate(new_status)
        self.active = False
        self.status = new_status


class ControlNode(MissionNode, composites.Composite):
    """Many children. Goes before one of py_trees' composites in the bases."""

    KIND = "Control"
    CHILDREN: ClassVar[tuple[int, int | None]] = (1, None)

    def stop(self, new_status: Status = Status.INVALID) -> None:
        if new_status is Status.INVALID:
            self.current_child = None
        super().stop(new_status)

    def tip(self) -> Behaviour | None:
        """The deepest node that decided; the node itself where its child was skipped or halted."""
        tip = self.current_child.tip() if self.current_child is not None else None
        if tip is None and self.status is not Status.INVALID:
            return self
        return tip


class DecoratorNode(MissionNode, decorators.Decorator):
    """One child, `self.decorated`."""

    KIND = "Decorator"
    CHILDREN = (1, 1)

    def update(self) -> Status:
        """Not used: py_trees' own decorators are ticked through it, these through `step`."""
        return self.status
