"""What is wrong with a mission, with the place where it is wrong: collected first, told all at once."""

from __future__ import annotations

import difflib
from collections.abc import Iterable
from dataclasses import dataclass
from typing import Literal

Severity = Literal["error", "warning"]


@dataclass(frozen=True, order=True)
class Position:
    """A place in a file. Lines and columns count from 1; a column is a character, not a byte."""

    file: str
    line: int = 1
    column: int = 1

    def __str__(self) -> str:
        return f"{self.file}:{self.line}:{self.column}"


@dataclass(frozen=True, order=True)
class Problem:
    """One thing that is wrong, and what is allowed there."""

    file: str
    line: int
    column: int
    severity: Severity
    message: str

    def __str__(self) -> str:
        return f"{self.file}:{self.line}:{self.column}: {self.severity}: {self.message}"


MAX_PROBLEMS = 200
MAX_MESSAGE = 1000
MAX_CANDIDATES = 500


class TooManyProblems(Exception):
    """Raised by a `Report` that has seen enough, so that a hopeless file does not take for ever."""


class Report:
    """Collects problems. The same message at the same place counts once (a subtree is looked at once per use)."""

    def __init__(self) -> None:
        self._problems: dict[Problem, None] = {}

    def error(self, at: Position, message: str) -> None:
        self._add(at, "error", message)

    def warning(self, at: Position, message: str) -> None:
        self._add(at, "warning", message)

    def _add(self, at: Position, severity: Severity, message: str) -> None:
        # a value with a line break in it must not make two lines of one problem
        message = message.replace("\r", "\\r").replace("\n", "\\n")
        if len(message) > MAX_MESSAGE:
            message = f"{message[:MAX_MESSAGE]}..."
        if len(self._problems) >= MAX_PROBLEMS:
            self._problems[Problem(at.file, at.line, at.column, "error", "more problems, not looked for")] = (
                None
            )
            raise TooManyProblems
        self._problems[Problem(at.file, at.line, at.column, severity, message)] = None

    @property
    def has_errors(self) -> bool:
        return any(problem.severity == "error" for problem in self._problems)

    def problems(self) -> list[Problem]:
        """In the order of reading: files as they were opened, then line and column."""
        order: dict[str, int] = {}
        for problem in self._problems:
            order.setdefault(problem.file, len(order))
        return sorted(self._problems, key=lambda p: (order[p.file], p.line, p.column, p.severity, p.message))


def did_you_mean(name: str, known: Iterable[str]) -> str:
    """`; did you mean "x"?` with the nearest known name, or nothing when none is near."""
    candidates = list(known)[:MAX_CANDIDATES]
    # Case first: difflib counts "sequence" and "Sequence" as two different letters, and "ID" and "id" as strangers.
    folded = [candidate for candidate in candidates if candidate.casefold() == name.casefold()]
    near = folded or difflib.get_close_matches(name, candidates, n=1, cutoff=0.6)
    return f'; did you mean "{near[0]}"?' if near else ""


def listed(names: Iterable[str]) -> str:
    """The names in a sentence, or `none`."""
    return ", ".join(names) or "none"
