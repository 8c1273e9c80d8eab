"""Expectations against what was observed, and what a person needs to see where they part."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from typing import Any

from target_nav.mission.observation import Observation
from target_nav.mission.scenario_match import Matcher
from target_nav.mission.scenario_model import Check, Conditions, Place, When
from target_nav.mission.scenario_report import spans, trace_diff, without_repetitions
from target_nav.mission.scenario_world import full_name
from target_nav.mission.scripted_mission import ROUNDING_S
from target_nav.mission.tree_index import TreeIndex
from target_nav.mission.values_text import value_text
from target_nav.state.types import STOP

ANY = "..."


@dataclass(frozen=True)
class Failure:
    """`expected` in words, `got` as lines."""

    place: Place
    expected: str
    got: tuple[str, ...]


@dataclass(frozen=True)
class _Part:
    """One condition. `problem` is why a tick does not meet it, or nothing; `value` is what is shown of a tick."""

    what: str
    problem: Callable[[Observation], str]
    value: Callable[[Observation], str]


def failure_of(check: Check, seen: Sequence[Observation], index: TreeIndex) -> Failure | None:
    """None when the expectation was met."""
    ticks = _ticks_of(check.when, seen)
    if not ticks:
        return Failure(check.place, f"something {check.when.text}", ("the scenario has no tick then",))
    if check.states is not None:
        got = without_repetitions(tick.state.name for tick in ticks)
        return _trace(check, "states", check.states, got, str.__eq__)
    if check.leaves is not None:
        got = without_repetitions(index.path_of(tick.leaf) if tick.leaf is not None else "" for tick in ticks)
        return _trace(check, "leaves", check.leaves, got, lambda pattern, path: index.fits(pattern, path))
    assert check.conditions is not None, "a check has a trace or conditions"
    return _failed_conditions(check, list(_parts(check.conditions, index)), ticks)


def _ticks_of(when: When, seen: Sequence[Observation]) -> Sequence[Observation]:
    if when.from_s == float("inf"):
        return seen[-1:]
    ticks = [tick for tick in seen if tick.now_s >= when.from_s - ROUNDING_S]
    if when.ticks is not None:
        return ticks[: when.ticks]
    if when.to_s is None:
        return ticks
    if when.to_s == when.from_s:
        # a moment between two ticks means the next one
        return ticks[:1]
    return [tick for tick in ticks if tick.now_s <= when.to_s + ROUNDING_S]


# -- traces ------------------------------------------------------------------------------------------------------------


def _trace(
    check: Check, what: str, expected: Sequence[str], got: list[str], fits: Callable[[str, str], bool]
) -> Failure | None:
    if trace_fits(expected, got, fits):
        return None
    shown = [name.rsplit("/", 1)[-1] for name in got]
    title = f"{check.when.text}: {what} {', '.join(expected)}"
    return Failure(check.place, title, tuple(trace_diff(expected, shown)))


def trace_fits(expected: Sequence[str], got: Sequence[str], fits: Callable[[str, str], bool]) -> bool:
    """Whether `got` is `expected`, where `...` stands for any part, also an empty one."""
    reached = {0}
    for pattern in expected:
        if pattern == ANY:
            reached = set(range(min(reached), len(got) + 1)) if reached else set()
        else:
            reached = {i + 1 for i in reached if i < len(got) and fits(pattern, got[i])}
    return len(got) in reached


# -- conditions --------------------------------------------------------------------------------------------------------


def _failed_conditions(check: Check, parts: list[_Part], ticks: Sequence[Observation]) -> Failure | None:
    problems = [[part.problem(tick) for part in parts] for tick in ticks]
    holds = [not any(each) for each in problems]
    if all(holds) if check.when.every else any(holds):
        return None
    expected = f"{check.when.text}: {', '.join(part.what for part in parts)}"
    if check.when.every:
        first = holds.index(False)
        texts = [text for text in problems[first] if text]
        where = f"at {ticks[first].now_s:.2f} s "
        return Failure(check.place, expected, tuple(where + text for text in texts))
    got: list[str] = []
    for number, part in enumerate(parts):
        if any(each[number] for each in problems):
            got += spans(ticks, lambda tick, part=part: part.value(tick))  # type: ignore[misc]
    return Failure(check.place, expected, tuple(got))


def _parts(wanted: Conditions, index: TreeIndex) -> Iterable[_Part]:
    if wanted.leaf is not None:
        yield _leaf(wanted.leaf, index)
    if wanted.state is not None:
        yield _valued("state", wanted.state, lambda tick: tick.state.name)
    if wanted.outcome is not None:
        yield _valued(
            "outcome", wanted.outcome, lambda tick: tick.outcome.kind.value if tick.outcome else "none"
        )
    if wanted.reason is not None:
        yield _matched("reason", Matcher(wanted.reason), lambda tick: tick.reason)
    if wanted.moves is not None:
        yield _valued("the robot", "moving" if wanted.moves else "standing", _motion)
    for pattern, status in wanted.status.items():
        yield _of_behaviours(
            f"status of {pattern}", pattern, Matcher(status), index, lambda t: [s.name for s in t.statuses]
        )
    for pattern, text in wanted.message.items():
        yield _of_behaviours(
            f"message of {pattern}", pattern, Matcher(text), index, lambda tick: tick.messages
        )
    for name, matcher in wanted.board.items():
        yield _entry(name, matcher)
    if wanted.none_of is not None:
        yield _negated(list(_parts(wanted.none_of, index)))


def _motion(tick: Observation) -> str:
    return "moving" if tick.request is not None and tick.request.twist != STOP else "standing"


def _valued(what: str, wanted: str, value: Callable[[Observation], str]) -> _Part:
    def problem(tick: Observation) -> str:
        return "" if value(tick) == wanted else f"{what} is {value(tick)}, not {wanted}"

    return _Part(f"{what} is {wanted}", problem, lambda tick: f"{what} is {value(tick)}")


def _leaf(pattern: str, index: TreeIndex) -> _Part:
    fitting = {index.nodes[i] for i in index.find(pattern)}

    def problem(tick: Observation) -> str:
        return "" if tick.leaf in fitting else f"leaf is {tick.leaf_name or 'none'}, not {pattern}"

    return _Part(f"leaf is {pattern}", problem, lambda tick: f"leaf is {tick.leaf_name or 'none'}")


def _matched(what: str, matcher: Matcher, value: Callable[[Observation], Any]) -> _Part:
    def problem(tick: Observation) -> str:
        why = matcher.mismatch(value(tick))
        return f"{what} {why}" if why else ""

    return _Part(f"{what} is {matcher}", problem, lambda tick: f"{what} is {value_text(value(tick))}")


def _entry(name: str, matcher: Matcher) -> _Part:
    path = full_name(name)
    return _matched(name, matcher, lambda tick: tick.board.get(path))


def _of_behaviours(
    what: str,
    pattern: str,
    matcher: Matcher,
    index: TreeIndex,
    values: Callable[[Observation], Sequence[str]],
) -> _Part:
    """Of one of the behaviours that the pattern fits."""
    found = index.find(pattern)

    def of(tick: Observation) -> list[str]:
        every = values(tick)
        return [every[i] for i in found]

    def problem(tick: Observation) -> str:
        if any(not matcher.mismatch(value) for value in of(tick)):
            return ""
        return f"{what} is {' and '.join(dict.fromkeys(of(tick)))}, not {matcher}"

    return _Part(
        f"{what} is {matcher}", problem, lambda tick: f"{what} is {' and '.join(dict.fromkeys(of(tick)))}"
    )


def _negated(parts: list[_Part]) -> _Part:
    what = " and ".join(part.what for part in parts)

    def problem(tick: Observation) -> str:
        return "" if any(part.problem(tick) for part in parts) else what

    return _Part(f"not ({what})", problem, lambda tick: ", ".join(part.value(tick) for part in parts))
