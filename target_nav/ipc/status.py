"""What can be told of a channel from outside, whatever state it is in: for `target-nav doctor` and `status`."""

from __future__ import annotations

import math
import os
import struct
from dataclasses import dataclass
from pathlib import Path

from target_nav.errors import DeviceError
from target_nav.ipc import files, header, slots
from target_nav.ipc.header import LAYOUT_VERSION, LOW, Geometry
from target_nav.ipc.slots import PAYLOAD_IN_DATA, Loaded


@dataclass(frozen=True)
class ChannelStatus:
    """One file. `problem` is empty or says what is wrong and what to do about it."""

    name: str
    path: str
    exists: bool
    writer_pid: int | None = None
    """The last writer's; see `alive`."""
    alive: bool = False
    """That writer, or at least some process, holds the channel now."""
    version: int | None = None
    compatible: bool = False
    age_s: float = math.inf
    sequence: int = 0
    """Values written in this writer's reign."""
    size_bytes: int = 0
    problem: str = ""


def describe_file(
    name: str, path: Path, geometry: Geometry, bulk_from: int | None, now_s: float
) -> ChannelStatus:
    """Reads the header and the newest value's stamp; claims nothing, changes nothing, raises nothing."""
    alive = files.is_claimed(path)
    try:
        descriptor = os.open(path, os.O_RDONLY | os.O_CLOEXEC)
    except FileNotFoundError:
        return ChannelStatus(
            name, str(path), exists=False, problem="nobody has written it yet; is its writer running?"
        )
    except OSError as error:
        return ChannelStatus(
            name, str(path), exists=True, problem=f"{error.strerror}; run as the user who owns it"
        )
    try:
        identity, size = files.identify(descriptor), os.fstat(descriptor).st_size
    except OSError as error:
        return ChannelStatus(name, str(path), exists=True, problem=f"{error.strerror}; remove it")
    finally:
        os.close(descriptor)
    if identity.foreign:
        return ChannelStatus(
            name,
            str(path),
            True,
            alive=alive,
            size_bytes=size,
            problem="not a channel of target_nav; remove it",
        )
    if identity.blank:
        return ChannelStatus(
            name, str(path), True, alive=alive, size_bytes=size, problem="empty: its maker died early"
        )
    pid, version = identity.writer_pid, identity.layout_version
    if not identity.fits(geometry):
        problem = (
            f"layout version {version} (hash {identity.layout_hash:08x}), this program has {LAYOUT_VERSION} "
            f"(hash {geometry.layout_hash:08x}); "
            + ("restart its writer" if alive else "its next writer replaces it")
        )
        return ChannelStatus(name, str(path), True, pid, alive, version, size_bytes=size, problem=problem)
    sequence, age_s = _newest(path, geometry, bulk_from, now_s)
    problem = "" if alive else f"its writer (pid {pid}) has gone; what stands there is its last word"
    return ChannelStatus(name, str(path), True, pid, alive, version, True, age_s, sequence, size, problem)


def _newest(path: Path, geometry: Geometry, bulk_from: int | None, now_s: float) -> tuple[int, float]:
    """(values written in this reign, age of the newest)."""
    try:
        mapping = files.open_for_reading(path, geometry)
    except DeviceError:
        return 0, math.inf
    if mapping is None:
        return 0, math.inf
    try:
        reign = slots.stable_reign(mapping)
        low = mapping.words[header.PUBLISHED]
        written = (low - reign[0] + 1) & LOW if reign is not None else 0
        if written == 0:
            return 0, math.inf
        for _ in range(16):
            low = mapping.words[header.PUBLISHED]
            loaded = slots.load(mapping, low & (geometry.slot_count - 1), low, bulk_from)
            if isinstance(loaded, Loaded):
                (stamp_s,) = struct.unpack_from("<d", loaded.data, PAYLOAD_IN_DATA)
                age_s = now_s - stamp_s
                return written, age_s if math.isfinite(age_s) else math.inf
        return written, math.inf
    finally:
        mapping.close()
