"""A run on disk: what every tick saw and what it decided, as an MCAP file with JSON messages.

MCAP because Foxglove and the `mcap` command open it; JSON because Python's floats survive it to the last bit, so a
replay can be compared exactly. Encoding and compression happen in a thread of their own: a tick only hands over frozen
values.
"""

from __future__ import annotations

import json
import math
import queue
import threading
from collections.abc import Iterator
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import IO, Any

import numpy as np
from mcap.exceptions import McapError
from mcap.records import Attachment, Channel, Message, Metadata
from mcap.stream_reader import StreamReader
from mcap.writer import CompressionType, Writer

from target_nav.config import Config
from target_nav.errors import TargetNavError
from target_nav.mission import LoadedMission
from target_nav.state.types import (
    Command,
    CommandKind,
    Detection,
    DetectionFrame,
    Facing,
    Inputs,
    Odometry,
    Pose2D,
    Scan,
    TickRecord,
    Twist2D,
)

INPUTS, DECISION = "/nav/inputs", "/nav/decision"
HEADER = "target_nav.run"
FORMAT_VERSION = "1"
CHUNK_BYTES = 64 * 1024
"""Small, so that a process that is killed loses little."""

_ANY_OBJECT = json.dumps({"type": "object"}).encode()


class RecordingError(TargetNavError):
    """A recording that cannot be written or read."""


@dataclass(frozen=True)
class RunHeader:
    """What a replay needs besides the ticks: the configuration as dotted keys and the mission's files."""

    config: dict[str, Any]
    mission: str
    files: dict[str, str]


def header_of(config: Config, mission: LoadedMission) -> RunHeader:
    """The header of a run: files are kept relative to the folder of the mission's main file."""
    folder = mission.path.resolve().parent
    files = {
        str(file.resolve().relative_to(folder)): file.read_text(encoding="utf-8") for file in mission.files
    }
    return RunHeader({key: value for key, value, _ in config.items()}, mission.path.name, files)


class RunRecorder:
    """Implements the nav core's `Recorder`. Use as a context manager, or call `close`."""

    def __init__(self, path: Path, header: RunHeader) -> None:
        self._queue: queue.Queue[tuple[Inputs, TickRecord] | None] = queue.Queue()
        self._stream: IO[bytes] = path.open("wb")
        self._writer = Writer(self._stream, chunk_size=CHUNK_BYTES, compression=CompressionType.ZSTD)
        self._writer.start(profile="", library="target_nav")
        schema = self._writer.register_schema("target_nav.Json", "jsonschema", _ANY_OBJECT)
        self._channels = {
            topic: self._writer.register_channel(topic, "json", schema) for topic in (INPUTS, DECISION)
        }
        self._writer.add_metadata(
            HEADER,
            {
                "version": FORMAT_VERSION,
                "config": json.dumps(header.config),
                "mission": header.mission,
                "files": json.dumps(header.files),
            },
        )
        self._encoder = _InputsEncoder()
        self._thread = threading.Thread(target=self._write_all, name="recorder", daemon=True)
        self._thread.start()

    def record(self, inputs: Inputs, record: TickRecord) -> None:
        self._queue.put((inputs, record))

    def close(self) -> None:
        if self._thread.is_alive():
            self._queue.put(None)
            self._thread.join()
        self._writer.finish()
        self._stream.close()

    def __enter__(self) -> RunRecorder:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def _write_all(self) -> None:
        while (item := self._queue.get()) is not None:
            inputs, record = item
            time_ns = round(inputs.now_s * 1e9)
            self._add(INPUTS, time_ns, self._encoder.encode(inputs))
            self._add(DECISION, time_ns, decision_of(record))

    def _add(self, topic: str, time_ns: int, data: dict[str, Any]) -> None:
        payload = json.dumps(data, separators=(",", ":")).encode()
        self._writer.add_message(self._channels[topic], time_ns, payload, time_ns)


def decision_of(record: TickRecord) -> dict[str, Any]:
    """What a replay must reproduce, as plain JSON values."""
    return {
        "now_s": record.now_s,
        "state": record.state.name,
        "leaf": record.running_leaf,
        "requested": list(asdict(record.requested).values()),
        "sent": list(asdict(record.sent).values()),
        "limited_by": record.limited_by,
        "track": [record.track.x_m, record.track.y_m, record.track.confirmed] if record.track else None,
        "outcome": record.outcome.kind.value if record.outcome else None,
        "reason": record.reason,
        "statuses": record.statuses,
    }


