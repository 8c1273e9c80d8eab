"""The mission files a person may read and change: those of the missions' folders, and nothing outside of them."""

from __future__ import annotations

import hashlib
import os
import re
import stat
import tempfile
from dataclasses import dataclass
from pathlib import Path

from target_nav.errors import MissionError

SUFFIXES = (".xml", ".yaml", ".yml")
MOST_BYTES = 1_000_000
MOST_FILES = 500
_PART = re.compile(r"[A-Za-z0-9_][A-Za-z0-9_ .-]{0,99}")
_NOT_MISSIONS = frozenset({"scenarios"})
"""Folders of files that look like missions and are none."""


@dataclass(frozen=True)
class MissionText:
    """A file as it was read. `version` tells whether it has changed since."""

    name: str
    text: str
    version: str


class MissionFolder:
    """`name` is a path inside the folder, with slashes: `bowling_pin.xml`, `subtrees/find.xml`."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder.resolve()

    @property
    def writable(self) -> bool:
        return os.access(self.folder, os.W_OK)

    def names(self) -> list[str]:
        """Missions first, then what they include."""
        found = []
        for path in sorted(self.folder.rglob("*")):
            parts = path.relative_to(self.folder).parts
            named = path.suffix in SUFFIXES and all(_PART.fullmatch(part) for part in parts)
            if named and not _NOT_MISSIONS & set(parts) and path.is_file() and not path.is_symlink():
                found.append("/".join(parts))
            if len(found) >= MOST_FILES:
                break
        return sorted(found, key=lambda name: (name.count("/"), name))

    def read(self, name: str) -> MissionText:
        """
        Raises:
            MissionError: a name that leads out of the folder, or a file that cannot be read.
        """
        path = self.path_of(name)
        try:
            descriptor = os.open(path, os.O_RDONLY | os.O_CLOEXEC | os.O_NOFOLLOW | os.O_NONBLOCK)
            with open(descriptor, "rb") as file:
                if not stat.S_ISREG(os.fstat(descriptor).st_mode):
                    raise MissionError(f"{name}: is no file")
                data = file.read(MOST_BYTES + 1)
        except OSError as error:
            raise MissionError(f"{name}: cannot be read: {error.strerror}") from error
        _refuse_large(name, len(data))
        try:
            return MissionText(name, data.decode(), _version(data))
        except UnicodeDecodeError as error:
            raise MissionError(f"{name}: is not UTF-8 text: {error.reason} at byte {error.start}") from error

    def save(self, name: str, text: str, version: str | None) -> MissionText:
        """Whole or not at all. `version` is that of the file which was read; None: there must be none yet.

        Raises:
            MissionError: a name that leads out of the folder, a file that has changed since, or a folder that refuses.
        """
        path, data = self.path_of(name), text.encode()
        _refuse_large(name, len(data))
        there = self.read(name).version if os.path.lexists(path) else None
        if there != version:
            raise MissionError(
                f"{name}: "
                + (
                    "exists already; open it first"
                    if version is None
                    else "has changed on disk since it was opened"
                )
            )
        try:
            with tempfile.NamedTemporaryFile(
                "wb", dir=path.parent, prefix=f".{path.name}.", suffix=".new", delete=False
            ) as file:
                file.write(data)
                file.flush()
                os.fsync(file.fileno())
            os.chmod(file.name, stat.S_IMODE(path.stat().st_mode) if there is not None else 0o644)
            os.replace(file.name, path)
        except OSError as error:
            raise MissionError(f"{name}: cannot be written: {error.strerror}") from error
        return MissionText(name, text, _version(data))

    def path_of(self, name: str) -> Path:
        """
        Raises:
            MissionError: not the name of a mission file inside the folder; symbolic links do not lead out either.
        """
        parts = name.split("/")
        if len(name) > 300 or not all(_PART.fullmatch(part) for part in parts):
            raise MissionError(
                f"{name[:300]!r}: is no name of a mission file; letters, digits, '_', '-', '.' and folders by '/'"
            )
        if Path(name).suffix not in SUFFIXES:
            raise MissionError(f"{name}: a mission file ends in {', '.join(SUFFIXES)}")
        path = self.folder.joinpath(*parts)
        if not path.parent.is_dir() or path.parent.resolve() != path.parent or path.is_symlink():
            raise MissionError(f"{name}: its folder is not in {self.folder}")
        return path


def _version(data: bytes) -> str:
    return hashlib.sha256(data).hexdigest()[:16]


def _refuse_large(name: str, size: int) -> None:
    if size > MOST_BYTES:
        raise MissionError(f"{name}: {size} bytes; a mission file has {MOST_BYTES} at most")
