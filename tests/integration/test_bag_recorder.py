"""Real processes recorded for three seconds, read back with another library, and compared with what was heard."""

from __future__ import annotations

import math
import time
from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import pytest

pytest.importorskip("mcap", reason="mcap is in the extras `record` and `sim`")

from target_nav.app.bag_recorder import message_class, subscription_qos
from target_nav.app.robot_description import frames
from target_nav.app.ros_support import RosNode
from target_nav.config import Config
from tests.utils.processes import Managed, ros_environment, running, wait_until

pytestmark = [pytest.mark.ros, pytest.mark.linux, pytest.mark.slow]

PREFIX = "test_bag"
TOPICS = ("/scan", "/odom", "/cmd_vel", "/tf", "/nav_state")
SECONDS = 3.0


@dataclass
class Recorded:
    """The bag, and what a listener heard meanwhile: for each topic the messages as they were on the wire."""

    bag: Path
    recorder: Managed
    heard: dict[str, list[bytes]] = field(default_factory=dict)


def listen(recorded: Recorded) -> None:
    """Subscribe beside the recorder, for three seconds."""
    with RosNode("test_listener") as ros:
        for topic in TOPICS:
            wait_until(lambda topic=topic: bool(ros.node.get_publishers_info_by_topic(topic)), topic)
            publishers = ros.node.get_publishers_info_by_topic(topic)
            messages = recorded.heard.setdefault(topic, [])
            kind = message_class(publishers[0].topic_type)
            ros.node.create_subscription(kind, topic, messages.append, subscription_qos(publishers), raw=True)
        ros.start()
        wait_until(lambda: all(recorded.heard.values()), "a first message of each topic")
        time.sleep(SECONDS)


@pytest.fixture(scope="module")
def recorded(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Recorded]:
    folder = tmp_path_factory.mktemp("recorded")
    ros_environment()
    app, common, link = "target_nav.app", ("--prefix", PREFIX), str(folder / "arduino")
    try:
        with (
            running(
                f"{app}.sim_node", "--arena", "open_floor", "--serial-link", link, *common, folder=folder
            ),
            running(f"{app}.arduino_node", "--port", link, *common, folder=folder),
            running(f"{app}.odometry_node", *common, folder=folder),
            running(f"{app}.detector_node", "--source", "sim", *common, folder=folder),
            running(f"{app}.camera_node", *common, folder=folder),
            running(f"{app}.tree_executor", "--go", *common, folder=folder),
        ):
            with running(f"{app}.bag_recorder", "--output", str(folder / "bag"), folder=folder) as recorder:
                wait_until(lambda: all(f"recording {t} (" in recorder.log() for t in TOPICS), "subscriptions")
                recorded = Recorded(folder / "bag", recorder)
                listen(recorded)
                time.sleep(0.5)
            yield recorded
    finally:
        for path in Path("/dev/shm").glob(f"{PREFIX}_*"):
            path.unlink()


@dataclass(frozen=True)
class Row:
    """One message as rosbags gives it."""

    data: bytes
    value: Any
    received_ns: int


@pytest.fixture(scope="module")
def rows(recorded: Recorded) -> dict[str, list[Row]]:
    """The bag as another library reads it, with the definitions that are in the bag and no others."""
    pytest.importorskip("rosbags", reason="rosbags is in the extra `dev`")
    from rosbags.rosbag2 import Reader
    from rosbags.typesys import Stores, get_types_from_msg, get_typestore

    store = get_typestore(Stores.EMPTY)
    found: dict[str, list[Row]] = {}
    with Reader(recorded.bag) as reader:
        for connection in reader.connections:
            found[connection.topic] = []
            store.register(get_types_from_msg(connection.msgdef.data, connection.msgtype))
        for connection, received_ns, data in reader.messages():
            value = store.deserialize_cdr(data, connection.msgtype)
            found[connection.topic].append(Row(bytes(data), value, received_ns))
        assert {c.topic: c.msgcount for c in reader.connections} == {t: len(r) for t, r in found.items()}
    return found


