"""Scenario files: YAML into `Scenario`s, or everything that is wrong with them, each with its line.

The format is in docs/scenarios.md. Whether the names in it are those of the mission is looked at when it is loaded
(`scenario_run`), not here.
"""

from __future__ import annotations

import math
import re
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import yaml

from target_nav.errors import MissionError
from target_nav.mission.mocks import MockSpec
from target_nav.mission.scenario_expect import read_check
from target_nav.mission.scenario_mock import read_mock
from target_nav.mission.scenario_model import Change, Check, Place, Scenario
from target_nav.mission.scenario_run import unknown_names
from target_nav.mission.scenario_values import BadScript
from target_nav.mission.scenario_world import settable
from target_nav.mission.scripted_mission import WORDS
from target_nav.state.types import CommandKind
from target_nav.utils.yaml_nodes import NodeReader, describe, line_of, plain, scalar

MOST_S = 3600.0
SHARED = ("robot", "config", "mocks", "board")
_LINE = re.compile(r":([0-9]+): error: ")
ROBOT = {"drives": True, "stands": False}


def read_scenarios(path: str | Path) -> tuple[Scenario, ...]:
    """All scenarios of a file, in its order.

    Raises:
        MissionError: one line `file:line: error: ...` a problem, all of them.
    """
    return _FileReader(Path(path)).read()


def _together(told: str, scenarios: list[Scenario]) -> str:
    """What is wrong by itself, and which names of the rest do not fit the mission, in the order of the lines."""
    lines = told.splitlines()
    for scenario in scenarios:
        lines += unknown_names(scenario)
    return "\n".join(sorted(dict.fromkeys(lines), key=_line))


def _line(text: str) -> int:
    match = _LINE.search(text)
    return int(match[1]) if match else 0


