"""From one file to everything it includes: each file once, none from outside the mission's folder.

A path is relative to the file that includes it. With `ros_pkg` it is relative to that package's share folder, and
then that folder is the one not to be left.
"""

from __future__ import annotations

import importlib
import os
from dataclasses import dataclass, field
from pathlib import Path

from target_nav.mission.document import read_document
from target_nav.mission.model import IncludeDef, MissionFile, NodeModel, TreeDef
from target_nav.mission.notations import parse_mission_file
from target_nav.mission.problems import Position, Report, did_you_mean, listed

MAX_FILES = 100


@dataclass
class Library:
    """Everything a mission can refer to. `main_tree` is None when it could not be told which tree is the main one."""

    files: list[MissionFile] = field(default_factory=list)
    trees: dict[str, TreeDef] = field(default_factory=dict)
    models: dict[tuple[str, str], NodeModel] = field(default_factory=dict)
    main_tree: str | None = None
    complete: bool = True
    """False when a file could not be read: what is missing may then be in it."""


@dataclass(frozen=True)
class _Source:
    """A file to be read: where it is, how messages call it, and the folder its includes may not leave."""

    path: Path
    shown: str
    inside: Path


def load_library(path: Path, library: Library, report: Report, main_tree: str | None = None) -> None:
    """Reads `path` and what it includes into `library`, which is empty. `main_tree` instead of what the file says."""
    try:
        resolved = Path(os.path.realpath(path))
    except (OSError, ValueError) as error:
        report.error(Position(str(path)), f"cannot be read: {error}")
        library.complete = False
        return
    _Includer(library, report).read(_Source(resolved, str(path), resolved.parent), ())
    _find_main_tree(library, report, main_tree)


class _Includer:
    def __init__(self, library: Library, report: Report) -> None:
        self._library = library
        self._report = report
        self._seen: set[Path] = set()

    def read(self, source: _Source, chain: tuple[_Source, ...]) -> None:
        self._seen.add(source.path)
        root = parse_mission_file(source.path, source.shown, self._report)
        if root is None:
            self._library.complete = False
            return
        document = read_document(root, source.path, source.shown, self._report)
        self._library.files.append(document)
        self._collect(document)
        chain = (*chain, source)
        for include in document.includes:
            found = self._locate(include, source)
            if found is None:
                self._library.complete = False
                continue
            if any(found.path == opened.path for opened in chain):
                names = [each.path.name for each in chain[[each.path for each in chain].index(found.path) :]]
                self._report.error(
                    include.path.position, f"includes in a circle: {' > '.join([*names, names[0]])}"
                )
            elif found.path not in self._seen:
                if len(self._seen) >= MAX_FILES:
                    self._report.error(include.path.position, f"more than {MAX_FILES} files in one mission")
                    return
                self.read(found, chain)

    def _collect(self, document: MissionFile) -> None:
        for tree in document.trees:
            first = self._library.trees.setdefault(tree.id, tree)
            if first is not tree:
                self._report.error(
                    tree.position, f'a second tree "{tree.id}"; the first is at {first.position}'
                )
        for model in document.models:
            self._library.models.setdefault((model.form.value, model.id), model)

    def _locate(self, include: IncludeDef, source: _Source) -> _Source | None:
        at, text = include.path.position, include.path.value
        if os.path.isabs(text):
            self._report.error(
                at, f'path is "{text}"; it must be relative to this file, or to a package with ros_pkg'
            )
            return None
        if include.ros_pkg is None:
            folder, inside, whose = source.path.parent, source.inside, "the mission's folder"
            shown = os.path.normpath(os.path.join(os.path.dirname(source.shown), text))
        else:
            share = self._share_folder(include.ros_pkg.value, include)
            if share is None:
                return None
            folder = inside = share
            whose, shown = f"the share folder of {include.ros_pkg.value}", str(share / text)
        try:
            target = Path(os.path.realpath(folder / text))
        except (OSError, ValueError) as error:
            self._report.error(at, f"path cannot be used: {error}")
            return None
        if not target.is_relative_to(inside):
            self._report.error(at, f'path is "{text}"; it leads out of {whose}, and may not')
            return None
        try:
            there = target.is_file()
        except (OSError, ValueError):
            there = False
        if not there:
            self._report.error(at, f'path is "{text}"; there is no file {shown}')
            return None
        return _Source(target, shown, inside)

    def _share_folder(self, package: str, include: IncludeDef) -> Path | None:
        at = include.ros_pkg.position if include.ros_pkg else include.position
        try:
            index = importlib.import_module("ament_index_python.packages")
        except ImportError:
            self._report.error(
                at,
                f'ros_pkg is "{package}", but there is no ROS 2 here (ament_index_python); use a relative path',
            )
            return None
        try:
            return Path(os.path.realpath(index.get_package_share_directory(package)))
        except Exception as error:
            # The index raises LookupError, ValueError or its own kinds, by version and by what is wrong.
            self._report.error(at, f'ros_pkg is "{package}"; {error}; is its workspace sourced?')
            return None


def _find_main_tree(library: Library, report: Report, wanted: str | None) -> None:
    if not library.files:
        return
    main = library.files[0]
    known = listed(library.trees)
    if wanted is not None:
        library.main_tree = wanted if wanted in library.trees else None
        if library.main_tree is None and library.complete:
            near = did_you_mean(wanted, library.trees)
            report.error(main.position, f'there is no tree "{wanted}"{near}; the trees are: {known}')
    elif main.main_tree is not None:
        name = main.main_tree.value
        if name in library.trees:
            library.main_tree = name
        elif library.complete:
            near = did_you_mean(name, library.trees)
            report.error(main.main_tree.position, f'there is no tree "{name}"{near}; the trees are: {known}')
    elif len(library.trees) == 1:
        library.main_tree = next(iter(library.trees))
    elif library.trees:
        report.error(main.position, f"main_tree_to_execute is missing in <root>; the trees are: {known}")
    elif not report.has_errors:
        report.error(main.position, "there is no <BehaviorTree> in it")