def read_run(path: Path) -> tuple[RunHeader, Iterator[tuple[Inputs, dict[str, Any]]]]:
    """The header, and (inputs, decision) of each tick; a recording that was cut off ends where it was cut.

    Raises:
        RecordingError: no such file, or not a recording of ours.
    """
    if not path.is_file():
        raise RecordingError(f"{path}: there is no such recording")
    records = _records(path)
    for record in records:
        if isinstance(record, Metadata) and record.name == HEADER:
            data = record.metadata
            if data.get("version") != FORMAT_VERSION:
                raise RecordingError(
                    f"{path}: format version {data.get('version')}, this program reads {FORMAT_VERSION}"
                )
            header = RunHeader(json.loads(data["config"]), data["mission"], json.loads(data["files"]))
            return header, _ticks(records)
        if isinstance(record, Message):
            break
    raise RecordingError(f"{path}: not a recording made by target_nav (no {HEADER!r} record)")


def _records(path: Path) -> Iterator[Any]:
    with path.open("rb") as stream:
        try:
            yield from StreamReader(stream).records
        except (McapError, EOFError, ValueError):
            # a file without its end: what came before is good
            return


def _ticks(records: Iterator[Any]) -> Iterator[tuple[Inputs, dict[str, Any]]]:
    topics: dict[int, str] = {}
    decoder = _InputsDecoder()
    waiting: Inputs | None = None
    for record in records:
        if isinstance(record, Channel):
            topics[record.id] = record.topic
        elif isinstance(record, Message):
            data = json.loads(record.data)
            if topics.get(record.channel_id) == INPUTS:
                waiting = decoder.decode(data)
            elif waiting is not None:
                yield waiting, data
                waiting = None
        elif isinstance(record, Attachment):
            continue


class _InputsEncoder:
    """Writes a scan or a frame of detections once, when it is new."""

    def __init__(self) -> None:
        self._scan: Scan | None = None
        self._detections: DetectionFrame | None = None

    def encode(self, inputs: Inputs) -> dict[str, Any]:
        data: dict[str, Any] = {"now_s": inputs.now_s}
        if inputs.scan is not self._scan and inputs.scan is not None:
            self._scan = inputs.scan
            data["scan"] = {
                **vars(inputs.scan),
                "ranges_m": [_finite(r) for r in inputs.scan.ranges_m.tolist()],
            }
        if inputs.detections is not self._detections and inputs.detections is not None:
            self._detections = inputs.detections
            data["detections"] = asdict(inputs.detections)
        if inputs.odometry_since:
            data["odometry"] = [
                [o.stamp_s, *vars(o.pose_in_odom).values(), *vars(o.twist_in_base).values()]
                for o in inputs.odometry_since
            ]
        if inputs.commands:
            data["commands"] = [[c.stamp_s, c.kind.name, c.argument] for c in inputs.commands]
        return data


class _InputsDecoder:
    def __init__(self) -> None:
        self._scan: Scan | None = None
        self._detections: DetectionFrame | None = None
        self._odometry: Odometry | None = None

    def decode(self, data: dict[str, Any]) -> Inputs:
        if "scan" in data:
            fields = data["scan"]
            ranges = np.array([_number(r) for r in fields["ranges_m"]], dtype=np.float64)
            self._scan = Scan(**{**fields, "ranges_m": ranges})
        if "detections" in data:
            frame = data["detections"]
            detections = tuple(_detection(d) for d in frame["detections"])
            self._detections = DetectionFrame(frame["stamp_s"], frame["frame_id"], detections)
        since = tuple(Odometry(v[0], Pose2D(*v[1:4]), Twist2D(*v[4:7])) for v in data.get("odometry", ()))
        if since:
            self._odometry = since[-1]
        commands = tuple(Command(s, CommandKind[k], a) for s, k, a in data.get("commands", ()))
        return Inputs(data["now_s"], self._scan, self._odometry, since, self._detections, commands)


def _detection(fields: dict[str, Any]) -> Detection:
    facings = {
        name: Facing(**fields[name]) for name in ("facing", "other_facing") if fields.get(name) is not None
    }
    return Detection(**{**fields, **facings})


def _finite(value: float) -> float | str | None:
    """JSON has no infinity and no NaN."""
    if math.isfinite(value):
        return value
    return "nan" if math.isnan(value) else None if value > 0 else "-inf"


def _number(value: float | str | None) -> float:
    return math.inf if value is None else float(value)
