"""Ticks the tree again on what a run recorded, and compares every decision with the one that was made then."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import nullcontext
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from target_nav.app.nav_core import NavCore
from target_nav.app.recording import decision_of, read_run
from target_nav.app.run_statuses import mission_of
from target_nav.config import Config
from target_nav.mission import load_mission
from target_nav.state.snapshots import NavSnapshot
from target_nav.state.types import Inputs


@dataclass(frozen=True)
class Difference:
    tick: int
    now_s: float
    what: str
    then: Any
    now: Any


@dataclass(frozen=True)
class ReplayReport:
    ticks: int
    differences: tuple[Difference, ...]


class _Recorded:
    """Gives the nav core the recorded inputs and swallows what it publishes."""

    def __init__(self) -> None:
        self.inputs: Inputs | None = None

    def read(self, now_s: float) -> Inputs:
        assert self.inputs is not None, "set before each tick"
        return self.inputs

    def publish(self, snapshot: NavSnapshot, inputs: Inputs) -> None:
        """A replay moves nothing."""

    def reset_odometry(self) -> None:
        """The recorded odometry was reset already."""


def replay(path: Path, mission: Path | None = None, most: int = 20) -> ReplayReport:
    """Replays a recording against its own mission, or another one; keeps the first `most` differences.

    Raises:
        RecordingError, MissionError, ConfigError: the recording, its mission or its configuration cannot be used.
    """
    header, ticks = read_run(path)
    config = Config().override(header.config, source=f"{path}: configuration")
    with nullcontext(mission) if mission is not None else mission_of(header) as mission_path:
        recorded = _Recorded()
        core = NavCore(config, load_mission(mission_path).root, recorded, recorded)
        try:
            return _compare(core, recorded, ticks, most)
        finally:
            core.close()


def _compare(
    core: NavCore, recorded: _Recorded, ticks: Iterator[tuple[Inputs, dict[str, Any]]], most: int
) -> ReplayReport:
    differences: list[Difference] = []
    count = 0
    for count, (inputs, then) in enumerate(ticks, start=1):
        recorded.inputs = inputs
        now = decision_of(core.tick(inputs.now_s))
        for what in now:
            if now[what] != then.get(what) and len(differences) < most:
                differences.append(Difference(count, inputs.now_s, what, then.get(what), now[what]))
    return ReplayReport(count, tuple(differences))
