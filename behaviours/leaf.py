"""What every leaf of a mission is made of: ports for the mission's author, keys for the robot's world.

A *port* is an attribute in the mission file (`<TurnSearch time_limit_s="30"/>`), declared in `INPUT_PORTS` and
`OUTPUT_PORTS`. A *key* is an entry of the blackboard's table (`target_nav.state.keys`), declared in `READS` and
`WRITES`. Leaves never publish, never block and never read a clock.
"""

from __future__ import annotations

from typing import Any, ClassVar

import py_trees
from py_trees.common import Access, Status
from py_trees.ports import PortInformation, PortsMixin

from target_nav.config import Config
from target_nav.state import keys
from target_nav.state.keys import Key

Ports = dict[str, PortInformation]


def number(doc: str, default: float | None = None) -> PortInformation:
    """An optional number; without a default the robot's configuration says."""
    return PortInformation(float, required=False, description=doc, default_value=default)


def text(doc: str, default: str | None = None, required: bool = False) -> PortInformation:
    return PortInformation(str, required=required, description=doc, default_value=default)


class MissionLeaf(PortsMixin, py_trees.behaviour.Behaviour):
    """Base of all leaves. `PORT_LIMITS` are inclusive and in the unit that ends the port's name."""

    READS: ClassVar[tuple[Key, ...]] = ()
    WRITES: ClassVar[tuple[Key, ...]] = ()
    PORT_LIMITS: ClassVar[dict[str, tuple[float, float]]] = {}

    def __init__(self, name: str) -> None:
        super().__init__(name=name)
        self._world = self.attach_blackboard_client(name=f"{name} (world)")
        for key in self.WRITES:
            self._world.register_key(key=key.name, access=Access.WRITE)
        for key in self.READS:
            if key not in self.WRITES:
                self._world.register_key(key=key.name, access=Access.READ)

    def read(self, key: Key) -> Any:
        """The key's value; None where the table says that it may be missing.

        Raises:
            KeyError: nobody has written a key that is not optional.
        """
        if key.optional and not self._world.exists(key.name):
            return None
        return self._world.get(key.name)

    def write(self, key: Key, value: object) -> None:
        self._world.set(key.name, value)

    def config(self) -> Config:
        config: Config = self.read(keys.CONFIG)
        return config

    def say(self, message: str, status: Status) -> Status:
        """`status`, with the reason a person sees beside it."""
        self.feedback_message = message
        return status
