"""YAML as nodes that know their line, for files whose every mistake is to be told with file and line.

What a person's file never needs and a hostile one does is refused while reading: aliases (a few bytes can stand for
gigabytes), deep nesting, files over the limit of size.
"""

from __future__ import annotations

import difflib
import math
import re
from collections.abc import Collection
from pathlib import Path
from typing import Any

import yaml

from target_nav.errors import ConfigError, TargetNavError

MAX_BYTES = 1_000_000
MAX_DEPTH = 12

# YAML 1.1, which PyYAML reads, takes 1e-3 for text: it wants a point in the number.
_NUMBER_WITHOUT_POINT = re.compile(r"[-+]?[0-9]+[eE][-+]?[0-9]+")
_WHOLE_NUMBER = re.compile(r"[-+]?[0-9]+")
_PLAIN_NUMBER = re.compile(r"[-+]?([0-9]+\.?[0-9]*|\.[0-9]+)([eE][-+]?[0-9]+)?")


class _NodeLoader(yaml.SafeLoader):
    """Composes nodes only; no object is ever made."""

    depth = 0

    def compose_node(self, parent: yaml.Node | None, index: int) -> yaml.Node | None:
        if self.check_event(yaml.AliasEvent):
            raise yaml.MarkedYAMLError(
                problem="an alias (*name) is not taken here; write the value out",
                problem_mark=self.peek_event().start_mark,
            )
        if self.depth >= MAX_DEPTH:
            raise yaml.MarkedYAMLError(
                problem=f"nested deeper than {MAX_DEPTH}; is a bracket missing?",
                problem_mark=self.peek_event().start_mark,
            )
        self.depth += 1
        node: yaml.Node | None = super().compose_node(parent, index)
        self.depth -= 1
        return node


class NodeReader:
    """Takes values out of nodes and collects what is wrong. Every taker returns None where it has complained.

    `error` is what is raised, `manual` the page that an empty file is sent to.
    """

    def __init__(
        self, path: Path, error: type[TargetNavError] = ConfigError, manual: str = "docs/simulator.md"
    ) -> None:
        self.path = path
        self._error = error
        self._manual = manual
        self._problems: list[tuple[int, str]] = []

    def load(self) -> yaml.Node:
        """The file's root.

        Raises:
            TargetNavError: the file cannot be read, is too large, empty or not YAML.
        """
        try:
            with self.path.open("rb") as file:
                data = file.read(MAX_BYTES + 1)
        except OSError as error:
            raise self._error(f"{self.path}:1: error: cannot be read ({error.strerror or error})") from None
        if len(data) > MAX_BYTES:
            raise self._error(f"{self.path}:1: error: larger than {MAX_BYTES} bytes; is it the right file?")
        try:
            node = yaml.compose(data.decode("utf-8"), Loader=_NodeLoader)
        except UnicodeDecodeError as error:
            line = data[: error.start].count(b"\n") + 1
            raise self._error(f"{self.path}:{line}: error: not UTF-8 text; is it the right file?") from None
        except yaml.MarkedYAMLError as error:
            mark = error.problem_mark or error.context_mark
            line = mark.line + 1 if mark is not None else 1
            raise self._error(
                f"{self.path}:{line}: error: not YAML: {error.problem or error.context}"
            ) from None
        except yaml.YAMLError as error:
            reason = str(error).splitlines()[0]
            raise self._error(f"{self.path}:1: error: not YAML: {reason}") from None
        if node is None:
            raise self._error(f"{self.path}:1: error: the file is empty; see {self._manual} for the format")
        return node

    def complain(self, node: yaml.Node, message: str) -> None:
        self._problems.append((line_of(node), message))

    def raise_problems(self) -> None:
        """
        Raises:
            TargetNavError: something was wrong; in the order of the lines.
        """
        if self._problems:
            ordered = sorted(self._problems, key=lambda problem: problem[0])
            raise self._error("\n".join(f"{self.path}:{line}: error: {text}" for line, text in ordered))

    def mapping(
        self, node: yaml.Node, what: str, required: Collection[str] = (), optional: Collection[str] = ()
    ) -> dict[str, yaml.Node] | None:
        """A mapping's values by key; unknown, missing and repeated keys are complained about."""
        items = self.items(node, what)
        if items is None:
            return None
        allowed = [*required, *optional]
        result: dict[str, yaml.Node] = {}
        for key, (key_node, value) in items.items():
            if key in allowed:
                result[key] = value
            else:
                self.complain(key_node, f"{what} has no key {key!r}; {_nearest(key, allowed)}")
        missing = [key for key in required if key not in result]
        if missing:
            self.complain(node, f"{what} lacks {', '.join(missing)}")
        return result

    def items(self, node: yaml.Node, what: str) -> dict[str, tuple[yaml.Node, yaml.Node]] | None:
        """A mapping as key -> (key's node, value's node), whatever the keys are."""
        if not isinstance(node, yaml.MappingNode):
            self.complain(node, f"{what} is {describe(node)}; it must be a mapping (key: value)")
            return None
        result: dict[str, tuple[yaml.Node, yaml.Node]] = {}
        for key_node, value in node.value:
            if not isinstance(key_node, yaml.ScalarNode):
                self.complain(key_node, f"{what} has {describe(key_node)} for a key; it must be a word")
            elif key_node.value in result:
                first = line_of(result[key_node.value][0])
                self.complain(
                    key_node, f"{what} has {key_node.value!r} twice (first in line {first}); keep one"
                )
            else:
                result[key_node.value] = (key_node, value)
        return result

    def sequence(self, node: yaml.Node, what: str) -> list[yaml.Node] | None:
        if not isinstance(node, yaml.SequenceNode):
            self.complain(node, f"{what} is {describe(node)}; it must be a list")
            return None
        return list(node.value)

    def text(self, node: yaml.Node, what: str) -> str | None:
        if isinstance(node, yaml.ScalarNode) and node.tag == "tag:yaml.org,2002:str" and node.value.strip():
            return str(node.value)
        self.complain(node, f"{what} is {describe(node)}; it must be a word")
        return None

    def number(
        self, node: yaml.Node, what: str, unit: str, low: float = -math.inf, high: float = math.inf
    ) -> float | None:
        """A finite number between the limits, both included."""
        value = scalar(node)
        if isinstance(value, bool) or not isinstance(value, (int, float)):
            self.complain(node, f"{what} is {describe(node)}; it must be a number in {unit}")
            return None
        if not math.isfinite(value):
            self.complain(node, f"{what} is {node.value}; it must be a finite number in {unit}")
            return None
        if not low <= value <= high:
            self.complain(node, f"{what} is {value:g} {unit}; it must lie in {low:g} ... {high:g} {unit}")
            return None
        return float(value)

    def numbers(
        self, node: yaml.Node, what: str, names: tuple[str, ...], limits: tuple[float, float], unit: str = "m"
    ) -> list[float] | None:
        """As many numbers as there are names, in `unit`; what is called yaw, in rad."""
        nodes = self.sequence(node, what)
        if nodes is None:
            return None
        if len(nodes) != len(names):
            self.complain(
                node, f"{what} has {len(nodes)} values; it must have {len(names)}: {', '.join(names)}"
            )
            return None
        values = [
            self.number(item, f"{what}'s {name}", "rad" if name == "yaw" else unit, *limits)
            for item, name in zip(nodes, names)
        ]
        return None if None in values else [value for value in values if value is not None]


