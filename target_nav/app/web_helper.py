"""The console's helper process: checks missions and reads recordings, a line of JSON for each question.

Beside the server and not in it: the checker and a recording take memory and seconds, and a mission file is whatever
somebody typed. Ends when its standard input does.
"""

from __future__ import annotations

import contextlib
import json
import os
import shutil
import sys
import tempfile
from collections import OrderedDict
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np

from target_nav.config import Config
from target_nav.errors import ConfigError, TargetNavError
from target_nav.mission.problems import Problem
from target_nav.state.types import TargetSpec
from target_nav.web.encode import flat_points
from target_nav.web.mission_files import SUFFIXES, MissionFolder
from target_nav.web.recorded import TreeNode, frames, nodes_of_paths
from target_nav.web.timeline import Timeline

NICE = 10
RECORDINGS_KEPT = 2
MOST_FRAMES, MOST_BYTES = 40_000, 48_000_000
MOST_PATH_POINTS = 2000


def check(folder: str, name: str, text: str) -> list[dict[str, Any]]:
    """What is wrong with `text` as the file `name` of `folder`, without saving it.

    A file that missions include is looked at as they use it: alone, all that it is handed would be missing.
    """
    from target_nav.app.commands.check import problems_of

    source = MissionFolder(Path(folder))
    with tempfile.TemporaryDirectory(prefix="target_nav_check_") as scratch:
        copy = Path(scratch).resolve()
        for each in source.names():
            target = copy / each
            target.parent.mkdir(parents=True, exist_ok=True)
            shutil.copyfile(source.folder / each, target)
        edited = copy / name
        edited.parent.mkdir(parents=True, exist_ok=True)
        edited.write_bytes(text.encode())
        files = [edited, *_includers(copy, edited)]
        found: dict[Problem, None] = {}
        for file in files[1:] or files:
            found.update(dict.fromkeys(problems_of(file)))
        return [_told(problem, copy) for problem in found if not _elsewhere(problem, copy, edited)]


def _includers(folder: Path, edited: Path) -> list[Path]:
    """Missions at the top of the folder that include the file."""
    from target_nav.mission.check import analyse

    found = []
    for path in sorted(p for p in folder.iterdir() if p.suffix in SUFFIXES and p != edited):
        if any(file.path == edited for file in analyse(path).library.files):
            found.append(path)
    return found


def _elsewhere(problem: Problem, folder: Path, edited: Path) -> bool:
    """A warning of another file is that file's business; an error may be this one's fault."""
    return problem.severity != "error" and Path(problem.file) != edited


def _told(problem: Problem, folder: Path) -> dict[str, Any]:
    place = Path(problem.file)
    shown = place.relative_to(folder).as_posix() if place.is_relative_to(folder) else problem.file
    return {
        "file": shown,
        "line": problem.line,
        "column": problem.column,
        "severity": problem.severity,
        "message": problem.message.replace(f"{folder}/", ""),
    }


class Recordings:
    """The last few recordings that were opened, each as a timeline."""

    def __init__(self) -> None:
        self._open: OrderedDict[tuple[str, int], Timeline] = OrderedDict()
        self._told: dict[tuple[str, int], dict[str, Any]] = {}

    def open(self, path: str) -> dict[str, Any]:
        """Marks of all frames, the path driven, the mission's name."""
        key = _key(path)
        if key not in self._open:
            self._read(key, Path(path))
        self._open.move_to_end(key)
        return self._told[key]

    def frame(self, path: str, number: int) -> str:
        key = _key(path)
        if key not in self._open:
            self._read(key, Path(path))
        frame = self._open[key].frame(number)
        if frame is None:
            raise ConfigError(f"frame {number} is not in the recording")
        return frame

    def _read(self, key: tuple[str, int], path: Path) -> None:
        from target_nav.app.extras import require_extra

        require_extra("mcap", "sim")
        from target_nav.app.recording import read_run

        header, ticks = read_run(path)
        config = Config().override(header.config, source=str(path))
        mission = Path(header.mission).stem
        timeline = Timeline(MOST_FRAMES, MOST_BYTES)
        poses = []
        for frame in frames(config, mission, _nodes(path), TargetSpec(), ticks):
            timeline.add(frame.mark, frame.text)
            poses.append((frame.pose.x_m, frame.pose.y_m))
        points = np.array(poses[:: len(poses) // MOST_PATH_POINTS + 1] or np.empty((0, 2)), dtype=np.float64)
        while len(self._open) >= RECORDINGS_KEPT:
            self._told.pop(self._open.popitem(last=False)[0])
        self._open[key] = timeline
        self._told[key] = {
            "mission": mission,
            "begin": timeline.begin,
            "end": timeline.end,
            "marks": timeline.marks(0),
            "path_m": flat_points(points),
        }


def _nodes(path: Path) -> list[TreeNode]:
    """The mission's tree as it was recorded; by its statuses' paths when it cannot be loaded any more."""
    from target_nav.app.recording import read_run
    from target_nav.app.tree_probe import TreeProbe
    from target_nav.mission import load_mission

    header, ticks = read_run(path)
    with tempfile.TemporaryDirectory(prefix="target_nav_recording_") as scratch:
        folder = Path(scratch).resolve()
        for name, content in header.files.items():
            file = (folder / name).resolve()
            if not file.is_relative_to(folder):
                raise TargetNavError(f"the recording names a file outside of its folder: {name!r}")
            file.parent.mkdir(parents=True, exist_ok=True)
            file.write_text(content, encoding="utf-8")
        try:
            root = load_mission(folder / header.mission).root
        except TargetNavError:
            return nodes_of_paths(name for _, decision in ticks for name in decision["statuses"])
    return [
        TreeNode(at, node.name, type(node).__name__, _depth(node)) for node, at in TreeProbe(root).layout()
    ]


def _depth(node: Any) -> int:
    depth = 0
    while (node := node.parent) is not None:
        depth += 1
    return depth


def _key(path: str) -> tuple[str, int]:
    return path, os.stat(path).st_mtime_ns


def main() -> None:
    os.nice(NICE)
    # whatever prints must not get between the answers
    answers, sys.stdout = sys.stdout, sys.stderr
    recordings = Recordings()
    questions: dict[str, Callable[..., Any]] = {
        "check": check,
        "open": recordings.open,
        "frame": recordings.frame,
    }
    with contextlib.suppress(KeyboardInterrupt, BrokenPipeError):
        for line in sys.stdin:
            question = json.loads(line)
            try:
                answer = {"value": questions[question.pop("what")](**question)}
            except TargetNavError as error:
                answer = {"error": str(error)}
            except Exception as error:
                answer = {"error": f"{type(error).__name__}: {error}"}
            print(json.dumps(answer), file=answers, flush=True)


if __name__ == "__main__":
    main()
