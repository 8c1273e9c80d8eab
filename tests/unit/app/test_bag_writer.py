"""The bag on disk, read back by the MCAP library and, where it is installed, by rosbags."""

from __future__ import annotations

import importlib.util
import struct
from pathlib import Path

import pytest
import yaml

pytest.importorskip("mcap", reason="mcap is in the extras `record` and `sim`")

from mcap.reader import make_reader

from target_nav.app.bag_recorder import free_folder
from target_nav.app.bag_writer import BagWriter, OfferedQos
from target_nav.app.message_definitions import Definition
from target_nav.errors import DeviceError

FOREVER_NS = 2**63 - 1
LATCHED = OfferedQos(
    "reliable", "transient_local", "keep_last", 1, "automatic", FOREVER_NS, FOREVER_NS, FOREVER_NS
)
SENSOR = OfferedQos(
    "best_effort", "volatile", "keep_last", 5, "automatic", FOREVER_NS, FOREVER_NS, FOREVER_NS
)
VALUE = Definition("demo_msgs/msg/Value", "float64 value\n", "RIHS01_" + "ab" * 32)
BEGIN_NS = 1_700_000_000_000_000_000


def cdr(value: float) -> bytes:
    """A float64 as it goes over the wire: little endian, after four bytes of header."""
    return b"\x00\x01\x00\x00" + struct.pack("<d", value)


def write_bag(folder: Path) -> None:
    with BagWriter(folder, "jazzy") as bag:
        bag.add_topic("/a", VALUE, [SENSOR, LATCHED])
        bag.add_topic("/silent", VALUE, [])
        for n in range(100):
            bag.write("/a", cdr(float(n)), BEGIN_NS + 1000 * n, BEGIN_NS + 1000 * n - 7)
        bag.add_topic("/late", VALUE, [LATCHED])
        bag.write("/late", cdr(-1.0), BEGIN_NS - 50, BEGIN_NS - 60)
        assert bag.counts == {"/a": 100, "/silent": 0, "/late": 1}


def test_messages_are_kept_byte_for_byte(tmp_path: Path) -> None:
    write_bag(tmp_path / "bag")
    with (tmp_path / "bag" / "bag_0.mcap").open("rb") as stream:
        reader = make_reader(stream)
        assert reader.get_header().profile == "ros2"
        rows = list(reader.iter_messages(topics=["/a"], log_time_order=True))
    schema, channel, _ = rows[0]
    assert (schema.name, schema.encoding, schema.data) == (
        "demo_msgs/msg/Value",
        "ros2msg",
        b"float64 value\n",
    )
    assert (channel.message_encoding, channel.metadata["topic_type_hash"]) == ("cdr", VALUE.type_hash)
    assert [message.data for _, _, message in rows] == [cdr(float(n)) for n in range(100)]
    assert [m.log_time for _, _, m in rows] == [BEGIN_NS + 1000 * n for n in range(100)]
    assert rows[5][2].publish_time == BEGIN_NS + 4993


def test_metadata_is_what_ros2_bag_expects(tmp_path: Path) -> None:
    write_bag(tmp_path / "bag")
    text = (tmp_path / "bag" / "metadata.yaml").read_text()
    assert "&id" not in text
    data = yaml.safe_load(text)["rosbag2_bagfile_information"]
    assert (data["version"], data["storage_identifier"], data["ros_distro"]) == (9, "mcap", "jazzy")
    assert data["relative_file_paths"] == ["bag_0.mcap"]
    assert data["message_count"] == 101
    assert data["starting_time"]["nanoseconds_since_epoch"] == BEGIN_NS - 50
    assert data["duration"]["nanoseconds"] == 99_050
    topics = {row["topic_metadata"]["name"]: row for row in data["topics_with_message_count"]}
    assert {name: row["message_count"] for name, row in topics.items()} == {
        "/a": 100,
        "/silent": 0,
        "/late": 1,
    }
    first = topics["/a"]["topic_metadata"]
    assert (first["type"], first["serialization_format"]) == ("demo_msgs/msg/Value", "cdr")
    assert [qos["durability"] for qos in first["offered_qos_profiles"]] == ["volatile", "transient_local"]
    # rmw's infinity
    assert first["offered_qos_profiles"][0]["deadline"] == {"sec": 9223372036, "nsec": 854775807}


