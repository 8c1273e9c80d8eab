"""Everything wrong with a mission, before its first tick.

Two passes: over the definitions, each node once, used or not (`Definitions`), and over the mission as it will run,
with subtrees written out (`wiring`). Both go on after an error, so that all is told at once.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path

from target_nav.mission.definitions import Definitions
from target_nav.mission.expand import Expander, Instance
from target_nav.mission.includes import Library, load_library
from target_nav.mission.lint_motion import check_motion
from target_nav.mission.problems import Problem, Report, TooManyProblems
from target_nav.mission.registry import NodeRegistry, default_registry
from target_nav.mission.wiring import check_wiring


@dataclass(frozen=True)
class Analysis:
    """A mission that has been looked at. `root` is None when it could not be written out."""

    library: Library
    root: Instance | None
    problems: tuple[Problem, ...]

    @property
    def errors(self) -> tuple[Problem, ...]:
        return tuple(problem for problem in self.problems if problem.severity == "error")


def analyse(
    path: Path,
    registry: NodeRegistry | None = None,
    provided_keys: Iterable[str] = (),
    main_tree: str | None = None,
) -> Analysis:
    """Reads, checks and writes out a mission. Never raises for what a file says."""
    registry = registry if registry is not None else default_registry()
    report, library, root = Report(), Library(), None
    try:
        load_library(path, library, report, main_tree)
        Definitions(library, registry, report).check()
        root = Expander(library, registry, report).expand()
        if root is not None:
            check_wiring(root, frozenset(provided_keys), report)
            check_motion(root, report)
    except TooManyProblems:
        pass
    return Analysis(library, root, tuple(report.problems()))


def check_file(
    path: str | Path, registry: NodeRegistry | None = None, provided_keys: Iterable[str] = ()
) -> list[Problem]:
    """All problems of a mission file and of what it includes, in the order of reading; empty when there is none.

    `provided_keys` are blackboard entries (`/goal`) that something outside the mission writes, beside those of
    `target_nav.state.keys`.
    """
    return list(analyse(Path(path), registry, provided_keys).problems)