class _FileReader:
    def __init__(self, path: Path) -> None:
        self._path = path
        self._file = NodeReader(path, MissionError, "docs/scenarios.md")

    def read(self) -> tuple[Scenario, ...]:
        root = self._file.load()
        scenarios: list[Scenario] = []
        top = self._file.mapping(root, "a scenario file", ("mission", "scenarios"), ("defaults",))
        if top is not None:
            mission = self._mission(top["mission"]) if "mission" in top else self._path
            defaults: dict[str, yaml.Node] = {}
            if "defaults" in top:
                defaults = self._file.mapping(top["defaults"], "defaults", optional=SHARED) or {}
                # looked at once here, so that what is wrong is told even if no scenario is right
                self._shared(defaults, "defaults")
            for node in self._items(top.get("scenarios"), "scenarios"):
                scenario = self._scenario(node, mission, defaults)
                if scenario is not None:
                    scenarios.append(scenario)
        try:
            self._file.raise_problems()
        except MissionError as error:
            raise MissionError(_together(str(error), scenarios)) from None
        return tuple(scenarios)

    def place(self, node: yaml.Node) -> Place:
        return Place(str(self._path), line_of(node))

    def _items(self, node: yaml.Node | None, what: str) -> list[yaml.Node]:
        if node is None:
            return []
        items = self._file.sequence(node, what) or []
        if not items and isinstance(node, yaml.SequenceNode):
            self._file.complain(node, f"{what} is empty; it must have one at least")
        return items

    def _mission(self, node: yaml.Node) -> Path:
        text = self._file.text(node, "mission") or ""
        path = self._path.parent / text
        if text and not path.is_file():
            self._file.complain(
                node, f"mission is {text!r}; there is no file {path} (it is relative to this file)"
            )
        return path

    def _scenario(self, node: yaml.Node, mission: Path, defaults: Mapping[str, yaml.Node]) -> Scenario | None:
        what = "a scenario"
        parts = self._file.mapping(node, what, ("name", "expect"), ("script", "lasts_s", *SHARED))
        if parts is None:
            return None
        name = self._file.text(parts["name"], "name") if "name" in parts else None
        what = f"scenario {name!r}"
        common, own = self._shared(defaults, what, quiet=True), self._shared(parts, what)
        script = [change for change in (common.first, own.first) if change is not None]
        script += [
            change
            for item in self._items(parts.get("script"), f"{what}: script")
            if (change := self._change(item)) is not None
        ]
        checks = [
            check
            for item in self._items(parts.get("expect"), f"{what}: expect")
            if (check := self._check(item)) is not None
        ]
        lasts_s = self._lasts(parts, node, what, script, checks)
        return Scenario(
            name=name or "",
            place=self.place(node),
            mission=mission,
            drives=own.drives if own.drives is not None else common.drives is not False,
            config={**common.config, **own.config},
            mocks=(*own.mocks, *common.mocks),
            script=tuple(script),
            checks=tuple(checks),
            lasts_s=lasts_s,
        )

    def _lasts(
        self,
        parts: Mapping[str, yaml.Node],
        node: yaml.Node,
        what: str,
        script: list[Change],
        checks: list[Check],
    ) -> float:
        """How long it goes on: as it says, or up to the last time that it names."""
        named = [change.at_s for change in script]
        for check in checks:
            named.append(0.0 if math.isinf(check.when.from_s) else check.when.from_s)
            named.append(check.when.to_s or 0.0)
        last_s = max(named, default=0.0)
        if "lasts_s" in parts:
            given = self._file.number(parts["lasts_s"], f"{what}: lasts_s", "s", 0.0, MOST_S)
            if given is not None and last_s > given:
                self._file.complain(
                    parts["lasts_s"],
                    f"{what}: lasts_s is {given:g} s, but it names {last_s:g} s; let it last longer",
                )
            return given or 0.0
        if checks and not last_s > 0.0:
            self._file.complain(node, f"{what} names no time; say how long it lasts (lasts_s)")
        return last_s

    # -- script --------------------------------------------------------------------------------------------------------

    def _change(self, node: yaml.Node) -> Change | None:
        items = self._file.items(node, "a step of the script")
        if items is None:
            return None
        if "at" not in items:
            self._file.complain(node, "a step of the script lacks at, the second from which on it holds")
            return None
        at_s = self._file.number(items["at"][1], "at", "s", 0.0, MOST_S)
        words = self._words(items["say"][1]) if "say" in items else ()
        board = self._board(
            {name: pair for name, pair in items.items() if name not in ("at", "say")}, ("at", "say")
        )
        return Change(at_s, board, words) if at_s is not None else None

    def _words(self, node: yaml.Node) -> tuple[CommandKind, ...]:
        nodes = list(node.value) if isinstance(node, yaml.SequenceNode) else [node]
        words: list[CommandKind] = []
        for each in nodes:
            word = str(each.value) if isinstance(each, yaml.ScalarNode) else ""
            if word in WORDS:
                words.append(CommandKind[word])
            else:
                self._file.complain(each, f"say is {describe(each)}; the words are {', '.join(WORDS)}")
        return tuple(words)

    def _board(
        self, items: Mapping[str, tuple[yaml.Node, yaml.Node]], besides: tuple[str, ...] = ()
    ) -> dict[str, tuple[Any, Place]]:
        board: dict[str, tuple[Any, Place]] = {}
        for name, (key_node, value) in items.items():
            try:
                settable(name)
            except BadScript as error:
                also = f" (and {', '.join(besides)})" if besides and "there is no key" in str(error) else ""
                self._file.complain(key_node, f"{error}{also}")
                continue
            board[name] = (plain(value), self.place(value))
        return board

    # -- what scenarios share with their file's defaults ---------------------------------------------------------------

    def _shared(self, parts: Mapping[str, yaml.Node], what: str, quiet: bool = False) -> _Shared:
        """With `quiet`, what is wrong has been told already."""
        file = NodeReader(self._path) if quiet else self._file
        drives: bool | None = None
        if "robot" in parts:
            word = scalar(parts["robot"])
            drives = ROBOT.get(word) if isinstance(word, str) else None
            if drives is None:
                file.complain(
                    parts["robot"],
                    f"{what}: robot is {describe(parts['robot'])}; it must be drives or stands",
                )
        config: dict[str, object] = {}
        for key, (_, value) in (
            (file.items(parts["config"], f"{what}: config") or {}).items() if "config" in parts else ()
        ):
            config[key] = plain(value)
        mocks: list[tuple[MockSpec, Place]] = []
        for pattern, (_, value) in (
            (file.items(parts["mocks"], f"{what}: mocks") or {}).items() if "mocks" in parts else ()
        ):
            mock = read_mock(file, pattern, value)
            if mock is not None:
                mocks.append((mock, self.place(value)))
        first: Change | None = None
        if "board" in parts:
            items = file.items(parts["board"], f"{what}: board") or {}
            if quiet:
                board = {name: (plain(value), self.place(value)) for name, (_, value) in items.items()}
            else:
                board = self._board(items)
            first = Change(0.0, board)
        return _Shared(drives, config, tuple(mocks), first)

    def _check(self, node: yaml.Node) -> Check | None:
        return read_check(self._file, node, self.place(node))


class _Shared:
    def __init__(
        self,
        drives: bool | None,
        config: dict[str, object],
        mocks: tuple[tuple[MockSpec, Place], ...],
        first: Change | None,
    ) -> None:
        self.drives, self.config, self.mocks, self.first = drives, config, mocks, first
