"""A ROS 2 bag on disk: one MCAP file with the messages as they were on the wire, and rosbag2's metadata.yaml.

`ros2 bag info`, `ros2 bag play` and Foxglove open it. Only the `mcap` library is needed, which the recording of runs
has already: messages stay serialized, so nothing here has to understand them. (`rosbags` writes bags too, with five
libraries more, SQLite among them; it reads them back in the tests.) A file that was cut off keeps its whole chunks:
`mcap recover` or `ros2 bag reindex` closes it.
"""

from __future__ import annotations

import os
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import yaml
from mcap.writer import CompressionType, Writer

from target_nav.app.message_definitions import Definition
from target_nav.errors import DeviceError

METADATA_VERSION = 9
"""Of metadata.yaml, as Jazzy writes it."""

CHUNK_BYTES = 256 * 1024


@dataclass(frozen=True)
class OfferedQos:
    """What one publisher offers, in rosbag2's words; playing back offers the same."""

    reliability: str
    durability: str
    history: str
    depth: int
    liveliness: str
    deadline_ns: int
    lifespan_ns: int
    liveliness_lease_ns: int

    def as_yaml(self) -> dict[str, Any]:
        return {
            "history": self.history,
            "depth": self.depth,
            "reliability": self.reliability,
            "durability": self.durability,
            "deadline": _time(self.deadline_ns),
            "lifespan": _time(self.lifespan_ns),
            "liveliness": self.liveliness,
            "liveliness_lease_duration": _time(self.liveliness_lease_ns),
            "avoid_ros_namespace_conventions": False,
        }


@dataclass
class _Topic:
    channel: int
    definition: Definition
    qos: tuple[OfferedQos, ...]
    count: int = 0


class BagWriter:
    """Writes one bag. Times are wall time in nanoseconds. Use as a context manager, or call `close`.

    Args:
        folder: made anew; the MCAP file and metadata.yaml go there.
        distribution: the ROS distribution, for metadata.yaml.

    Raises:
        DeviceError: the folder exists or cannot be made.
    """

    def __init__(self, folder: Path, distribution: str = "") -> None:
        try:
            folder.mkdir(parents=True)
        except FileExistsError as error:
            raise DeviceError(
                f"{folder} exists; a bag gets a folder of its own: choose another --output"
            ) from error
        except OSError as error:
            raise DeviceError(f"the bag's folder {folder} cannot be made: {error.strerror}") from error
        self.folder = folder
        self.path = folder / f"{folder.name}_0.mcap"
        self._distribution = distribution
        self._topics: dict[str, _Topic] = {}
        self._schemas: dict[str, int] = {}
        self._first_ns: int | None = None
        self._last_ns = 0
        self._stream = self.path.open("wb")
        self._writer = Writer(self._stream, chunk_size=CHUNK_BYTES, compression=CompressionType.ZSTD)
        self._writer.start(profile="ros2", library="target_nav")

    @property
    def counts(self) -> dict[str, int]:
        """Messages written so far, by topic."""
        return {name: topic.count for name, topic in self._topics.items()}

    def add_topic(self, name: str, definition: Definition, qos: Sequence[OfferedQos]) -> None:
        """Announce a topic; `write` takes its messages from now on."""
        type_name = definition.type_name
        if type_name not in self._schemas:
            data = definition.text.encode("utf-8")
            self._schemas[type_name] = self._writer.register_schema(type_name, "ros2msg", data)
        details = {
            "offered_qos_profiles": _dump([profile.as_yaml() for profile in qos]),
            "topic_type_hash": definition.type_hash,
        }
        channel = self._writer.register_channel(name, "cdr", self._schemas[type_name], details)
        self._topics[name] = _Topic(channel, definition, tuple(qos))

    def write(self, name: str, data: bytes, received_ns: int, published_ns: int) -> None:
        """Write one message as it was on the wire (CDR)."""
        topic = self._topics[name]
        topic.count += 1
        self._first_ns = received_ns if self._first_ns is None else min(self._first_ns, received_ns)
        self._last_ns = max(self._last_ns, received_ns)
        self._writer.add_message(topic.channel, received_ns, data, published_ns)

    def flush(self) -> None:
        """Hand whole chunks to the system, so that they outlive this process."""
        self._stream.flush()

    def close(self) -> None:
        """Write the file's end and metadata.yaml. May be called again."""
        if self._stream.closed:
            return
        information = self._information()
        # rosbag2 looks there when a single .mcap file was copied out of its folder.
        self._writer.add_metadata("rosbag2", {"serialized_metadata": _dump(information)})
        self._writer.finish()
        self._stream.close()
        fresh = self.folder / f".metadata.{os.getpid()}"
        fresh.write_text(_dump({"rosbag2_bagfile_information": information}), encoding="utf-8")
        os.replace(fresh, self.folder / "metadata.yaml")

    def __enter__(self) -> BagWriter:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def _information(self) -> dict[str, Any]:
        begin_ns = self._first_ns or 0
        span = {
            "starting_time": {"nanoseconds_since_epoch": begin_ns},
            "duration": {"nanoseconds": max(self._last_ns - begin_ns, 0)},
            "message_count": sum(self.counts.values()),
        }
        topics = [
            {
                "topic_metadata": {
                    "name": name,
                    "type": topic.definition.type_name,
                    "serialization_format": "cdr",
                    "offered_qos_profiles": [profile.as_yaml() for profile in topic.qos],
                    "type_description_hash": topic.definition.type_hash,
                },
                "message_count": topic.count,
            }
            for name, topic in self._topics.items()
        ]
        return {
            "version": METADATA_VERSION,
            "storage_identifier": "mcap",
            **span,
            "topics_with_message_count": topics,
            "compression_format": "",
            "compression_mode": "",
            "relative_file_paths": [self.path.name],
            "files": [{"path": self.path.name, **span}],
            "custom_data": None,
            "ros_distro": self._distribution,
        }


class _Plain(yaml.SafeDumper):
    """No `&id001` for what occurs twice: rosbag2's reader does not want them."""

    def ignore_aliases(self, data: Any) -> bool:
        return True


def _dump(data: Any) -> str:
    return yaml.dump(data, Dumper=_Plain, sort_keys=False)


def _time(nanoseconds: int) -> dict[str, int]:
    seconds, rest = divmod(nanoseconds, 1_000_000_000)
    return {"sec": seconds, "nsec": rest}