def line_of(node: yaml.Node) -> int:
    return int(node.start_mark.line) + 1


def scalar(node: yaml.Node) -> bool | int | float | str | None:
    """A scalar's value: number, truth value or text; None for anything else."""
    if not isinstance(node, yaml.ScalarNode):
        return None
    kind, text = node.tag.rpartition(":")[2], str(node.value)
    if kind == "bool":
        return text.lower() in ("yes", "true", "on")
    if kind in ("int", "float"):
        if _PLAIN_NUMBER.fullmatch(text):
            return float(text)
        # .nan and .inf; what else YAML 1.1 calls a number (0x1F, 1:30, 1_000) is more often a slip
        return math.nan if "nan" in text.lower() else math.inf if "inf" in text.lower() else text
    if kind == "str":
        return float(text) if node.style is None and _NUMBER_WITHOUT_POINT.fullmatch(text) else text
    return None


def plain(node: yaml.Node) -> Any:
    """A node as Python's own values: mappings by their keys' text, whole numbers as int, nothing as None."""
    if isinstance(node, yaml.MappingNode):
        return {str(key.value): plain(value) for key, value in node.value}
    if isinstance(node, yaml.SequenceNode):
        return [plain(item) for item in node.value]
    value = scalar(node)
    if isinstance(value, float) and _WHOLE_NUMBER.fullmatch(node.value):
        return int(node.value)
    return value


def describe(node: yaml.Node) -> str:
    """A node in words for a message."""
    if isinstance(node, yaml.MappingNode):
        return "a mapping"
    if isinstance(node, yaml.SequenceNode):
        return f"a list of {len(node.value)}"
    if isinstance(node, yaml.ScalarNode) and not node.value and node.style is None:
        return "empty"
    return repr(node.value if len(node.value) <= 40 else f"{node.value[:40]}...")


def _nearest(key: str, allowed: list[str]) -> str:
    near = difflib.get_close_matches(key, allowed, n=1)
    return f"did you mean {near[0]!r}?" if near else f"it has {', '.join(allowed)}"
