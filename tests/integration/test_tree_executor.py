"""The running executor as others see it: watchers, topics, transforms. The client is rclpy alone, not this project.

What a watcher demands of an executor is written down as `watcher_accepts`: each rule is one on which the real
`py-trees-tree-watcher` stops with an exception.
"""

from __future__ import annotations

import json
import sys
import time
import uuid
from collections import Counter
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

from tests.utils.processes import Managed, ros_environment, running, wait_until

pytestmark = [pytest.mark.ros, pytest.mark.linux, pytest.mark.slow]
pytest.importorskip("rclpy")
pytest.importorskip("py_trees_ros_interfaces.srv")

import rclpy  # noqa: E402
from geometry_msgs.msg import Twist  # noqa: E402
from py_trees_ros_interfaces.msg import BehaviourTree, SnapshotStreamParameters  # noqa: E402
from py_trees_ros_interfaces.srv import (  # noqa: E402
    CloseSnapshotStream,
    OpenSnapshotStream,
    ReconfigureSnapshotStream,
)
from rclpy.context import Context  # noqa: E402
from rclpy.executors import SingleThreadedExecutor  # noqa: E402
from rclpy.node import Node  # noqa: E402
from rclpy.qos import DurabilityPolicy, QoSProfile, ReliabilityPolicy  # noqa: E402
from std_msgs.msg import String  # noqa: E402
from tf2_msgs.msg import TFMessage  # noqa: E402

PREFIX = "test_executor"
EXECUTOR = "target_nav.app.tree_executor"
LATCHED = QoSProfile(
    depth=1, reliability=ReliabilityPolicy.RELIABLE, durability=DurabilityPolicy.TRANSIENT_LOCAL
)
ONLY_ON_CHANGE = sys.float_info.max


class Client:
    """A node of a stranger."""

    def __init__(self) -> None:
        ros_environment()
        self.context = Context()
        rclpy.init(context=self.context)
        self.node = Node("stranger", context=self.context)
        self.executor = SingleThreadedExecutor(context=self.context)
        self.executor.add_node(self.node)

    def close(self) -> None:
        self.executor.shutdown()
        self.node.destroy_node()
        self.context.shutdown()

    def spin_until(self, condition: Any, what: str, patience_s: float = 15.0) -> None:
        def check() -> bool:
            self.executor.spin_once(timeout_sec=0.05)
            return bool(condition())

        wait_until(check, what, patience_s)

    def services_of(self, service_type: str) -> list[str]:
        return [name for name, types in self.node.get_service_names_and_types() if service_type in types]

    def call(self, service_type: Any, name: str, request: Any) -> Any:
        client = self.node.create_client(service_type, name)
        self.spin_until(client.service_is_ready, f"service {name}")
        future = client.call_async(request)
        self.spin_until(future.done, f"answer of {name}")
        return future.result()

    def listen(self, message_type: Any, topic: str, qos: Any) -> list[Any]:
        heard: list[Any] = []
        self.node.create_subscription(message_type, topic, heard.append, qos)
        return heard

    def open_stream(self, topic: str = "", **parameters: Any) -> tuple[str, list[Any]]:
        """As the watcher does it: the service is found by its type, the topic is the answer's."""
        kind = "py_trees_ros_interfaces/srv/OpenSnapshotStream"
        self.spin_until(lambda: self.services_of(kind), "an executor")
        (name,) = self.services_of(kind)
        request = OpenSnapshotStream.Request(
            topic_name=topic, parameters=SnapshotStreamParameters(**parameters)
        )
        answer = self.call(OpenSnapshotStream, name, request)
        # it exists before `open` returns, but discovery may bring the news after the answer
        self.spin_until(lambda: self.node.count_publishers(answer.topic_name) == 1, "the publisher", 2.0)
        return answer.topic_name, self.listen(BehaviourTree, answer.topic_name, LATCHED)


