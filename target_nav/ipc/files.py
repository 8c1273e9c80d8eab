"""A channel's file in /dev/shm: made, claimed by one writer, opened by readers, never shrunk.

A writer holds `flock` on the file itself, which the kernel releases whenever it dies. A file of another layout is not
rewritten but replaced, so that a reader which still has the old one mapped sees a new inode instead of a moved floor.
"""

from __future__ import annotations

import errno
import fcntl
import mmap
import os
import re
import struct
import time
from dataclasses import dataclass
from pathlib import Path

from target_nav.errors import ConfigError, DeviceError
from target_nav.ipc import header
from target_nav.ipc.header import FILE_HEADER, LAYOUT_VERSION, MAGIC, Geometry

SHM_DIRECTORY = Path("/dev/shm")

CLAIM_PATIENCE_S = 0.1
"""How long a claim is tried: others hold the lock for microseconds to ask whether a writer lives."""

_READ_FLAGS = os.O_RDONLY | os.O_CLOEXEC | os.O_NOFOLLOW
_WRITE_FLAGS = os.O_RDWR | os.O_CLOEXEC | os.O_NOFOLLOW
_PREFIX = re.compile(r"[A-Za-z0-9][A-Za-z0-9_.-]{0,63}")
_IDENTITY = struct.Struct(FILE_HEADER.format("reserved"))


def path_of(prefix: str, channel: str) -> Path:
    """Raises ConfigError for a prefix that is no file name, or that would meet another prefix's channel."""
    if not _PREFIX.fullmatch(prefix) or prefix.endswith("_sim"):
        raise ConfigError(
            f"ipc.prefix is {prefix!r}; it must be 1 to 64 letters, digits, '_', '-' or '.', begin with a letter or "
            "digit and not end with '_sim' (its 'camera' would be another prefix's 'sim_camera')"
        )
    return SHM_DIRECTORY / f"{prefix}_{channel}"


@dataclass(frozen=True)
class Identity:
    """What a file says of itself."""

    magic: bytes
    layout_version: int
    layout_hash: int
    ready: int
    claim: int
    writer_pid: int
    generation: int
    slot_count: int
    slot_bytes: int
    payload_bytes: int
    layout_name: str

    @property
    def blank(self) -> bool:
        """Its maker has not finished it."""
        return self.ready == 0 and self.magic in (bytes(8), MAGIC)

    @property
    def foreign(self) -> bool:
        return self.magic != MAGIC and not self.blank

    def fits(self, geometry: Geometry) -> bool:
        return (self.magic, self.ready, self.layout_version, self.layout_hash) == (
            MAGIC,
            1,
            LAYOUT_VERSION,
            geometry.layout_hash,
        )


def identify(descriptor: int) -> Identity:
    raw = os.pread(descriptor, FILE_HEADER.size, 0).ljust(FILE_HEADER.size, b"\0")
    magic, version, hash_, ready, claim, pid, low, high, count, slot, payload, name = _IDENTITY.unpack_from(
        raw
    )
    text = name.split(b"\0", 1)[0].decode("ascii", "replace")
    return Identity(magic, version, hash_, ready, claim, pid, high << 32 | low, count, slot, payload, text)


class Mapping:
    """A mapped file: `view` its bytes, `words` the same as uint32. Owns the descriptor, and with it a writer's lock."""

    def __init__(self, path: Path, descriptor: int, geometry: Geometry, writable: bool) -> None:
        self.path, self.geometry, self._descriptor = path, geometry, descriptor
        self.inode = os.fstat(descriptor).st_ino
        self.map = mmap.mmap(
            descriptor, geometry.file_bytes, access=mmap.ACCESS_WRITE if writable else mmap.ACCESS_READ
        )
        self.view = memoryview(self.map)
        self.words = self.view.cast("I")
        self._reserved_bytes = 0

    @property
    def name(self) -> str:
        return self.path.name

    @property
    def removed(self) -> bool:
        """The file has no name any more, so no reader will find it."""
        return os.fstat(self._descriptor).st_nlink == 0

    def reserve(self, slot_bytes: int) -> None:
        """Takes memory for so many bytes of each slot: storing into a full /dev/shm is a SIGBUS, this is an error."""
        if slot_bytes <= self._reserved_bytes:
            return
        try:
            for index in range(self.geometry.slot_count):
                os.posix_fallocate(self._descriptor, self.geometry.slot_at(index), slot_bytes)
        except OSError as error:
            raise _explained(self.path, error, slot_bytes * self.geometry.slot_count) from error
        self._reserved_bytes = slot_bytes

    def close(self) -> None:
        """May be called twice. The map holds a duplicate of the descriptor, so the lock goes with both."""
        if self._descriptor < 0:
            return
        self.words.release()
        self.view.release()
        self.map.close()
        os.close(self._descriptor)
        self._descriptor = -1


def claim(path: Path, geometry: Geometry) -> Mapping:
    """The file, made or replaced if need be, locked for this writer. The header still has to be taken over.

    Raises:
        DeviceError: another live process holds it, it is no channel of ours, or the system refuses.
    """
    give_up_s = time.monotonic() + CLAIM_PATIENCE_S
    while True:
        try:
            descriptor = _open_or_create(path)
        except OSError as error:
            raise _explained(path, error, geometry.file_bytes) from error
        try:
            mapping = _try_claim(path, descriptor, geometry)
        except BaseException as error:
            pid = identify(descriptor).writer_pid
            os.close(descriptor)
            if isinstance(error, BlockingIOError):
                if time.monotonic() < give_up_s:
                    time.sleep(0.002)
                    continue
                raise DeviceError(
                    f"another instance (pid {pid or 'unknown'}) writes {path.name}; stop it or choose another prefix "
                    "(ipc.prefix)"
                ) from None
            if isinstance(error, OSError):
                raise _explained(path, error, geometry.file_bytes) from error
            raise
        if mapping is not None:
            return mapping
        os.close(descriptor)


