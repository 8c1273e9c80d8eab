"""Built-in leaves: AlwaysSuccess, AlwaysFailure, and the base that Sleep shares with them."""

from __future__ import annotations

from py_trees.common import Status

from target_nav.mission.nodes.base import MissionNode
from target_nav.mission.nodes.ticking import Visited


class LeafNode(MissionNode):
    KIND = "leaf"
    CHILDREN = (0, 0)

    def update(self) -> Status:
        """Not used: built-ins are ticked through `step`."""
        return self.status


class AlwaysSuccess(LeafNode):
    """SUCCESS at once."""

    def step(self, visited: Visited) -> Status:
        return Status.SUCCESS


class AlwaysFailure(LeafNode):
    """FAILURE at once."""

    def step(self, visited: Visited) -> Status:
        return Status.FAILURE