@pytest.fixture(scope="module")
def executor(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Managed]:
    """Without LiDAR, wheels and camera, and told to go: it holds still and says what is missing."""
    options = ("--prefix", PREFIX, "--go")
    with running(EXECUTOR, *options, folder=tmp_path_factory.mktemp("executor")) as process:
        yield process


@pytest.fixture
def client(executor: Managed) -> Iterator[Client]:
    stranger = Client()
    yield stranger
    stranger.close()


def watcher_accepts(tree: Any) -> None:
    """Every rule on which the real watcher stops."""
    ids = {bytes(b.own_id.uuid) for b in tree.behaviours}
    assert len(ids) == len(tree.behaviours)
    assert sum(not any(b.parent_id.uuid) for b in tree.behaviours) == 1, "one behaviour without a parent"
    for b in tree.behaviours:
        assert b.type in (1, 2, 3, 4, 6), f"{b.name}: type {b.type}"
        assert b.status in (1, 2, 3, 4), f"{b.name}: status {b.status}"
        assert b.blackbox_level in (1, 2, 3, 4), f"{b.name}: blackbox level {b.blackbox_level}"
        assert all(bytes(child.uuid) in ids for child in b.child_ids), f"{b.name}: a child is not in the list"
        assert b.type != 6 or len(b.child_ids) == 1, f"{b.name}: a decorator has one child"
        assert uuid.UUID(bytes=bytes(b.own_id.uuid)).version == 4, f"{b.name}: its id is no uuid4"


def test_a_watcher_that_names_no_topic_gets_one_and_sees_the_tree(client: Client) -> None:
    topic, trees = client.open_stream(snapshot_period=ONLY_ON_CHANGE)
    client.spin_until(lambda: trees, "a snapshot")
    assert topic.startswith("/tree_executor/snapshot_streams/_snapshots_")
    watcher_accepts(trees[-1])
    names = {b.name for b in trees[-1].behaviours}
    assert {"Bowling pin", "On request", "InputsFresh", "NavigateToTarget", "Arrived"} <= names
    assert trees[-1].statistics.count > 0
    assert 0.0 < trees[-1].statistics.tick_duration < 0.5


def test_a_relative_topic_is_put_under_the_executor(client: Client) -> None:
    topic, trees = client.open_stream("mine", snapshot_period=0.1)
    assert topic == "/tree_executor/snapshot_streams/mine"
    client.spin_until(lambda: len(trees) > 3, "snapshots")


def test_each_stream_keeps_its_own_period(client: Client) -> None:
    _, fast = client.open_stream(snapshot_period=0.1)
    _, slow = client.open_stream(snapshot_period=1.0)
    client.spin_until(lambda: fast and slow, "both streams")
    fast.clear(), slow.clear()
    client.spin_until(lambda: len(slow) >= 2, "two of the slow stream")
    assert len(fast) >= 8


def test_blackboard_data_comes_only_to_whom_it_was_promised(client: Client) -> None:
    _, plain = client.open_stream(snapshot_period=0.1)
    _, with_data = client.open_stream(snapshot_period=0.1, blackboard_data=True)
    client.spin_until(lambda: plain and with_data, "both streams")
    assert not plain[-1].blackboard_on_visited_path
    values = {item.key: item.value for item in with_data[-1].blackboard_on_visited_path}
    assert values["/command/requested"] == "True"


def test_streams_can_be_reconfigured_and_closed(client: Client) -> None:
    topic, trees = client.open_stream(snapshot_period=ONLY_ON_CHANGE)
    base = "/tree_executor/snapshot_streams"
    parameters = SnapshotStreamParameters(snapshot_period=0.1)
    request = ReconfigureSnapshotStream.Request(topic_name=topic, parameters=parameters)
    assert client.call(ReconfigureSnapshotStream, f"{base}/reconfigure", request).result
    trees.clear()
    client.spin_until(lambda: len(trees) > 5, "snapshots at the new period")
    request = CloseSnapshotStream.Request(topic_name=topic)
    assert client.call(CloseSnapshotStream, f"{base}/close", request).result
    client.spin_until(lambda: client.node.count_publishers(topic) == 0, "the publisher to go")
    assert not client.call(CloseSnapshotStream, f"{base}/close", request).result


