"""Missions: BehaviorTree.CPP v4 files loaded into py_trees trees, checked, drawn and described for watchers.

The way of a file: `parse` (XML, positions) > `document` (model) > `includes` > `definitions` (check as written) >
`expand` (subtrees) with `bind` (keys and scripts) > `wiring` (check as it will run) > `build` (behaviours).
"""

from __future__ import annotations

from target_nav.errors import MissionError
from target_nav.mission.load import LoadedMission, load_mission
from target_nav.mission.registry import NodeRegistry, default_registry

__all__ = ["LoadedMission", "MissionError", "NodeRegistry", "default_registry", "load_mission"]
