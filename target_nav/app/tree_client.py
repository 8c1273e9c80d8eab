"""A watcher of a running executor: finds it, opens a snapshot stream, keeps the newest tree, closes the stream."""

from __future__ import annotations

import threading
from collections.abc import Sequence
from typing import Any

from py_trees_ros_interfaces.msg import BehaviourTree, SnapshotStreamParameters
from py_trees_ros_interfaces.srv import CloseSnapshotStream, OpenSnapshotStream
from rclpy.node import Node

from target_nav.app.ros_support import latched_qos

OPEN_TYPE = "py_trees_ros_interfaces/srv/OpenSnapshotStream"


class TreeClient:
    """Never blocks: `behaviours` is empty until the first snapshot came. `poll` looks for the executor until found."""

    def __init__(self, node: Node, period_s: float = 0.1) -> None:
        self._node, self._period_s = node, period_s
        self._lock = threading.Lock()
        self._tree: Sequence[Any] = ()
        self._open: Any = None
        self._namespace = ""
        self._topic = ""

    def poll(self) -> None:
        if self._open is not None:
            return
        for name, types in self._node.get_service_names_and_types():
            if OPEN_TYPE in types:
                self._namespace = name.rsplit("/", 1)[0]
                client = self._node.create_client(OpenSnapshotStream, name)
                if not client.service_is_ready():
                    self._node.destroy_client(client)
                    return
                parameters = SnapshotStreamParameters(snapshot_period=self._period_s)
                self._open = client.call_async(OpenSnapshotStream.Request(parameters=parameters))
                self._open.add_done_callback(self._subscribe)
                return

    def behaviours(self) -> Sequence[Any]:
        with self._lock:
            return self._tree

    def close(self) -> None:
        """Ask the executor to close the stream; it need not be there any more."""
        if self._topic:
            client = self._node.create_client(CloseSnapshotStream, f"{self._namespace}/close")
            if client.service_is_ready():
                client.call_async(CloseSnapshotStream.Request(topic_name=self._topic))

    def _subscribe(self, future: Any) -> None:
        self._topic = future.result().topic_name
        self._node.create_subscription(BehaviourTree, self._topic, self._keep, latched_qos())

    def _keep(self, message: BehaviourTree) -> None:
        with self._lock:
            self._tree = tuple(message.behaviours)
