"""ROS wiring: clear words without ROS; errors in callbacks end the process, bad messages do not."""

from __future__ import annotations

import sys
from collections.abc import Iterator

import pytest

from target_nav.app.ros_convert import BadMessageError
from target_nav.app.ros_support import (
    RosNode,
    command_qos,
    latched_qos,
    require_ros,
    sensor_qos,
    stream_qos,
    tf_qos,
)
from target_nav.errors import DeviceError
from tests.utils.processes import ros_environment, wait_until


@pytest.mark.parametrize("missing", ["rclpy", "sensor_msgs.msg", "tf2_msgs.msg"])
def test_without_ros_it_is_told_what_to_do(monkeypatch: pytest.MonkeyPatch, missing: str) -> None:
    monkeypatch.setitem(sys.modules, missing, None)
    with pytest.raises(DeviceError, match=r"setup\.bash.*start\.sh"):
        require_ros("tf2_msgs.msg")


@pytest.fixture
def ros() -> Iterator[RosNode]:
    ros_environment()
    with RosNode("test_wiring") as node:
        yield node


@pytest.mark.ros
def test_a_message_comes_through(ros: RosNode) -> None:
    from std_msgs.msg import String

    heard: list[str] = []
    send = ros.publisher(String, "/wiring", stream_qos())
    ros.subscribe(String, "/wiring", lambda message: heard.append(message.data), stream_qos())
    ros.start()
    wait_until(lambda: send(String(data="hello")) is None and bool(heard), "a message")
    assert set(heard) == {"hello"}


@pytest.mark.ros
def test_a_bad_message_is_counted_and_the_next_one_taken(ros: RosNode) -> None:
    from std_msgs.msg import String

    heard: list[str] = []

    def take(message: String) -> None:
        if message.data == "bad":
            raise BadMessageError("form", "not what it should be")
        heard.append(message.data)

    send = ros.publisher(String, "/wiring", stream_qos())
    ros.subscribe(String, "/wiring", take, stream_qos())
    ros.start()
    wait_until(
        lambda: send(String(data="bad")) is None and "/wiring form" in ros.warnings.counts, "the bad one"
    )
    wait_until(lambda: send(String(data="good")) is None and bool(heard), "the good one")
    ros.check()


@pytest.mark.ros
def test_an_error_in_a_callback_ends_the_process(ros: RosNode) -> None:
    def broken() -> None:
        raise ZeroDivisionError("a defect")

    ros.every(0.01, broken)
    with pytest.raises(ZeroDivisionError, match="a defect"):
        ros.run()
    assert ros.stop.requested


@pytest.mark.ros
def test_run_ends_when_it_is_asked_to(ros: RosNode) -> None:
    turns: list[None] = []
    ros.every(0.01, lambda: turns.append(None))
    ros.run(check=lambda: ros.stop.request() if len(turns) > 3 else None)
    assert len(turns) > 3


@pytest.mark.ros
def test_two_nodes_live_in_one_process(ros: RosNode) -> None:
    with RosNode("test_other") as other:
        other.start()
        ros.start()
        wait_until(lambda: "test_other" in ros.node.get_node_names(), "the other node")
    ros.check()


@pytest.mark.ros
def test_qos_is_as_the_table_has_it() -> None:
    from rclpy.qos import DurabilityPolicy, ReliabilityPolicy

    assert sensor_qos().reliability == ReliabilityPolicy.BEST_EFFORT
    assert (command_qos().reliability, command_qos().depth) == (ReliabilityPolicy.RELIABLE, 1)
    assert (tf_qos().durability, tf_qos().depth) == (DurabilityPolicy.VOLATILE, 100)
    assert (latched_qos().durability, latched_qos().depth) == (DurabilityPolicy.TRANSIENT_LOCAL, 1)
