"""SubTree: one use of another tree, in the displays a decorator with that tree's root as its child."""

from __future__ import annotations

from py_trees.behaviour import Behaviour
from py_trees.common import Status

from target_nav.mission.nodes.base import DecoratorNode
from target_nav.mission.nodes.ticking import Visited, tick_node


class SubTree(DecoratorNode):
    """Ticks another tree of the mission, with a blackboard of its own. `tree_id` is that tree's ID."""

    def __init__(self, name: str, child: Behaviour, tree_id: str) -> None:
        super().__init__(name=name, child=child)
        self.tree_id = tree_id

    def step(self, visited: Visited) -> Status:
        return tick_node(self.decorated, visited)
