"""Leaves that write the blackboard by themselves: SetBlackboard, UnsetBlackboard."""

from __future__ import annotations

from py_trees.common import Status
from py_trees.ports import PortInformation

from target_nav.mission.nodes.leaves import LeafNode
from target_nav.mission.nodes.ticking import Visited
from target_nav.mission.values import BadValue


class SetBlackboard(LeafNode):
    """Writes a text, or what another entry holds, to an entry. FAILURE if that other entry has no value."""

    INPUT_PORTS = {
        "value": PortInformation(
            object, True, "a text, in the type of the ports that read it; or an entry to copy"
        ),
        "output_key": PortInformation(str, True, "name of the entry to write, without braces"),
    }
    KEY_PORTS = {"output_key": "writes"}

    def step(self, visited: Visited) -> Status:
        value = self.input_or_none("value")
        if value is None:
            self.feedback_message = "value has no value yet"
            return Status.FAILURE
        try:
            self.entries["output_key"].write(value)
        except BadValue as error:
            raise self.error(
                f"output_key {self.entries['output_key'].path} is given {value!r}; {error}"
            ) from error
        self.feedback_message = ""
        return Status.SUCCESS


class UnsetBlackboard(LeafNode):
    """Removes an entry's value. SUCCESS, also if there is none."""

    INPUT_PORTS = {"key": PortInformation(str, True, "name of the entry, without braces")}
    KEY_PORTS = {"key": "removes"}

    def step(self, visited: Visited) -> Status:
        self.entries["key"].unset()
        return Status.SUCCESS
