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
from collections.abc import Callable, Iterator, Mapping, Sequence
from typing import Any, ClassVar, Literal, Protocol

from py_trees import composites, decorators
from py_trees.behaviour import Behaviour
from py_trees.common import Status
from py_trees.ports import PortInformation

from target_nav.errors import MissionError
from target_nav.mission.nodes.entries import BoardEntry, Constant
from target_nav.mission.nodes.halting import StaysActive, forget_all, halt, halt_below, is_active
from target_nav.mission.nodes.ticking import SKIPPED_MESSAGE, Visited
from target_nav.mission.script import Run

_INVALID = Status.INVALID
"""An enum's members are looked up in a class each time; a tick asks for this one of every node."""

ScriptUse = Literal["runs", "decides"]
"""Whether a script is run for what it does, or for whether its value is true."""
KeyUse = Literal["watches", "writes", "removes"]


class Source(Protocol):
    """Where a built-in node's port gets its value: the mission's text, or the blackboard at the moment of reading."""

    def read(self) -> Any:
        """The value.

        Raises:
            KeyError: there is none.
            ValueError: it does not fit; the text continues a sentence that begins with the port.
        """


class MissionNode(StaysActive, Behaviour):
    """What control nodes and decorators have in common; combined with one of py_trees' classes."""

    KIND: ClassVar[str]
    CHILDREN: ClassVar[tuple[int, int | None]]
    INPUT_PORTS: ClassVar[dict[str, PortInformation]] = {}
    OUTPUT_PORTS: ClassVar[dict[str, PortInformation]] = {}
    PORT_LIMITS: ClassVar[dict[str, tuple[float, float]]] = {}
    SCRIPT_PORTS: ClassVar[Mapping[str, ScriptUse]] = {}
    """Inputs that hold a script, and what for."""
    KEY_PORTS: ClassVar[Mapping[str, KeyUse]] = {}
    """Inputs that name an entry, and what is done with it."""
    BEGINS: ClassVar[bool] = True
    """Whether it is active from the begin of its first tick on. Otherwise only once it is RUNNING."""

    origin: str = ""
    """Where the mission defines the node: file:line:column."""
    sources: Mapping[str, Source] = {}
    """Of the ports that the mission gives."""
    sinks: Mapping[str, BoardEntry] = {}
    """Of the outputs that the mission connects."""
    entries: Mapping[str, BoardEntry] = {}
    """Of `KEY_PORTS`."""
    scripts: Mapping[str, Run] = {}
    """Of `SCRIPT_PORTS`. They raise MissionError."""
    enums: Mapping[str, int] = {}
    """Names of constants that texts may stand for."""
    on_halted: Callable[[], object] | None = None
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
        default = self.INPUT_PORTS[port].default_value
        if source is None:
            return default
        try:
            return source.read()
        except KeyError as error:
            if default is None:
                raise self.error(f"{port} reads {error.args[0]}, which nobody has written yet") from error
            return default
        except ValueError as error:
            raise self.error(f"{port} {error}") from error

    def input_or_none(self, port: str) -> Any:
        """The same; None where it has no value."""
        source = self.sources.get(port)
        if source is None:
            return self.INPUT_PORTS[port].default_value
        try:
            return source.read()
        except KeyError:
            return None
        except ValueError as error:
            raise self.error(f"{port} {error}") from error

    def is_literal(self, port: str) -> bool:
        return isinstance(self.sources.get(port), Constant)

    def run(self, port: str) -> Any:
        """Runs the script of a port and returns its value."""
        return self.scripts[port]()

    def error(self, message: str) -> MissionError:
        return MissionError(f"{self.origin}: error: {self.name}: {message}")

    def mission_tick(self, visited: Visited) -> Status:
        """Ticks the node and, through it, its children."""
        if not self.active:
            for child in self.children:
                # `forget`, written out: most children have nothing to lose
                if child.status is not _INVALID:
                    child.status = _INVALID
                    if child.children:
                        forget_all(child.children)
            self.active = self.BEGINS
        status = self.step(visited)
        if status is _INVALID:
            self.feedback_message = SKIPPED_MESSAGE
        else:
            self.active = status is Status.RUNNING
            if self.feedback_message is SKIPPED_MESSAGE:
                self.feedback_message = ""
        self.status = status
        visited.append(self)
        return status

    def settle(self) -> None:
        """Halts the children that are still active, because the node is done."""
        for child in self.children:
            if is_active(child):
                halt(child)

    # -- py_trees' interface -----------------------------------------------------------------------------------------

    def tick(self) -> Iterator[Behaviour]:
        self.tick_once()
        yield from self.last_visited

    def tick_once(self) -> None:
        visited: Visited = []
        self.last_visited = visited
        self.mission_tick(visited)

    def stop(self, new_status: Status = Status.INVALID) -> None:
        """With INVALID, py_trees' word for it, BehaviorTree.CPP's halt: children first, in order, then the node."""
        was_active = self.active
        if new_status is Status.INVALID:
            for child in self.children:
                halt(child)
            self.reset()
            self.feedback_message = ""
            self.last_visited = ()
        self.terminate(new_status)
        self.active = False
        self.status = new_status
        if was_active and new_status is Status.INVALID and self.on_halted is not None:
            self.on_halted()
        if new_status is Status.INVALID and self.parent is None:
            # py_trees' way of halting a whole tree
            halt_below(self)


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
