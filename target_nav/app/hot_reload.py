"""A mission's file that changes while it runs: checked at once, swapped in while the robot holds still, or on command.

A thread looks at the files twice a second and checks what has changed; a broken file changes nothing, and the log says
what is wrong with it, each line with its place. A right one is swapped in between two ticks: at once after RELOAD,
otherwise when the robot has stood for a second. The new mission begins at its beginning and waits for GO, so editing a
file never sets a robot in motion.
"""

from __future__ import annotations

import logging
import threading
from collections.abc import Callable, Iterable
from dataclasses import dataclass, field
from enum import Enum
from pathlib import Path
from typing import ClassVar

from py_trees.behaviour import Behaviour

from target_nav.app.nav_core import NavCore
from target_nav.app.paths import mission_path
from target_nav.errors import MissionError
from target_nav.mission import LoadedMission
from target_nav.mission.check import analyse
from target_nav.mission.replace import replace_mission
from target_nav.state.types import STOP, TickRecord

PERIOD_S = 0.5
STILL_S = 1.0

log = logging.getLogger(__name__)


class ReloadMode(str, Enum):
    STILL = "still"
    """A changed file is swapped in when the robot holds still."""
    COMMAND = "command"
    """Only after RELOAD."""


@dataclass(frozen=True)
class Finding:
    """What has come of the files: wrong, or right and to be taken. `at_once`: somebody asked for them."""

    problems: tuple[str, ...] = ()
    at_once: bool = False
    same: bool = False
    """They are again what was loaded: there is nothing to be taken."""
    checker: MissionChecker | None = field(default=None, compare=False)
    """Of another mission than the present one."""

    SAME: ClassVar[Finding]


Finding.SAME = Finding(same=True)


class MissionChecker:
    """Looks at the files of a mission. Any thread may; it takes its time, and never touches the blackboard."""

    def __init__(self, path: Path, files: Iterable[Path]) -> None:
        self.path = path
        self._files = frozenset((path, *files))
        self._seen = self._looked_at = self._signature()
        self._taken = self._content()

    def look(self, asked: bool) -> Finding | None:
        """What has come of the files since the last call; None: nothing that is new.

        A change counts once two looks have found the same, for editors write in pieces. Asked for, the files are
        checked in any case.
        """
        signature = self._signature()
        settled, self._seen = signature == self._seen, signature
        if not asked and (not settled or signature == self._looked_at):
            return None
        self._looked_at = signature
        problems = tuple(self.problems())
        if not asked and not problems and self._content() == self._taken:
            return Finding.SAME
        return Finding(problems, at_once=asked)

    def problems(self) -> list[str]:
        """What is wrong with the files as they are now, a line each."""
        analysis = analyse(self.path)
        self._files = self._files.union(file.path for file in analysis.library.files)
        return [str(problem) for problem in analysis.errors]

    def take(self) -> None:
        """The files as they are now have been loaded."""
        self._taken = self._content()

    def _signature(self) -> tuple[tuple[str, int, int], ...]:
        """Of each file: name, time of the last change in ns, size; -1 where it is not there."""
        rows = []
        for file in sorted(self._files):
            try:
                stat = file.stat()
                rows.append((str(file), stat.st_mtime_ns, stat.st_size))
            except OSError:
                rows.append((str(file), -1, -1))
        return tuple(rows)

    def _content(self) -> dict[Path, bytes]:
        content = {}
        for file in self._files:
            try:
                content[file] = file.read_bytes()
            except OSError:
                continue
        return content


class HotReload:
    """`after_tick` belongs to the loop; all that takes time but loading itself happens in a thread."""

    def __init__(
        self,
        mission: LoadedMission,
        core: NavCore,
        on_swap: Callable[[Behaviour], None],
        mode: ReloadMode = ReloadMode.STILL,
        period_s: float = PERIOD_S,
    ) -> None:
        self.checker = MissionChecker(mission.path, mission.files)
        self.swaps = 0
        self._core, self._on_swap, self._mode, self._period_s = core, on_swap, mode, period_s
        self._still_since_s: float | None = None
        self._ready: Finding | None = None
        self._asked = False
        self._other: Path | None = None
        self._notice = ""
        self._closed = False
        self._wake = threading.Event()
        self._thread = threading.Thread(target=self._run, name="hot reload", daemon=True)
        self._thread.start()

    def load(self, path: Path) -> None:
        """Check another mission, in a moment, and take it in place of the present one; the operator is told."""
        self._other = path
        self._wake.set()

    def after_tick(self, record: TickRecord) -> None:
        """Swap in what is ready, if now is the time."""
        if self._core.take_reload():
            self._asked = True
            self._wake.set()
        if name := self._core.operator.take_load():
            self.load(mission_path(name))
        notice, self._notice = self._notice, ""
        if notice:
            self._core.operator.tell(notice)
        stands = record.requested == STOP and record.sent == STOP
        if not stands:
            self._still_since_s = None
        elif self._still_since_s is None:
            self._still_since_s = record.now_s
        ready = self._ready
        if ready is None:
            return
        long_enough = self._still_since_s is not None and record.now_s - self._still_since_s >= STILL_S
        if ready.at_once or (self._mode is ReloadMode.STILL and long_enough):
            self._ready = None
            self._swap(ready.checker or self.checker)

    def close(self) -> None:
        self._closed = True
        self._wake.set()
        self._thread.join(timeout=2.0)

    def _swap(self, checker: MissionChecker) -> None:
        try:
            mission = replace_mission(checker.path, self._core.root, self._take_over)
        except MissionError as error:
            # it was right a moment ago
            log.error("%s has errors and is not taken; the present mission stays\n%s", checker.path, error)
            return
        self.checker = checker
        checker.take()
        self.swaps += 1
        log.info("mission %s loaded anew from %s; it waits for GO", mission.main_tree, mission.path)

    def _take_over(self, mission: LoadedMission) -> None:
        self._core.replace_tree(mission.root)
        self._core.mission_name = mission.path.stem
        self._core.operator.tell(f"mission {mission.path.stem} loaded; it waits for GO")
        self._on_swap(mission.root)

    def _run(self) -> None:
        while not self._closed:
            self._wake.wait(self._period_s)
            self._wake.clear()
            if self._closed:
                return
            asked, self._asked = self._asked, False
            other, self._other = self._other, None
            try:
                if other is not None:
                    self._check_other(other)
                    continue
                found = self.checker.look(asked)
            except Exception:
                log.exception("the mission's files cannot be checked; the present mission stays")
                continue
            if found is not None:
                self._tell(found)
                self._ready = None if found.problems or found.same else found

    def _check_other(self, path: Path) -> None:
        candidate = MissionChecker(path, ())
        problems = candidate.problems()
        if problems:
            log.error(
                "%s has errors and is not taken; the present mission stays\n%s", path, "\n".join(problems)
            )
            self._notice = f"{path.name} has errors, the present mission stays: {problems[0]}"
            return
        self._ready = Finding(at_once=True, checker=candidate)

    def _tell(self, found: Finding) -> None:
        path = self.checker.path
        if found.problems:
            lines = "\n".join(found.problems)
            log.error("%s has errors and is not taken; the present mission stays\n%s", path, lines)
        elif not found.same:
            waits = "" if found.at_once else "; it is taken when the robot has stood for a second"
            log.info("%s has changed and is right%s", path, waits)