def test_the_recorder_ends_in_order_and_counts(recorded: Recorded, rows: dict[str, list[Row]]) -> None:
    assert recorded.recorder.process.returncode == 0
    for topic in TOPICS:
        assert f"{len(rows[topic])} of {topic}" in recorded.recorder.log()


@pytest.mark.parametrize("topic", TOPICS)
def test_not_a_message_is_missing_and_none_is_changed(
    topic: str, recorded: Recorded, rows: dict[str, list[Row]]
) -> None:
    heard = recorded.heard[topic]
    written = [row.data for row in rows[topic]]
    # Messages may be equal to one another: the row of them must be somewhere in the bag, without a gap.
    assert any(written[n : n + len(heard)] == heard for n in range(len(written) - len(heard) + 1))
    least = {"/scan": 5.0, "/nav_state": 4.0}.get(topic, 15.0)
    assert len(heard) > least * SECONDS * 0.8


@pytest.mark.parametrize("topic", TOPICS)
def test_values_are_those_that_ros_reads(topic: str, recorded: Recorded, rows: dict[str, list[Row]]) -> None:
    from rclpy.serialization import deserialize_message

    kind = message_class(rows[topic][0].value.__msgtype__)
    for row in rows[topic][-10:]:
        assert_same(deserialize_message(row.data, kind), row.value)


def assert_same(ours: Any, theirs: Any) -> None:
    """Field by field, down to the numbers."""
    for name in ours.get_fields_and_field_types():
        mine, other = getattr(ours, name), getattr(theirs, name)
        if hasattr(mine, "get_fields_and_field_types"):
            assert_same(mine, other)
        elif isinstance(mine, str):
            assert mine == other
        elif hasattr(mine, "__len__"):
            assert len(mine) == len(other)
            for a, b in zip(mine, other):
                assert_same(a, b) if hasattr(a, "get_fields_and_field_types") else assert_number(a, b)
        else:
            assert_number(mine, other)


def assert_number(mine: float, other: float) -> None:
    assert mine == other or (math.isnan(mine) and math.isnan(other))


def test_the_robot_is_seen_driving(rows: dict[str, list[Row]]) -> None:
    commanded = [abs(row.value.linear.x) + abs(row.value.angular.z) for row in rows["/cmd_vel"]]
    travelled = [row.value.pose.pose.position.x for row in rows["/odom"]]
    assert max(commanded) > 0.05
    assert max(travelled) - min(travelled) > 0.05


def test_times_are_those_of_the_messages(rows: dict[str, list[Row]]) -> None:
    for row in rows["/odom"]:
        stamp = row.value.header.stamp
        age_s = row.received_ns * 1e-9 - stamp.sec - stamp.nanosec * 1e-9
        assert -0.01 < age_s < 2.0
    for written in rows.values():
        received = [row.received_ns for row in written]
        assert received == sorted(received)


def test_latched_mounts_are_in_it_and_agree_with_the_model(rows: dict[str, list[Row]]) -> None:
    model = {frame.name: frame for frame in frames(Config())}
    found = {t.child_frame_id: t for row in rows["/tf_static"] for t in row.value.transforms}
    assert {"laser", "camera_link"} <= set(found) <= set(model)
    for name, transform in found.items():
        frame, place, turn = model[name], transform.transform.translation, transform.transform.rotation
        assert transform.header.frame_id == frame.parent
        assert (place.x, place.y, place.z) == pytest.approx((frame.x_m, frame.y_m, frame.z_m))
        if name in ("laser", "camera_link"):
            assert 2.0 * math.atan2(turn.z, turn.w) == pytest.approx(frame.yaw_rad)


def test_what_is_not_published_is_waited_for(tmp_path: Path) -> None:
    ros_environment()
    output = ("--output", str(tmp_path / "bag"), "--topics", "/nobody")
    with running("target_nav.app.bag_recorder", *output, folder=tmp_path) as recorder:
        time.sleep(0.6)
    assert recorder.process.returncode == 0
    assert "nothing" in recorder.log()
    assert (tmp_path / "bag" / "metadata.yaml").is_file()
