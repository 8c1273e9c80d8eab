"""Two leaves that move the robot must not run at once: the wheels have one owner."""

from __future__ import annotations

from py_trees import composites

from target_nav.mission.expand import Instance
from target_nav.mission.problems import Report
from target_nav.state import keys


def moves_the_robot(instance: Instance) -> bool:
    """Whether a node is a leaf that asks for a velocity."""
    return instance.spec is not None and keys.REQUEST in getattr(instance.spec.cls, "WRITES", ())


def check_motion(root: Instance, report: Report) -> None:
    """An error for every parallel node of which two branches hold a leaf that moves the robot."""
    for instance in root.walk():
        if instance.spec is None or not issubclass(instance.spec.cls, composites.Parallel):
            continue
        movers = [next(filter(moves_the_robot, branch.walk()), None) for branch in instance.children]
        found = [each for each in movers if each is not None]
        if len(found) >= 2:
            names = [f"{each.definition.id} ({each.definition.position})" for each in found]
            report.error(
                instance.definition.position,
                f"{instance.definition.id} can run {', '.join(names[:-1])} and {names[-1]} at once, and each of them "
                "moves the robot; let them take turns, in a Sequence or a Fallback",
            )
