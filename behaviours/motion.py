"""Leaves that move the robot: each runs one skill and writes one motion request that names its owner."""

from __future__ import annotations

from abc import abstractmethod
from typing import ClassVar

from py_trees.common import Status

from behaviours.leaf import MissionLeaf, Ports, number, text
from target_nav.nav.skill import Skill, SkillStatus, View
from target_nav.state import keys
from target_nav.state.keys import Key
from target_nav.state.types import Avoidance, MotionRequest, NavState, TargetSpec

STATUS_OF = {
    SkillStatus.RUNNING: Status.RUNNING,
    SkillStatus.SUCCESS: Status.SUCCESS,
    SkillStatus.FAILURE: Status.FAILURE,
}

REASON_PORT: Ports = {"reason": text("why the leaf failed, in words")}


class MotionLeaf(MissionLeaf):
    """Runs a skill. While it is the running leaf, `STATE` is what the robot's state is said to be."""

    STATE: ClassVar[NavState]
    NEAR_TARGET: ClassVar[bool] = False
    READS: ClassVar[tuple[Key, ...]] = (
        keys.NOW_S, keys.DT_S, keys.POSE, keys.TWIST, keys.TRACK, keys.OBSTACLES, keys.SCAN_TAKEN,
        keys.DETECTIONS, keys.SPEC, keys.CONFIG,
    )  # fmt: skip
    WRITES: ClassVar[tuple[Key, ...]] = (keys.REQUEST,)

    def __init__(self, name: str) -> None:
        super().__init__(name)
        self._skill: Skill | None = None
        self._owner = self.id.hex
        self._avoidance: Avoidance | None = None

    @abstractmethod
    def make_skill(self) -> Skill:
        """A new skill with what the mission's ports and the configuration say."""

    def view(self) -> View:
        return View(
            now_s=self.read(keys.NOW_S),
            dt_s=self.read(keys.DT_S),
            pose_in_odom=self.read(keys.POSE),
            twist_in_base=self.read(keys.TWIST),
            track=self.read(keys.TRACK),
            obstacles_in_base_m=self.read(keys.OBSTACLES),
            detections=self.read(keys.DETECTIONS),
            is_busy=self.read(keys.SCAN_TAKEN),
        )

    def spec(self) -> TargetSpec:
        spec: TargetSpec = self.read(keys.SPEC)
        return spec

    def initialise(self) -> None:
        self._skill = self.make_skill()
        self._skill.start(self.view())

    def update(self) -> Status:
        assert self._skill is not None, "py_trees calls initialise before update"
        step = self._skill.step(self.view())
        self.write(
            keys.REQUEST,
            MotionRequest(
                self._owner,
                self.STATE,
                step.twist,
                step.reason,
                near_target=self.NEAR_TARGET,
                avoidance=self._new_avoidance(),
            ),
        )
        if step.status is SkillStatus.FAILURE and "reason" in self.output_ports():
            self._set_output("reason", step.reason)
        return self.say(step.reason, STATUS_OF[step.status])

    def _new_avoidance(self) -> Avoidance | None:
        """What VFH chose in this very tick, if the skill has one and asked it."""
        latest: Avoidance | None = getattr(self._skill, "avoidance", None)
        if latest is self._avoidance:
            return None
        self._avoidance = latest
        return latest

    def terminate(self, new_status: Status) -> None:
        # py_trees starts a new child before it stops the old one: the request may be somebody else's by now.
        request = self.read(keys.REQUEST)
        if request is not None and request.owner == self._owner:
            self.write(keys.REQUEST, None)


def limits(**bounds: tuple[float, float]) -> dict[str, tuple[float, float]]:
    return bounds


SPEED_MPS = (0.02, 5.0)
DISTANCE_M = (0.0, 50.0)
TIME_S = (0.1, 3600.0)

__all__ = [
    "DISTANCE_M",
    "REASON_PORT",
    "SPEED_MPS",
    "STATUS_OF",
    "TIME_S",
    "MotionLeaf",
    "Ports",
    "limits",
    "number",
]