def test_a_file_cut_off_keeps_what_was_written(tmp_path: Path) -> None:
    bag = BagWriter(tmp_path / "bag")
    bag.add_topic("/a", VALUE, [])
    noise = [bytes((n * 7919 >> shift) & 0xFF for shift in range(8)) * 20 for n in range(6000)]
    for n, data in enumerate(noise):
        bag.write("/a", data, BEGIN_NS + n, BEGIN_NS + n)
    bag.flush()
    (tmp_path / "cut.mcap").write_bytes(bag.path.read_bytes())
    bag.close()
    from mcap.exceptions import McapError
    from mcap.records import Message
    from mcap.stream_reader import StreamReader

    found = []
    with (tmp_path / "cut.mcap").open("rb") as stream:
        try:
            for record in StreamReader(stream).records:
                if isinstance(record, Message):
                    found.append(record.data)
        except (McapError, EOFError):
            pass
    assert len(found) > 3000
    assert found == noise[: len(found)]


def test_an_empty_bag_is_a_bag(tmp_path: Path) -> None:
    BagWriter(tmp_path / "bag").close()
    data = yaml.safe_load((tmp_path / "bag" / "metadata.yaml").read_text())["rosbag2_bagfile_information"]
    assert (data["message_count"], data["topics_with_message_count"]) == (0, [])


def test_closing_twice_is_closing(tmp_path: Path) -> None:
    bag = BagWriter(tmp_path / "bag")
    bag.close()
    before = bag.path.read_bytes()
    bag.close()
    assert bag.path.read_bytes() == before


def test_a_bag_is_never_written_over(tmp_path: Path) -> None:
    BagWriter(tmp_path / "bag").close()
    with pytest.raises(DeviceError, match="choose another --output"):
        BagWriter(tmp_path / "bag")


def test_a_place_that_cannot_be_written_is_told(tmp_path: Path) -> None:
    (tmp_path / "file").write_text("")
    with pytest.raises(DeviceError, match="cannot be made"):
        BagWriter(tmp_path / "file" / "bag")


def test_a_second_bag_gets_a_number(tmp_path: Path) -> None:
    assert free_folder(tmp_path / "bag") == tmp_path / "bag"
    (tmp_path / "bag").mkdir()
    (tmp_path / "bag-1").mkdir()
    assert free_folder(tmp_path / "bag") == tmp_path / "bag-2"


@pytest.mark.skipif(importlib.util.find_spec("rosbags") is None, reason="rosbags is in the extra `dev`")
def test_another_library_reads_it(tmp_path: Path) -> None:
    from rosbags.rosbag2 import Reader
    from rosbags.typesys import Stores, get_types_from_msg, get_typestore

    write_bag(tmp_path / "bag")
    store = get_typestore(Stores.EMPTY)
    store.register(get_types_from_msg(VALUE.text, VALUE.type_name))
    with Reader(tmp_path / "bag") as reader:
        assert {c.topic: c.msgcount for c in reader.connections} == {"/a": 100, "/silent": 0, "/late": 1}
        profiles = {c.topic: c.ext.offered_qos_profiles for c in reader.connections}
        assert [p.durability.name for p in profiles["/a"]] == ["VOLATILE", "TRANSIENT_LOCAL"]
        values = [
            store.deserialize_cdr(data, connection.msgtype).value
            for connection, _, data in reader.messages()
            if connection.topic == "/a"
        ]
    assert values == [float(n) for n in range(100)]
