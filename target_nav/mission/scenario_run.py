"""Carries out a scenario: script in, ticks, expectations compared, and a report that says where they part."""

from __future__ import annotations

from dataclasses import dataclass

from py_trees.blackboard import Blackboard

from target_nav.config import Config
from target_nav.errors import ConfigError, MissionError
from target_nav.mission.problems import did_you_mean
from target_nav.mission.registry import NodeRegistry
from target_nav.mission.scenario_checks import ANY, Failure, failure_of
from target_nav.mission.scenario_model import Change, Place, Scenario
from target_nav.mission.scenario_report import timeline, without_repetitions
from target_nav.mission.scenario_values import BadScript
from target_nav.mission.scenario_world import ScriptedWorld, full_name
from target_nav.mission.scripted_mission import ROUNDING_S, ScriptedMission


class ScenarioError(MissionError):
    """A scenario that cannot be carried out. The text has one `file:line: error: ...` line per problem."""


@dataclass(frozen=True)
class ScenarioResult:
    """`timeline` is what the mission did, a line for each change of state or leaf; `leaves` decided, in turn."""

    scenario: Scenario
    failures: tuple[Failure, ...]
    ticks: int
    timeline: tuple[str, ...]
    leaves: tuple[str, ...]

    @property
    def passed(self) -> bool:
        return not self.failures

    def explain(self) -> str:
        """For a person: each failed expectation, and below what happened."""
        lines: list[str] = []
        for failure in self.failures:
            lines += [
                f"{failure.place}: expected {failure.expected}",
                *(f"    {line}" for line in failure.got),
            ]
        return "\n".join([*lines, "  what happened:", *(f"    {line}" for line in self.timeline)])


def run_scenario(scenario: Scenario, registry: NodeRegistry | None = None) -> ScenarioResult:
    """
    Raises:
        ScenarioError: the scenario does not fit its mission, or the mission cannot be loaded. All that is wrong.
    """
    with _prepared(scenario, registry) as mission:
        waiting = _in_order(scenario)
        while mission.now_s <= scenario.lasts_s + ROUNDING_S:
            while waiting and waiting[0].at_s <= mission.now_s + ROUNDING_S:
                change = waiting.pop(0)
                mission.set({name: data for name, (data, _) in change.board.items()})
                for word in change.words:
                    mission.say(word)
            mission.tick()
        failures = [failure_of(check, mission.observations, mission.index) for check in scenario.checks]
        return ScenarioResult(
            scenario,
            tuple(failure for failure in failures if failure is not None),
            len(mission.observations),
            tuple(timeline(mission.observations)),
            tuple(without_repetitions(seen.leaf_name for seen in mission.observations)),
        )


def unknown_names(scenario: Scenario) -> list[str]:
    """Mocks, patterns and keys that its mission does not have, one line each; nothing if that cannot be loaded."""
    problems = _Problems(scenario)
    try:
        mission = ScriptedMission(scenario.mission, provided_keys=scenario.mission_keys)
    except MissionError:
        return []
    with mission:
        _mock(scenario, mission, problems)
        _check_names(scenario, mission, problems)
    return problems.lines()


def _in_order(scenario: Scenario) -> list[Change]:
    return sorted(scenario.script, key=lambda change: change.at_s)


def _prepared(scenario: Scenario, registry: NodeRegistry | None) -> ScriptedMission:
    problems = _Problems(scenario)
    config = Config()
    try:
        config = config.override(scenario.config, source="config")
    except ConfigError as error:
        problems.add(scenario.place, str(error))
    _try_script(scenario, config, problems)
    try:
        mission = ScriptedMission(
            scenario.mission,
            config=config,
            drives=scenario.drives,
            registry=registry,
            provided_keys=scenario.mission_keys,
        )
    except MissionError as error:
        # its lines have places of their own, in the mission's files
        raise ScenarioError("\n".join([*problems.lines(), str(error)])) from None
    _mock(scenario, mission, problems)
    _check_names(scenario, mission, problems)
    if problems:
        mission.close()
        raise ScenarioError("\n".join(problems.lines()))
    return mission


class _Problems:
    def __init__(self, scenario: Scenario) -> None:
        self._name = scenario.name
        self._found: list[tuple[int, str]] = []

    def add(self, place: Place, message: str) -> None:
        for line in message.splitlines():
            self._found.append((place.line, f"{place}: error: {self._name}: {line}"))

    def __bool__(self) -> bool:
        return bool(self._found)

    def lines(self) -> list[str]:
        ordered = sorted(self._found, key=lambda problem: problem[0])
        return list(dict.fromkeys(text for _, text in ordered))


def _try_script(scenario: Scenario, config: Config, problems: _Problems) -> None:
    """The whole script in a world without a mission."""
    Blackboard.clear()
    world = ScriptedWorld(config, scenario.drives)
    for change in _in_order(scenario):
        world.begin_tick(change.at_s, 0.0)
        for name, (data, place) in change.board.items():
            try:
                world.set(name, data)
            except BadScript as error:
                problems.add(place, str(error))
    Blackboard.clear()


def _mock(scenario: Scenario, mission: ScriptedMission, problems: _Problems) -> None:
    for spec, place in scenario.mocks:
        try:
            mission.mock([spec])
        except MissionError as error:
            problems.add(place, str(error))


def _check_names(scenario: Scenario, mission: ScriptedMission, problems: _Problems) -> None:
    """A pattern that fits nothing, or a key that nobody has, would be an expectation about nothing."""
    entries = mission.entries()
    for check in scenario.checks:
        patterns = check.conditions.patterns() if check.conditions is not None else []
        patterns += [leaf for leaf in check.leaves or () if leaf != ANY]
        for pattern in dict.fromkeys(patterns):
            if not mission.index.find(pattern):
                problems.add(check.place, mission.index.explain_unknown(pattern))
        for name in check.conditions.keys() if check.conditions is not None else ():
            if full_name(name) not in entries:
                near = did_you_mean(name, sorted(entries))
                problems.add(check.place, f"the mission has no blackboard entry {name!r}{near}")
