"""A scenario as it is written: what the blackboard holds from which second on, and what is then expected.

`scenario_file` reads YAML into it; `scenario_run` carries it out. Times are seconds of the scenario: the first tick is
at 0, a change is in force in the first tick at or after its time.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from target_nav.mission.mocks import MockSpec
from target_nav.mission.scenario_match import Matcher
from target_nav.state.types import CommandKind


@dataclass(frozen=True)
class Place:
    """Where something stands in a file."""

    file: str
    line: int

    def __str__(self) -> str:
        return f"{self.file}:{self.line}"


@dataclass(frozen=True)
class Change:
    """One step of the script. `board` is by name, as `ScriptedWorld.set` takes it, with the place of each."""

    at_s: float
    board: Mapping[str, tuple[Any, Place]]
    words: tuple[CommandKind, ...] = ()


@dataclass(frozen=True)
class When:
    """The ticks that are looked at: from `from_s` to `to_s`, both included, or so many ticks from `from_s` on.

    `every` asks for the conditions in each of these ticks, otherwise one will do. `to_s` None is the scenario's end.
    """

    from_s: float
    to_s: float | None
    every: bool
    ticks: int | None = None
    text: str = ""


@dataclass(frozen=True)
class Conditions:
    """What is to hold in a tick; what is None or empty is not asked for.

    `leaf`, and the keys of `status` and `message`, are patterns of behaviours: with a `/` for the path, otherwise for
    name or class. Where a pattern fits several behaviours, one of them will do.
    """

    leaf: str | None = None
    state: str | None = None
    outcome: str | None = None
    reason: str | None = None
    moves: bool | None = None
    status: Mapping[str, str] = field(default_factory=dict)
    message: Mapping[str, str] = field(default_factory=dict)
    board: Mapping[str, Matcher] = field(default_factory=dict)
    none_of: Conditions | None = None
    """What is not to hold."""

    def patterns(self) -> list[str]:
        own = [*([self.leaf] if self.leaf else []), *self.status, *self.message]
        return own + (self.none_of.patterns() if self.none_of else [])

    def keys(self) -> list[str]:
        return [*self.board, *(self.none_of.keys() if self.none_of else [])]


@dataclass(frozen=True)
class Check:
    """One expectation. `states` and `leaves` are traces without repetitions; `...` stands for any part of one."""

    place: Place
    when: When
    conditions: Conditions | None = None
    states: tuple[str, ...] | None = None
    leaves: tuple[str, ...] | None = None


@dataclass(frozen=True)
class Scenario:
    """`drives`: the robot's pose follows the velocity that is asked for; otherwise it is as the script says."""

    name: str
    place: Place
    mission: Path
    drives: bool = True
    config: Mapping[str, object] = field(default_factory=dict)
    mocks: tuple[tuple[MockSpec, Place], ...] = ()
    script: tuple[Change, ...] = ()
    checks: tuple[Check, ...] = ()
    lasts_s: float = 0.0

    @property
    def mission_keys(self) -> tuple[str, ...]:
        """Blackboard entries of the mission's own that the script writes."""
        return tuple(dict.fromkeys(name for change in self.script for name in change.board if name[0] == "/"))
