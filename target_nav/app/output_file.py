"""Files that a command writes: whole or not at all, and a clear word when it cannot be done."""

from __future__ import annotations

import contextlib
import os
import tempfile
from pathlib import Path

from target_nav.errors import TargetNavError


class OutputError(TargetNavError):
    """A file that cannot be written."""


def write_output(path: Path, content: str | bytes) -> None:
    """Writes a file, through a temporary one beside it, so that nobody ever reads half of it.

    Raises:
        OutputError: the folder is missing or may not be written to, or there is no room.
    """
    data = content.encode("utf-8") if isinstance(content, str) else content
    if path.is_dir():
        raise OutputError(f"{path}: is a folder; name a file in it")
    if not path.parent.is_dir():
        raise OutputError(f"{path}: there is no folder {path.parent}; make it first")
    if path.exists() and not path.is_file():
        # a pipe or a device is written to as it is
        _direct(path, data)
        return
    try:
        _replace(path, data)
    except OSError as error:
        raise OutputError(f"{path}: cannot be written: {error.strerror or error}") from None


def _direct(path: Path, data: bytes) -> None:
    try:
        path.write_bytes(data)
    except OSError as error:
        raise OutputError(f"{path}: cannot be written: {error.strerror or error}") from None


def _replace(path: Path, data: bytes) -> None:
    # a link is written through, not replaced; an existing file keeps its mode
    target = Path(os.path.realpath(path))
    mode = target.stat().st_mode & 0o777 if target.exists() else 0o666 & ~_umask()
    handle, name = tempfile.mkstemp(prefix=f".{target.name}.", dir=target.parent)
    try:
        with os.fdopen(handle, "wb") as stream:
            stream.write(data)
        os.chmod(name, mode)
        os.replace(name, target)
    except BaseException:
        with contextlib.suppress(OSError):
            os.unlink(name)
        raise


def _umask() -> int:
    value = os.umask(0)
    os.umask(value)
    return value
