"""The interface packages from deploy/interfaces: their fields, and that their messages cross processes over DDS."""

from __future__ import annotations

import os
import random
import subprocess
import sys
from collections.abc import Iterator

import pytest

rclpy = pytest.importorskip("rclpy", reason="needs ROS 2")
interfaces = pytest.importorskip("py_trees_ros_interfaces.msg", reason="needs the interface packages")
services = pytest.importorskip("py_trees_ros_interfaces.srv")
tf2_msgs = pytest.importorskip("tf2_msgs.msg")

pytestmark = pytest.mark.ros

# Sends a transform every 50 ms and answers one service, until it is stopped.
PEER = """
import rclpy
from geometry_msgs.msg import TransformStamped
from py_trees_ros_interfaces.srv import OpenSnapshotStream
from tf2_msgs.msg import TFMessage

def answer(request, response):
    response.topic_name = f"{request.topic_name}/{request.parameters.snapshot_period}"
    return response

rclpy.init()
node = rclpy.create_node("interfaces_peer")
node.create_service(OpenSnapshotStream, "~/open", answer)
publisher = node.create_publisher(TFMessage, "/tf", 100)
transform = TransformStamped(child_frame_id="base_link")
transform.transform.translation.x = 1.25
node.create_timer(0.05, lambda: publisher.publish(TFMessage(transforms=[transform])))
rclpy.spin(node)
"""


@pytest.fixture
def domain() -> int:
    return int(os.environ.get("ROS_DOMAIN_ID", random.randint(1, 100)))


@pytest.fixture
def peer(domain: int) -> Iterator[None]:
    env = {**os.environ, "ROS_DOMAIN_ID": str(domain), "ROS_AUTOMATIC_DISCOVERY_RANGE": "LOCALHOST"}
    process = subprocess.Popen([sys.executable, "-c", PEER], env=env, stderr=subprocess.DEVNULL)
    try:
        yield
    finally:
        process.terminate()
        process.wait(timeout=10)


def test_messages_and_services_cross_processes(
    peer: None, domain: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("ROS_AUTOMATIC_DISCOVERY_RANGE", "LOCALHOST")
    context = rclpy.Context()
    rclpy.init(context=context, domain_id=domain)
    node = rclpy.create_node("interfaces_test", context=context)
    executor = rclpy.executors.SingleThreadedExecutor(context=context)
    executor.add_node(node)
    try:
        received: list[float] = []
        node.create_subscription(
            tf2_msgs.TFMessage, "/tf", lambda m: received.append(m.transforms[0].transform.translation.x), 100
        )
        client = node.create_client(services.OpenSnapshotStream, "/interfaces_peer/open")
        assert client.wait_for_service(20.0), "the other process is not heard"
        request = services.OpenSnapshotStream.Request(topic_name="mine")
        request.parameters.snapshot_period = 0.5
        reply = client.call_async(request)
        executor.spin_until_future_complete(reply, timeout_sec=20.0)
        assert reply.result().topic_name == "mine/0.5"
        for _ in range(200):
            if received:
                break
            executor.spin_once(timeout_sec=0.1)
        assert received[0] == 1.25
    finally:
        executor.shutdown()
        node.destroy_node()
        rclpy.shutdown(context=context)


def test_behaviour_has_the_fields_of_the_real_one_in_their_order() -> None:
    # The order is part of the type's hash, and DDS endpoints with another hash do not match.
    assert list(interfaces.Behaviour.get_fields_and_field_types()) == [
        "name",
        "class_name",
        "own_id",
        "parent_id",
        "tip_id",
        "child_ids",
        "current_child_id",
        "type",
        "additional_detail",
        "blackbox_level",
        "status",
        "message",
        "is_active",
        "blackboard_access",
    ]
    assert (interfaces.Behaviour.RUNNING, interfaces.Behaviour.DECORATOR) == (2, 6)
    assert interfaces.Behaviour.BLACKBOX_LEVEL_NOT_A_BLACKBOX == 4
    assert interfaces.Behaviour.BLACKBOARD_ACCESS_EXCLUSIVE_WRITE == "x"
    assert interfaces.ActivityItem.NO_OVERWRITE == "NO_OVERWRITE"


def test_statistics_have_a_time_stamp_and_single_precision() -> None:
    fields = interfaces.Statistics.get_fields_and_field_types()
    assert fields["stamp"] == "builtin_interfaces/Time"
    assert fields["tick_interval_variance"] == "float"
    assert len(fields) == 8
