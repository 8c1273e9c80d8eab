"""Everything that stands in shared memory, read in one go, whatever state it is in.

A channel that is missing, stale, torn or of another version is a `Link` that says so. Nothing here raises.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any, Generic, TypeVar

from target_nav.config import Config
from target_nav.errors import DeviceError
from target_nav.ipc import channels
from target_nav.ipc.channels import Channel
from target_nav.state.snapshots import (
    AvoidSnapshot,
    CameraFrame,
    LaserSnapshot,
    NavSnapshot,
    ProcessTable,
    TreeState,
)
from target_nav.state.types import DetectionFrame

T = TypeVar("T")

DESCRIBE_PERIOD_S = 1.0
"""How often is asked who lives; opening nine files for that is not for every poll."""

NAV_MAX_AGE_S, TREE_MAX_AGE_S, PICTURE_MAX_AGE_S, PROCESSES_MAX_AGE_S = 0.5, 1.0, 1.0, 4.0

WRITER = {
    "nav": "nav", "laser": "nav", "avoid": "nav", "tree": "nav", "det": "camera", "camera": "detector",
    "processes": "supervisor", "cmd_ack": "nav", "calibration": "camera", "detections": "detector",
}  # fmt: skip
"""Channel to the process that writes it, in the process table's names."""


@dataclass(frozen=True, eq=False)
class Link(Generic[T]):
    """One channel: its newest value ever, how old that is, and what is wrong. `alive`: a process writes it now."""

    name: str
    value: T | None
    age_s: float
    limit_s: float
    alive: bool
    problem: str = ""

    @property
    def fresh(self) -> bool:
        """There is a value, and it is not too old to be believed."""
        return self.value is not None and self.age_s <= self.limit_s

    @property
    def process(self) -> str:
        """The process that writes it."""
        return WRITER.get(self.name, self.name)

    @property
    def excuse(self) -> str:
        """Why there is nothing to believe, in words for a screen; empty when there is."""
        if self.fresh:
            return ""
        if self.problem:
            return f"{self.name}: {self.problem}"
        if self.value is None:
            return f"no {self.name} yet; is process {self.process} running?"
        return f"{self.name} {age_text(self.age_s)} old (limit {self.limit_s:g} s)"


@dataclass(frozen=True, eq=False)
class World:
    """One look at shared memory, at the monotonic time `now_s`."""

    now_s: float
    nav: Link[NavSnapshot]
    laser: Link[LaserSnapshot]
    avoid: Link[AvoidSnapshot]
    tree: Link[TreeState]
    det: Link[DetectionFrame]
    camera: Link[CameraFrame]
    processes: Link[ProcessTable]
    gone: tuple[str, ...] = ()
    """Processes that wrote a channel, and do not live any more."""

    @property
    def links(self) -> tuple[Link[Any], ...]:
        return (self.nav, self.laser, self.avoid, self.tree, self.det, self.camera, self.processes)


class StackReader:
    """Reads all channels of a prefix. For one thread; any number of readers may look, no writer notices.

    Args:
        pictures: whether to read camera pictures too, which is most of the cost
    """

    def __init__(self, prefix: str, config: Config, pictures: bool = True) -> None:
        limits: dict[Channel[Any], float] = {
            channels.NAV: NAV_MAX_AGE_S,
            channels.LASER: config.loop.scan_max_age_s,
            channels.AVOID: config.loop.scan_max_age_s,
            channels.TREE: TREE_MAX_AGE_S,
            channels.DET: config.loop.camera_max_age_s,
            channels.CAMERA: PICTURE_MAX_AGE_S,
            channels.PROCESSES: PROCESSES_MAX_AGE_S,
        }
        self._prefix = prefix
        self._limit_s = {channel.name: limit for channel, limit in limits.items()}
        self._readers: dict[str, Any] = {
            channel.name: channels.open_reader(channel, prefix)
            for channel in limits
            if pictures or channel is not channels.CAMERA
        }
        self._described_s = -math.inf
        self._alive: dict[str, bool] = {}
        self._problem: dict[str, str] = {}
        self._gone: tuple[str, ...] = ()

    def poll(self, now_s: float) -> World:
        if now_s - self._described_s >= DESCRIBE_PERIOD_S:
            self._described_s = now_s
            self._describe(now_s)
        return World(now_s, **{name: self._link(name, now_s) for name in self._limit_s}, gone=self._gone)

    def close(self) -> None:
        for reader in self._readers.values():
            reader.close()

    def _link(self, name: str, now_s: float) -> Link[Any]:
        reader = self._readers.get(name)
        limit_s, alive = self._limit_s[name], self._alive.get(name, False)
        if reader is None:
            return Link(name, None, math.inf, limit_s, alive, "not read here")
        try:
            value, age_s = reader.latest(), reader.age_s(now_s)
        except DeviceError as error:
            return Link(name, None, math.inf, limit_s, alive, str(error))
        problem = "" if value is not None and age_s <= limit_s else self._problem.get(name, "")
        return Link(name, value, age_s, limit_s, alive, problem)

    def _describe(self, now_s: float) -> None:
        gone: list[str] = []
        try:
            listed = channels.describe(self._prefix, now_s)
        except DeviceError:
            return
        for channel in listed:
            self._alive[channel.name] = channel.alive
            # what is not there yet is told in words of its own: which process makes it
            self._problem[channel.name] = channel.problem if channel.exists else ""
            process = WRITER.get(channel.name)
            if channel.exists and not channel.alive and process is not None and process not in gone:
                gone.append(process)
        self._gone = tuple(gone)


def age_text(age_s: float) -> str:
    """An age for people: `0.12 s`, `14 s`, `3 min`, `-` when there is none."""
    if not math.isfinite(age_s):
        return "-"
    if age_s < 10.0:
        return f"{age_s:.2f} s" if age_s < 1.0 else f"{age_s:.1f} s"
    return f"{age_s:.0f} s" if age_s < 120.0 else f"{age_s / 60.0:.0f} min"
