"""What a mission did, in the few lines that a person reads after a failed expectation."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from difflib import ndiff
from itertools import groupby

from target_nav.mission.observation import Observation

MOST_LINES = 40


def timeline(seen: Iterable[Observation]) -> list[str]:
    """A line for each change of state, leaf or outcome, with the reason that was given then."""
    lines: list[str] = []
    last: tuple[object, ...] = ()
    for tick in seen:
        outcome = tick.outcome.kind.value if tick.outcome is not None else ""
        key = (tick.state, tick.leaf, outcome)
        if key != last:
            last = key
            ended = f"  [{outcome}]" if outcome else ""
            lines.append(
                f"{tick.now_s:7.2f} s  {tick.state.name:<14} {tick.leaf_name or '-':<20} {tick.reason}{ended}".rstrip()
            )
    return shortened(lines)


def spans(ticks: Sequence[Observation], value: Callable[[Observation], str]) -> list[str]:
    """A value over time, a line for each stretch in which it stays the same."""
    lines: list[str] = []
    for text, group in groupby(ticks, value):
        stretch = list(group)
        begin_s, end_s = stretch[0].now_s, stretch[-1].now_s
        when = f"{begin_s:.2f} s" if begin_s == end_s else f"{begin_s:.2f} to {end_s:.2f} s"
        lines.append(f"{when}: {text}")
    return shortened(lines)


def without_repetitions(names: Iterable[str]) -> list[str]:
    return [name for name, _ in groupby(names)]


def trace_diff(expected: Sequence[str], got: Sequence[str]) -> list[str]:
    """`-` was expected, `+` came instead."""
    return [line.rstrip() for line in ndiff(list(expected), list(got)) if not line.startswith("?")]


def shortened(lines: list[str]) -> list[str]:
    if len(lines) <= MOST_LINES:
        return lines
    half = MOST_LINES // 2
    return [*lines[:half], f"... {len(lines) - 2 * half} more ...", *lines[-half:]]
