"""A mock as a scenario's file says it: a status, or a mapping with `returns`, `after_s`, `message`, `writes` ..."""

from __future__ import annotations

import re
from typing import Any

import yaml
from py_trees.common import Status

from target_nav.mission.mocks import RESULTS, MockSpec
from target_nav.mission.scenario_values import BadScript, value_of
from target_nav.state.types import STOP, Twist2D
from target_nav.utils.yaml_nodes import NodeReader, describe, plain

WORDS = ("returns", "after_s", "message", "writes", "twist")
MOST_TIMES = 100_000
_TIMES = re.compile(r"([A-Z]+) *x *([0-9]{1,6})")


def read_mock(file: NodeReader, pattern: str, node: yaml.Node) -> MockSpec | None:
    """None where it has complained."""
    what = f"mock of {pattern!r}"
    if not isinstance(node, yaml.MappingNode):
        returns = _statuses(file, node, what)
        return MockSpec(pattern, returns) if returns else None
    parts = file.mapping(node, what, optional=WORDS)
    if parts is None:
        return None
    returns = (
        _statuses(file, parts["returns"], f"{what}: returns") if "returns" in parts else [Status.SUCCESS]
    )
    after_s = file.number(parts["after_s"], f"{what}: after_s", "s", 0.0) if "after_s" in parts else 0.0
    message = file.text(parts["message"], f"{what}: message") if "message" in parts else ""
    writes: dict[str, Any] = {}
    if "writes" in parts:
        writes = {
            key: plain(value)
            for key, (_, value) in (file.items(parts["writes"], f"{what}: writes") or {}).items()
        }
    twist: Twist2D = STOP
    if "twist" in parts:
        try:
            twist = value_of(plain(parts["twist"]), Twist2D, f"{what}: twist")
        except BadScript as error:
            file.complain(parts["twist"], str(error))
    if not returns or after_s is None or message is None:
        return None
    return MockSpec(pattern, tuple(returns), after_s, message, writes, twist)


def _statuses(file: NodeReader, node: yaml.Node, what: str) -> list[Status]:
    """One status or a list of them; `RUNNING x 3` is three."""
    statuses: list[Status] = []
    for each in node.value if isinstance(node, yaml.SequenceNode) else [node]:
        text = str(each.value) if isinstance(each, yaml.ScalarNode) else ""
        match = _TIMES.fullmatch(text)
        word, times = (match[1], int(match[2])) if match else (text, 1)
        if word not in (status.name for status in RESULTS) or not 1 <= times <= MOST_TIMES:
            allowed = ", ".join(status.name for status in RESULTS)
            file.complain(
                each, f"{what} is {describe(each)}; it must be {allowed}, or one of them as in RUNNING x 3"
            )
        else:
            statuses += [Status[word]] * times
    return statuses
