"""The leaves that the tests' missions are written with."""

from __future__ import annotations

from py_trees.ports import PortInformation

from target_nav.mission import NodeRegistry
from target_nav.state.types import Pose2D
from tests.unit.mission.scripted import leaf_class

Drive = leaf_class(
    "Drive",
    inputs={
        "speed_mps": PortInformation(float, True, "how fast"),
        "goal": PortInformation(Pose2D, False, "where to"),
        "label": PortInformation(str, False, "shown to the operator", "drives"),
        "laps": PortInformation(int, False, "how often", 1),
        "careful": PortInformation(bool, False, "slow down near people", False),
    },
    outputs={"reason": PortInformation(str, False, "why it failed")},
    limits={"speed_mps": (0.02, 5.0), "laps": (0, 100)},
)
Measure = leaf_class("Measure", outputs={"distance_m": PortInformation(float, False, "what was measured")})
Look = leaf_class("Look")


def registry() -> NodeRegistry:
    return NodeRegistry((Drive, Measure, Look))
