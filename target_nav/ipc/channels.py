"""Every channel by name, and how to open it: the only module of `ipc` that other packages import.

    with channels.open_writer(channels.DET, prefix="v2n") as writer:
        writer.write(frame)

    reader = channels.open_reader(channels.DET, prefix="v2n")
    frame, age_s = reader.latest(), reader.age_s(now_s)

The file is `/dev/shm/<prefix>_<name>`. A reader may be opened long before its writer.
"""

from __future__ import annotations

import time
from dataclasses import dataclass
from typing import Any, Generic, TypeVar, overload

from target_nav.config import IpcConfig
from target_nav.ipc import files
from target_nav.ipc.camera import CameraReader
from target_nav.ipc.codecs import MAX_DETECTIONS, Codec, ImageCodec, ItemsCodec, PlainCodec, PointsCodec
from target_nav.ipc.files import path_of
from target_nav.ipc.header import Geometry
from target_nav.ipc.ring import ACK_CODEC, COMMAND_CODEC, RING_SLOTS, CommandAck, CommandReader, CommandWriter
from target_nav.ipc.seqlock import SLOTS, Reader, Writer
from target_nav.ipc.status import ChannelStatus, describe_file
from target_nav.state.snapshots import (
    AvoidSnapshot,
    Calibration,
    CameraFrame,
    LaserSnapshot,
    NavSnapshot,
    ProcessRow,
    ProcessTable,
    TreeRow,
    TreeState,
)
from target_nav.state.types import Detection, DetectionFrame, RawDetection, RawDetectionFrame

T = TypeVar("T")

MAX_TREE_ROWS = 256
MAX_PROCESSES = 24

DEFAULT_PREFIX = IpcConfig().prefix


@dataclass(frozen=True)
class Channel(Generic[T]):
    """A newest-value channel and the layout of what it carries."""

    name: str
    codec: Codec[T]
    slot_count: int = SLOTS

    @property
    def geometry(self) -> Geometry:
        return Geometry(self.codec.layout, self.slot_count)


@dataclass(frozen=True)
class CameraChannel(Channel[CameraFrame]):
    """A channel of pictures; its reader can copy into a buffer of the caller's."""

    codec: ImageCodec


_IMAGES = ImageCodec()

CAMERA = CameraChannel("camera", _IMAGES)
SIM_CAMERA = CameraChannel("sim_camera", _IMAGES)
DETECTIONS = Channel("detections", ItemsCodec(RawDetectionFrame, "detections", RawDetection, MAX_DETECTIONS))
CALIBRATION = Channel("calibration", PlainCodec(Calibration))
DET = Channel("det", ItemsCodec(DetectionFrame, "detections", Detection, MAX_DETECTIONS))
NAV = Channel("nav", PlainCodec(NavSnapshot))
LASER = Channel("laser", PointsCodec(LaserSnapshot))
AVOID = Channel("avoid", PointsCodec(AvoidSnapshot))
TREE = Channel("tree", ItemsCodec(TreeState, "rows", TreeRow, MAX_TREE_ROWS))
PROCESSES = Channel("processes", ItemsCodec(ProcessTable, "rows", ProcessRow, MAX_PROCESSES))

"""`avoid` and `tree` come from the nav process at 10 Hz, `processes` from the supervisor: for people only."""

COMMAND_NAME = "cmd"
COMMAND_ACK_NAME = "cmd_ack"

NEWEST_VALUE: tuple[Channel[Any], ...] = (
    CAMERA,
    SIM_CAMERA,
    DETECTIONS,
    CALIBRATION,
    DET,
    NAV,
    LASER,
    AVOID,
    TREE,
    PROCESSES,
)
ALL: tuple[Channel[Any], ...] = (
    *NEWEST_VALUE,
    Channel(COMMAND_NAME, COMMAND_CODEC, RING_SLOTS),
    Channel(COMMAND_ACK_NAME, ACK_CODEC),
)
"""With the command ring's two files, which `open_writer` and `open_reader` are not for."""


def open_writer(channel: Channel[T], prefix: str = DEFAULT_PREFIX) -> Writer[T]:
    """Claims the channel until `close`, or until this process dies.

    Raises:
        DeviceError: another live process writes it, or /dev/shm refuses.
        ConfigError: a prefix that cannot be used.
    """
    _refuse_ring(channel)
    return Writer(path_of(prefix, channel.name), channel.codec, channel.slot_count)


@overload
def open_reader(channel: CameraChannel, prefix: str = DEFAULT_PREFIX) -> CameraReader: ...
@overload
def open_reader(channel: Channel[T], prefix: str = DEFAULT_PREFIX) -> Reader[T]: ...
def open_reader(channel: Channel[Any], prefix: str = DEFAULT_PREFIX) -> Reader[Any]:
    """A reader of its own cursor and statistics; there may be many. The channel need not exist yet."""
    _refuse_ring(channel)
    path = path_of(prefix, channel.name)
    if isinstance(channel, CameraChannel):
        return CameraReader(path, channel.codec, channel.slot_count)
    return Reader(path, channel.codec, channel.slot_count)


def open_command_writer(prefix: str = DEFAULT_PREFIX) -> CommandWriter:
    """Raises DeviceError if another live process has it open: operators take turns."""
    return CommandWriter(path_of(prefix, COMMAND_NAME), path_of(prefix, COMMAND_ACK_NAME))


def open_command_reader(prefix: str = DEFAULT_PREFIX) -> CommandReader:
    """Raises DeviceError if another live process reads the commands of this prefix."""
    return CommandReader(path_of(prefix, COMMAND_NAME), path_of(prefix, COMMAND_ACK_NAME))


def open_command_ack_reader(prefix: str = DEFAULT_PREFIX) -> Reader[CommandAck]:
    """How far the nav process has read the commands; against `CommandWriter.last_sequence`."""
    return Reader(path_of(prefix, COMMAND_ACK_NAME), ACK_CODEC)


def describe(prefix: str = DEFAULT_PREFIX, now_s: float | None = None) -> list[ChannelStatus]:
    """Every channel of a prefix, there or not: who writes it, is he alive, how old is the newest value."""
    now_s = time.monotonic() if now_s is None else now_s
    return [
        describe_file(
            channel.name, path_of(prefix, channel.name), channel.geometry, channel.codec.bulk_from, now_s
        )
        for channel in ALL
    ]


def remove(prefix: str = DEFAULT_PREFIX) -> list[str]:
    """Removes this prefix's files that no live process writes, and returns their names."""
    paths = [path_of(prefix, channel.name) for channel in ALL]
    return [path.name for path in paths if files.remove_unclaimed(path)]


def _refuse_ring(channel: Channel[Any]) -> None:
    if channel.name in (COMMAND_NAME, COMMAND_ACK_NAME):
        raise TypeError(f"{channel.name} is the command ring; use open_command_writer or open_command_reader")
