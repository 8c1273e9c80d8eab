"""A watcher of a running executor: finds it, opens a snapshot stream, keeps the newest tree, closes the stream.

It goes on where the executor was started anew: the stream is gone then, and the client opens another.
"""

from __future__ import annotations

import threading
import time
from collections.abc import Callable, Sequence
from typing import Any

from py_trees_ros_interfaces.msg import BehaviourTree, SnapshotStreamParameters
from py_trees_ros_interfaces.srv import CloseSnapshotStream, OpenSnapshotStream
from rclpy.node import Node

from target_nav.app.ros_support import latched_qos

OPEN_TYPE = "py_trees_ros_interfaces/srv/OpenSnapshotStream"
ANSWER_S = 5.0
"""An executor that has not answered by then has died with the question."""
CLOSE_S = 0.5
"""So long `close` waits for the executor's word."""
ABSENT_S = 1.0
"""A publisher that discovery has not shown for so long is gone; after opening it gets `ANSWER_S`."""


class TreeClient:
    """Blocks in `close` only: `behaviours` is empty until the first snapshot came. Call `poll` a few times a second.

    Args:
        node: something spins it
        period_s: snapshots come at least so often; see `stream_names.ONLY_ON_CHANGE`
        namespace: of the executor's services, if there is more than one executor
        topic: of a stream that is there already; none is opened then
        on_tree: called with each message, in the thread that spins the node
    """

    def __init__(
        self,
        node: Node,
        period_s: float = 0.1,
        *,
        blackboard_data: bool = False,
        blackboard_activity: bool = False,
        namespace: str = "",
        topic: str = "",
        on_tree: Callable[[BehaviourTree], None] | None = None,
        clock: Callable[[], float] = time.monotonic,
    ) -> None:
        self._node, self._clock, self._on_tree = node, clock, on_tree
        self._parameters = SnapshotStreamParameters(
            snapshot_period=period_s,
            blackboard_data=blackboard_data,
            blackboard_activity=blackboard_activity,
        )
        self._namespace_hint, self._given_topic = namespace, topic
        self._lock = threading.Lock()
        self._tree: Sequence[Any] = ()
        self._namespace = ""
        self._topic = ""
        self._question: tuple[Any, Any, float] | None = None
        self._subscription: Any = None
        self._closer: Any = None
        self._publishers: set[bytes] = set()
        self._patient_until_s = 0.0
        self.opened = 0
        """How many streams were opened so far."""

    @property
    def is_open(self) -> bool:
        return self._subscription is not None

    def candidates(self) -> list[str]:
        """The services that open a stream, of all executors that fit the namespace."""
        return [
            name
            for name, types in self._node.get_service_names_and_types()
            if OPEN_TYPE in types and self._namespace_hint in name
        ]

    def poll(self) -> None:
        """Look for the executor, take its answer, notice that it is gone: whichever is next."""
        now_s = self._clock()
        if self._subscription is not None:
            self._check_publisher(now_s)
        elif self._given_topic:
            self._subscribe(self._given_topic, now_s)
        elif self._question is not None:
            self._check_answer(now_s)
        else:
            self._ask(now_s)

    def behaviours(self) -> Sequence[Any]:
        with self._lock:
            return self._tree

    def close(self) -> None:
        """Ask the executor to close the stream; it need not be there any more. Something else spins the node."""
        if self._closer is not None and self._closer.service_is_ready():
            future = self._closer.call_async(CloseSnapshotStream.Request(topic_name=self._topic))
            deadline_s = time.monotonic() + CLOSE_S
            while not future.done() and time.monotonic() < deadline_s:
                time.sleep(0.01)
        self._drop()

    # ------------------------------------------------------------------------------------------------------------------

    def _ask(self, now_s: float) -> None:
        found = self.candidates()
        if not found:
            return
        client = self._node.create_client(OpenSnapshotStream, found[0])
        if not client.service_is_ready():
            self._node.destroy_client(client)
            return
        self._namespace = found[0].rsplit("/", 1)[0]
        future = client.call_async(OpenSnapshotStream.Request(parameters=self._parameters))
        self._question = (client, future, now_s + ANSWER_S)

    def _check_answer(self, now_s: float) -> None:
        assert self._question is not None
        client, future, until_s = self._question
        if not future.done() and now_s < until_s:
            return
        self._question = None
        answer = future.result() if future.done() else None
        self._node.destroy_client(client)
        if answer is not None:
            # now and not when it is needed: discovery takes its time
            self._closer = self._node.create_client(CloseSnapshotStream, f"{self._namespace}/close")
            self._subscribe(answer.topic_name, now_s)

    def _subscribe(self, topic: str, now_s: float) -> None:
        self._topic = topic
        self._publishers = set()
        self._patient_until_s = now_s + ANSWER_S
        self._subscription = self._node.create_subscription(BehaviourTree, topic, self._keep, latched_qos())
        self.opened += 1

    def _check_publisher(self, now_s: float) -> None:
        there = {bytes(info.endpoint_gid) for info in self._node.get_publishers_info_by_topic(self._topic)}
        # a new executor may have given the same name to another watcher's stream, so the name alone says nothing
        if there and (not self._publishers or there & self._publishers):
            self._publishers = there
            self._patient_until_s = now_s + ABSENT_S
        elif now_s >= self._patient_until_s:
            self._drop()

    def _drop(self) -> None:
        if self._subscription is not None:
            self._node.destroy_subscription(self._subscription)
        if self._closer is not None:
            self._node.destroy_client(self._closer)
        self._subscription, self._closer, self._topic = None, None, ""
        with self._lock:
            self._tree = ()

    def _keep(self, message: BehaviourTree) -> None:
        with self._lock:
            self._tree = tuple(message.behaviours)
        if self._on_tree is not None:
            self._on_tree(message)
