"""A mission ticked in virtual time against a scripted blackboard: real leaves, real skills, no robot and no simulator.

The same for scenario files and for tests written in Python:

    with ScriptedMission("trees/bowling_pin.xml") as mission:
        mission.say("GO")
        mission.set(track={"range_m": 2.0})
        mission.run_for(1.0)
        assert mission.leaf == "NavigateToTarget"

py_trees keeps one blackboard in a process, so there is one scripted mission at a time.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from pathlib import Path
from types import TracebackType
from typing import Any

from py_trees.blackboard import Blackboard
from py_trees.common import Status

from target_nav.config import Config
from target_nav.errors import MissionError
from target_nav.mission.load import load_mission
from target_nav.mission.mocks import Mock, MockSpec, unknown_outputs
from target_nav.mission.observation import Observation
from target_nav.mission.registry import NodeRegistry
from target_nav.mission.scenario_values import BadScript
from target_nav.mission.scenario_world import ScriptedWorld, full_name
from target_nav.mission.tree_index import TreeIndex
from target_nav.state import keys
from target_nav.state.types import CommandKind, MotionRequest, NavState, Outcome, OutcomeKind

ROUNDING_S = 1e-6
WORDS = ("GO", "STOP", "PAUSE", "RESUME", "STEP")


class ScriptedMission:
    """See the module. The first tick is at 0 s.

    Args:
        path: the mission's file
        config: the robot's configuration
        drives: the pose follows the velocity that is asked for; False: it is as `set` says
        mocks: leaves to be replaced; the first pattern that fits counts
        registry: the words of the mission; None: the built-ins and the package `behaviours`
        provided_keys: entries of the mission's own (`/goal`) that the test writes

    Raises:
        MissionError: the mission cannot be loaded, or a mock fits nothing in it.
    """

    def __init__(
        self,
        path: str | Path,
        *,
        config: Config | None = None,
        drives: bool = True,
        mocks: Iterable[MockSpec] = (),
        registry: NodeRegistry | None = None,
        provided_keys: Iterable[str] = (),
    ) -> None:
        Blackboard.clear()
        self.config = config if config is not None else Config()
        self.mission = load_mission(path, registry, provided_keys)
        self.root = self.mission.root
        self.index = TreeIndex(self.root)
        self.world = ScriptedWorld(self.config, drives)
        self.mocks: dict[str, list[Mock]] = {}
        self._mocked: set[int] = set()
        self.observations: list[Observation] = []
        self.dt_s = 1.0 / self.config.loop.rate_hz
        self._paused = self._single_step = False
        self._finished: Outcome | None = None
        self.mock(mocks)

    # -- what happens --------------------------------------------------------------------------------------------------

    def set(self, values: Mapping[str, Any] | None = None, **by_name: Any) -> None:
        """What the blackboard holds from the next tick on, as a scenario's file would say it.

        Raises:
            BadScript: no such key, one that a script does not write, or a value that it cannot hold.
        """
        for name, data in {**(values or {}), **by_name}.items():
            self.world.set(name, data)

    def say(self, word: str | CommandKind) -> None:
        """An operator's word, in force in the next tick: GO, STOP, PAUSE, RESUME or STEP."""
        name = word.name if isinstance(word, CommandKind) else word
        if name not in WORDS:
            raise BadScript(f"{name!r} cannot be said here; the words are {', '.join(WORDS)}")
        if name == "GO":
            if self._finished is not None or Blackboard.storage.get(keys.OUTCOME.name) is not None:
                # as in the nav core: GO after an end begins anew
                self.root.stop(Status.INVALID)
                self.world.say_go(False)
            self._finished, self._paused = None, False
            self.world.say_go(True)
        elif name == "STOP":
            self._finished, self._paused = None, False
            self.world.say_go(False)
        else:
            self._paused = name != "RESUME"
            self._single_step = name == "STEP"

    def mock(self, specs: Iterable[MockSpec]) -> None:
        """Replace leaves, before the first tick; a leaf that was replaced already stays as it is.

        Raises:
            MissionError: a pattern fits nothing, or an output port is not there.
        """
        problems: list[str] = []
        for spec in specs:
            found = self.index.find(spec.pattern)
            if not found:
                problems.append(self.index.explain_unknown(spec.pattern))
            for i in found:
                for name in unknown_outputs(self.index.nodes[i], spec):
                    problems.append(f"mock of {spec.pattern!r}: {self.index.paths[i]} has no output {name!r}")
                if i not in self._mocked:
                    self._mocked.add(i)
                    self.mocks.setdefault(spec.pattern, []).append(Mock(self.index.nodes[i], spec))
        if problems:
            raise MissionError("\n".join(problems))

    def tick(self) -> Observation:
        self.world.begin_tick(self.now_s, self.dt_s)
        if (self._paused and not self._single_step) or self._finished is not None:
            self.world.hold()
        else:
            self._single_step = False
            self.root.tick_once()
            self._note_end()
        seen = self._observe()
        self.observations.append(seen)
        self.world.end_tick(self.dt_s)
        return seen

    def run_for(self, seconds: float) -> Observation:
        """Tick until so much time has passed; the last of what was seen."""
        return self.run_until(lambda seen: False, seconds, must_happen=False)

    def run_until(
        self, condition: Callable[[Observation], object], within_s: float, *, must_happen: bool = True
    ) -> Observation:
        """Tick until the condition holds.

        Raises:
            AssertionError: it does not within `within_s`; with what the mission did instead.
        """
        end_s = self.now_s + within_s
        while True:
            seen = self.tick()
            if condition(seen):
                return seen
            if self.now_s >= end_s - ROUNDING_S:
                break
        if must_happen:
            raise AssertionError(
                f"did not happen within {within_s:g} s; at {seen.now_s:.2f} s the robot is {seen.state.name}, "
                f"{seen.leaf_name or 'nothing'} runs: {seen.reason}"
            )
        return seen

    def close(self) -> None:
        """Halt the mission and leave an empty blackboard."""
        self.root.stop(Status.INVALID)
        Blackboard.clear()

    def __enter__(self) -> ScriptedMission:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.close()

    # -- what is to be seen --------------------------------------------------------------------------------------------

    @property
    def now_s(self) -> float:
        """The time of the next tick."""
        return len(self.observations) * self.dt_s

    @property
    def last(self) -> Observation:
        if not self.observations:
            raise BadScript("nothing was ticked yet; call tick() or run_for() first")
        return self.observations[-1]

    @property
    def leaf(self) -> str:
        """The leaf that decided the last tick."""
        return self.last.leaf_name

    @property
    def state(self) -> NavState:
        return self.last.state

    @property
    def outcome(self) -> Outcome | None:
        return self.last.outcome

    @property
    def request(self) -> MotionRequest | None:
        return self.last.request

    def status(self, pattern: str) -> Status:
        """Of the one behaviour that fits the pattern."""
        return self.last.statuses[self._one(pattern)]

    def message(self, pattern: str) -> str:
        return self.last.messages[self._one(pattern)]

    def read(self, name: str) -> Any:
        """What the blackboard holds: by the last part of a key's name, or by the whole."""
        return self.last.board.get(full_name(name))

    def entries(self) -> frozenset[str]:
        """All keys that the mission and the nav loop use."""
        return frozenset((*Blackboard.metadata, *(key.name for key in keys.ALL)))

    # ------------------------------------------------------------------------------------------------------------------

    def _one(self, pattern: str) -> int:
        found = self.index.find(pattern)
        if len(found) != 1:
            raise BadScript(
                self.index.explain_unknown(pattern)
                if not found
                else f"{pattern!r} fits {len(found)} behaviours: {', '.join(self.index.paths[i] for i in found)}"
            )
        return found[0]

    def _note_end(self) -> None:
        if self.root.status in (Status.SUCCESS, Status.FAILURE):
            succeeded = self.root.status is Status.SUCCESS
            tip = self.root.tip()
            self._finished = Outcome(
                OutcomeKind.SUCCEEDED if succeeded else OutcomeKind.FAILED,
                (tip.feedback_message or tip.name) if tip is not None else "",
            )

    def _observe(self) -> Observation:
        board = dict(Blackboard.storage)
        request: MotionRequest | None = board.get(keys.REQUEST.name)
        leaf = self.root.tip()
        return Observation(
            now_s=self.now_s,
            state=request.state if request is not None else NavState.IDLE,
            leaf=leaf,
            leaf_message=leaf.feedback_message if leaf is not None else "",
            statuses=tuple(node.status for node in self.index.nodes),
            messages=tuple(node.feedback_message for node in self.index.nodes),
            outcome=board.get(keys.OUTCOME.name) or self._finished,
            request=request,
            board=board,
        )
