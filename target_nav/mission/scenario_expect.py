"""One item of `expect`: when to look, and what is to be seen then."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

import yaml
from py_trees.common import Status

from target_nav.mission.problems import did_you_mean
from target_nav.mission.scenario_checks import ANY
from target_nav.mission.scenario_match import BadExpectation, Matcher, matcher
from target_nav.mission.scenario_model import Check, Conditions, Place, When
from target_nav.mission.scenario_values import BadScript
from target_nav.mission.scenario_world import full_name
from target_nav.state.types import NavState, OutcomeKind
from target_nav.utils.yaml_nodes import NodeReader, describe, plain, scalar

WHEN_WORDS = ("at", "from", "to", "by", "after", "within_s", "within_ticks")
CONDITION_WORDS = ("leaf", "state", "outcome", "reason", "moves", "status", "message", "board", "not")
TRACE_WORDS = ("states", "leaves")
CHECK_WORDS = (*WHEN_WORDS, *CONDITION_WORDS, *TRACE_WORDS)
MOST_S = 3600.0

_FORMS = (
    {"at"},
    {"from"},
    {"from", "to"},
    {"by"},
    {"after", "by"},
    {"after", "within_s"},
    {"after", "within_ticks"},
)
_STATES = tuple(state.name for state in NavState)
_STATUSES = tuple(status.name for status in Status)
_OUTCOMES = (*(kind.value for kind in OutcomeKind), "none")


def read_check(file: NodeReader, node: yaml.Node, place: Place) -> Check | None:
    """None where it has complained."""
    parts = file.mapping(node, "an expectation", optional=CHECK_WORDS)
    if parts is None:
        return None
    traces = [word for word in TRACE_WORDS if word in parts]
    conditions = {word: value for word, value in parts.items() if word in CONDITION_WORDS}
    if len(traces) + bool(conditions) != 1:
        # what is only misspelt has been told
        if len(parts) == len(node.value):
            told = (
                "expects nothing" if not traces and not conditions else "expects a trace and something else"
            )
            file.complain(node, f"an expectation {told}; it must have one of {', '.join(TRACE_WORDS)}, or conditions: "
                          f"{', '.join(CONDITION_WORDS)}")  # fmt: skip
        return None
    when = _when(file, node, {word: parts[word] for word in WHEN_WORDS if word in parts}, bool(traces))
    if traces:
        names = _trace(file, parts[traces[0]], traces[0])
        if when is None or not names:
            return None
        if traces[0] == "states":
            return Check(place, when, states=names)
        return Check(place, when, leaves=names)
    wanted = _conditions(file, conditions)
    return Check(place, when, wanted) if when is not None else None


# -- when --------------------------------------------------------------------------------------------------------------


def _when(file: NodeReader, node: yaml.Node, parts: Mapping[str, yaml.Node], is_trace: bool) -> When | None:
    if not parts and is_trace:
        return When(0.0, None, every=True, text="in the whole scenario")
    if set(parts) not in _FORMS:
        told = f"says {' and '.join(parts)}" if parts else "does not say when"
        file.complain(
            node,
            f"an expectation {told}; it must say at, or from (and to), or by (and after), or after with within_s or "
            "within_ticks",
        )
        return None
    if "at" in parts and scalar(parts["at"]) == "end":
        return When(math.inf, None, every=True, text="at the end")
    if "within_ticks" in parts:
        after_s = file.number(parts["after"], "after", "s", 0.0, MOST_S)
        count = plain(parts["within_ticks"])
        if not isinstance(count, int) or isinstance(count, bool) or count < 1:
            file.complain(
                parts["within_ticks"],
                f"within_ticks is {describe(parts['within_ticks'])}; it must be a whole number from 1 on",
            )
            return None
        text = (
            f"within {count} tick{'s' if count > 1 else ''} from {after_s:g} s on"
            if after_s is not None
            else ""
        )
        return None if after_s is None else When(after_s, after_s, every=False, ticks=count, text=text)
    times = {word: file.number(value, word, "s", 0.0, MOST_S) for word, value in parts.items()}
    known = {word: value for word, value in times.items() if value is not None}
    if len(known) < len(times):
        return None
    return _window(file, node, known)


def _window(file: NodeReader, node: yaml.Node, times: Mapping[str, float]) -> When | None:
    if "at" in times:
        return When(times["at"], times["at"], every=True, text=f"at {times['at']:g} s")
    if "within_s" in times:
        end_s = times["after"] + times["within_s"]
        return When(
            times["after"],
            end_s,
            every=False,
            text=f"from {times['after']:g} s on within {times['within_s']:g} s",
        )
    begin_s = times.get("from", times.get("after", 0.0))
    until_s = times.get("to", times.get("by"))
    if until_s is not None and until_s < begin_s:
        file.complain(node, f"an expectation ends at {until_s:g} s, before it begins at {begin_s:g} s")
        return None
    if "by" in times:
        return When(begin_s, until_s, every=False, text=f"at some time from {begin_s:g} to {until_s:g} s")
    ending = "to the end" if until_s is None else f"to {until_s:g} s"
    return When(begin_s, until_s, every=True, text=f"all the time from {begin_s:g} s {ending}")


# -- what --------------------------------------------------------------------------------------------------------------


def _trace(file: NodeReader, node: yaml.Node, what: str) -> tuple[str, ...]:
    names: list[str] = []
    for item in file.sequence(node, what) or []:
        name = file.text(item, f"an item of {what}")
        if name is not None and what == "states" and name not in (*_STATES, ANY):
            file.complain(
                item, f"there is no state {name!r}{did_you_mean(name, _STATES)}; {_one_of((*_STATES, ANY))}"
            )
        elif name is not None:
            names.append(name)
    return tuple(names)


def _conditions(file: NodeReader, parts: Mapping[str, yaml.Node]) -> Conditions:
    inner: Conditions | None = None
    if "not" in parts:
        unwanted = file.mapping(parts["not"], "not", optional=CONDITION_WORDS[:-1])
        if unwanted is not None and not parts["not"].value:
            file.complain(parts["not"], "not has no conditions")
        inner = _conditions(file, unwanted or {})
    moves: Any = None
    if "moves" in parts:
        moves = scalar(parts["moves"])
        if not isinstance(moves, bool):
            file.complain(parts["moves"], f"moves is {describe(parts['moves'])}; it must be true or false")
            moves = None
    return Conditions(
        leaf=file.text(parts["leaf"], "leaf") if "leaf" in parts else None,
        state=_word(file, parts, "state", _STATES),
        outcome=_word(file, parts, "outcome", _OUTCOMES),
        reason=file.text(parts["reason"], "reason") if "reason" in parts else None,
        moves=moves,
        status=_statuses(file, parts["status"]) if "status" in parts else {},
        message=_messages(file, parts["message"]) if "message" in parts else {},
        board=_board(file, parts["board"]) if "board" in parts else {},
        none_of=inner,
    )


def _one_of(words: tuple[str, ...]) -> str:
    return f"it must be one of {', '.join(words)}"


def _word(
    file: NodeReader, parts: Mapping[str, yaml.Node], what: str, allowed: tuple[str, ...]
) -> str | None:
    if what not in parts:
        return None
    node = parts[what]
    word = "none" if plain(node) is None else str(plain(node))
    if word in allowed:
        return word
    file.complain(node, f"{what} is {describe(node)}{did_you_mean(word, allowed)}; {_one_of(allowed)}")
    return None


def _statuses(file: NodeReader, node: yaml.Node) -> dict[str, str]:
    found: dict[str, str] = {}
    for pattern, (_, value) in (file.items(node, "status") or {}).items():
        word = _word(file, {pattern: value}, pattern, _STATUSES)
        if word is not None:
            found[pattern] = word
    return found


def _messages(file: NodeReader, node: yaml.Node) -> dict[str, str]:
    found: dict[str, str] = {}
    for pattern, (_, value) in (file.items(node, "message") or {}).items():
        text = file.text(value, f"message of {pattern}")
        if text is not None:
            found[pattern] = text
    return found


def _board(file: NodeReader, node: yaml.Node) -> dict[str, Matcher]:
    found: dict[str, Matcher] = {}
    for name, (key_node, value) in (file.items(node, "board") or {}).items():
        try:
            full_name(name)
        except BadScript as error:
            file.complain(key_node, str(error))
            continue
        try:
            found[name] = matcher(plain(value))
        except BadExpectation as error:
            file.complain(value, f"{name}: {error}")
    return found