def _try_claim(path: Path, descriptor: int, geometry: Geometry) -> Mapping | None:
    """None: the name meanwhile means another file; try again."""
    fcntl.flock(descriptor, fcntl.LOCK_EX | fcntl.LOCK_NB)
    if inode_of(path) != os.fstat(descriptor).st_ino:
        return None
    identity, size = identify(descriptor), os.fstat(descriptor).st_size
    if identity.foreign:
        raise _foreign(path)
    if identity.blank and size <= geometry.file_bytes:
        os.ftruncate(descriptor, geometry.file_bytes)
        os.posix_fallocate(descriptor, 0, FILE_HEADER.size)
        mapping = Mapping(path, descriptor, geometry, writable=True)
        _initialise(mapping)
        return mapping
    if identity.fits(geometry) and size == geometry.file_bytes:
        return Mapping(path, descriptor, geometry, writable=True)
    os.unlink(path)
    return None


def _initialise(mapping: Mapping) -> None:
    geometry = mapping.geometry
    raw = _IDENTITY.pack(
        *(MAGIC, LAYOUT_VERSION, geometry.layout_hash, 0, 0, os.getpid(), 0, 0),
        *(geometry.slot_count, geometry.slot_bytes, geometry.payload_bytes, geometry.layout.name.encode()),
    )
    mapping.view[: len(raw)] = raw
    mapping.words[header.READY] = 1


def open_for_reading(path: Path, geometry: Geometry) -> Mapping | None:
    """The file if it is there and finished.

    A file of another layout that nobody writes any more counts as not there: its successor will replace it.

    Raises:
        DeviceError: a live writer uses another layout, it is no channel of ours, or the system refuses.
    """
    descriptor = -1
    try:
        descriptor = os.open(path, _READ_FLAGS)
        identity, size = identify(descriptor), os.fstat(descriptor).st_size
        if identity.foreign:
            raise _foreign(path)
        if identity.fits(geometry) and size == geometry.file_bytes:
            mapping = Mapping(path, descriptor, geometry, writable=False)
            descriptor = -1
            return mapping
        if not identity.blank and _locked(descriptor):
            raise DeviceError(
                f"{path.name} has layout version {identity.layout_version} (hash {identity.layout_hash:08x}), this "
                f"program reads version {LAYOUT_VERSION} (hash {geometry.layout_hash:08x}); its writer (pid "
                f"{identity.writer_pid}) is of another build: stop it, and start both from the same one"
            )
        return None
    except FileNotFoundError:
        return None
    except OSError as error:
        raise _explained(path, error, geometry.file_bytes) from error
    finally:
        if descriptor >= 0:
            os.close(descriptor)


def inode_of(path: Path) -> int | None:
    try:
        return os.stat(path).st_ino
    except FileNotFoundError:
        return None


def is_claimed(path: Path) -> bool:
    """A live process writes this channel."""
    try:
        descriptor = os.open(path, _READ_FLAGS)
    except OSError:
        return False
    try:
        return _locked(descriptor)
    finally:
        os.close(descriptor)


def remove_unclaimed(path: Path) -> bool:
    """Unlinks a channel of ours that no live process writes; True if it did."""
    try:
        descriptor = os.open(path, _READ_FLAGS)
    except OSError:
        return False
    try:
        fcntl.flock(descriptor, fcntl.LOCK_EX | fcntl.LOCK_NB)
        if identify(descriptor).foreign or inode_of(path) != os.fstat(descriptor).st_ino:
            return False
        os.unlink(path)
        return True
    except BlockingIOError:
        return False
    finally:
        os.close(descriptor)


def _locked(descriptor: int) -> bool:
    try:
        fcntl.flock(descriptor, fcntl.LOCK_SH | fcntl.LOCK_NB)
    except BlockingIOError:
        return True
    fcntl.flock(descriptor, fcntl.LOCK_UN)
    return False


def _open_or_create(path: Path) -> int:
    # Not O_CREAT on a file that exists: in a sticky directory the kernel refuses that for another user's file.
    while True:
        try:
            return os.open(path, _WRITE_FLAGS)
        except FileNotFoundError:
            pass
        try:
            return os.open(path, _WRITE_FLAGS | os.O_CREAT | os.O_EXCL, 0o660)
        except FileExistsError:
            pass


def _foreign(path: Path) -> DeviceError:
    return DeviceError(
        f"{path} is not a channel of target_nav (no {MAGIC.decode()} at its beginning); remove it or choose another "
        "prefix (ipc.prefix)"
    )


def _explained(path: Path, error: OSError, wanted_bytes: int) -> DeviceError:
    advice = "is shared memory mounted at /dev/shm?"
    if error.errno in (errno.EACCES, errno.EPERM):
        advice = "it belongs to another user; run all processes as the same one, or remove it"
    elif error.errno in (errno.ENOSPC, errno.ENOMEM):
        free = os.statvfs(path.parent)
        advice = (
            f"{wanted_bytes / 1e6:.1f} MB wanted, {free.f_bavail * free.f_frsize / 1e6:.1f} MB free in {path.parent}; "
            "make it larger (Docker: --shm-size) or remove what is not needed there"
        )
    return DeviceError(f"{path}: {error.strerror}; {advice}")