def test_without_inputs_every_velocity_is_zero_and_the_reason_is_told(client: Client) -> None:
    twists = client.listen(Twist, "/cmd_vel", 1)
    states = client.listen(String, "/nav_state", 10)
    begin_s = time.monotonic()
    client.spin_until(
        lambda: time.monotonic() - begin_s > 1.0 and states, "a second of /cmd_vel and /nav_state"
    )
    for twist in twists:
        assert (twist.linear.x, twist.linear.y, twist.angular.z) == (0.0, 0.0, 0.0)
    state = json.loads(states[-1].data)
    assert state["state"] == "IDLE"
    assert "scan has not come yet (limit 0.80 s); is the LiDAR running?" in str(state)


def test_a_tf2_listener_that_comes_late_gets_the_mounts(client: Client) -> None:
    # tf2 listens to /tf_static transient local
    heard = client.listen(
        TFMessage, "/tf_static", QoSProfile(depth=100, durability=DurabilityPolicy.TRANSIENT_LOCAL)
    )
    client.spin_until(lambda: heard, "/tf_static")
    frames = {(t.header.frame_id, t.child_frame_id) for t in heard[-1].transforms}
    optical = ("camera_link", "camera_optical_frame")
    assert frames >= {("base_link", "laser"), ("base_link", "camera_link"), optical}


def test_a_second_executor_is_refused_and_names_the_first(executor: Managed, tmp_path: Path) -> None:
    second = Managed(EXECUTOR, ("--prefix", PREFIX), tmp_path)
    assert second.wait() == 2
    assert f"pid {executor.process.pid}" in second.log()


def test_a_mission_that_does_not_parse_is_told_with_its_line(tmp_path: Path) -> None:
    path = tmp_path / "broken.xml"
    path.write_text(
        '<root BTCPP_format="4">\n  <BehaviorTree ID="A">\n    <Sequenze/>\n  </BehaviorTree>\n</root>\n'
    )
    process = Managed(EXECUTOR, ("--prefix", "test_broken", "--mission", str(path)), tmp_path)
    assert process.wait() == 2
    assert "broken.xml:3:5: error:" in process.log()
    assert "Sequence" in process.log()


@pytest.mark.parametrize(
    ("module", "options", "words"),
    [
        ("target_nav.app.arduino_node", ("--port", "/dev/ttyNOPE7"), ["/dev/ttyNOPE7"]),
        (EXECUTOR, ("--set", "lidar.rate_hz=-3"), ["lidar.rate_hz is -3", "0.5"]),
        (EXECUTOR, ("--set", "lidar.rate=3"), ["did you mean 'lidar.rate_hz'"]),
        ("target_nav.app.sim_node", ("--arena", "no_such_arena"), ["no_such_arena"]),
        ("target_nav.app.detector_node", ("--source", "/dev/video97"), ["/dev/video97"]),
    ],
)
def test_what_cannot_be_run_says_why_and_ends_with_2(
    tmp_path: Path, module: str, options: tuple[str, ...], words: list[str]
) -> None:
    process = Managed(module, ("--prefix", "test_cannot", *options), tmp_path)
    assert process.wait() == 2, process.log()
    assert [word for word in words if word not in process.log()] == []


def test_the_names_of_the_tree_are_told_apart(client: Client) -> None:
    _, trees = client.open_stream(snapshot_period=ONLY_ON_CHANGE)
    client.spin_until(lambda: trees, "a snapshot")
    kinds = Counter(b.type for b in trees[-1].behaviours)
    assert kinds[1] > 5 and kinds[2] > 2 and kinds[3] > 1 and kinds[6] > 0  # noqa: PT018
