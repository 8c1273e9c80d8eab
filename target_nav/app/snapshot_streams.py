"""What lets py_trees' watchers look into the running tree: snapshot streams, each with its own topic and parameters.

The names, types and rules are those of py_trees_ros, so an unmodified `py-trees-tree-watcher` attaches:

    ~/snapshot_streams/{open,close,reconfigure}    services
    ~/snapshots                                    the default stream (parameter `default_snapshot_stream`)
    ~/snapshot_streams/_snapshots_<n>              a stream that a watcher opened without naming it

Building and publishing a message happens in a thread of its own, never in the tick: a tick notes what the tree looks
like and goes on. A watcher that hangs delays nobody, and without a stream nothing is built at all.
"""

from __future__ import annotations

import logging
import queue
import sys
import threading
from typing import Any

import py_trees

from target_nav.app.ros_support import RosNode, latched_qos
from target_nav.app.snapshot_messages import SnapshotMessages
from target_nav.app.tick_statistics import TickMeter, TickStatistics
from target_nav.mission.snapshot import SnapshotTracker, TreeSnapshot, snapshot_of

PERIOD_SHARE = 0.98
"""py_trees_ros: a snapshot is due when this share of the period has gone by, for a tick is never exactly on time."""

ONLY_ON_CHANGE = sys.float_info.max
DEFAULT_STREAM = "~/snapshots"
WAITING = 4

log = logging.getLogger(__name__)


class _Stream:
    """One watcher's topic. `publish` is called from the publishing thread only."""

    def __init__(self, ros: RosNode, topic: str, parameters: Any) -> None:
        from py_trees_ros_interfaces.msg import BehaviourTree

        self.topic = topic
        self.parameters = parameters
        self._node = ros.node
        self.publisher = ros.node.create_publisher(BehaviourTree, topic, latched_qos())
        self._last_s: float | None = None

    def due(self, now_s: float, changed: bool) -> bool:
        late = (
            self._last_s is not None
            and now_s - self._last_s >= PERIOD_SHARE * self.parameters.snapshot_period
        )
        if self._last_s is None or changed or late:
            self._last_s = now_s
            return True
        return False

    def close(self) -> None:
        self._node.destroy_publisher(self.publisher)


class SnapshotStreams:
    """The services and the streams of one executor's tree."""

    def __init__(self, ros: RosNode, root: py_trees.behaviour.Behaviour) -> None:
        from py_trees_ros_interfaces.msg import SnapshotStreamParameters
        from py_trees_ros_interfaces.srv import (
            CloseSnapshotStream,
            OpenSnapshotStream,
            ReconfigureSnapshotStream,
        )

        self._ros, self._root = ros, root
        self._tracker = SnapshotTracker()
        self._meter = TickMeter()
        self._messages = SnapshotMessages(ros.clock)
        self._lock = threading.Lock()
        self._streams: dict[str, _Stream] = {}
        self._count = 0
        self._queue: queue.Queue[tuple[TreeSnapshot, list[_Stream], TickStatistics] | None] = queue.Queue(
            WAITING
        )
        self.dropped = 0
        node = ros.node
        node.create_service(OpenSnapshotStream, "~/snapshot_streams/open", self._open)
        node.create_service(CloseSnapshotStream, "~/snapshot_streams/close", self._close)
        node.create_service(ReconfigureSnapshotStream, "~/snapshot_streams/reconfigure", self._reconfigure)
        if node.declare_parameter("default_snapshot_stream", False).value:
            self._add(DEFAULT_STREAM, SnapshotStreamParameters(snapshot_period=ONLY_ON_CHANGE))
        self._thread = threading.Thread(target=self._publish_all, name="snapshots", daemon=True)
        self._thread.start()

    def after_tick(self, begin_s: float, end_s: float) -> None:
        """Note how long the tick took, and what the tree looks like for the streams that are due."""
        self._meter.note(begin_s, end_s)
        with self._lock:
            if not self._streams:
                return
            changed = self._tracker.observe(self._root)
            due = [stream for stream in self._streams.values() if stream.due(begin_s, changed)]
        if not due:
            return
        snapshot = snapshot_of(
            self._root,
            changed=changed,
            blackboard_data=any(stream.parameters.blackboard_data for stream in due),
            blackboard_activity=any(stream.parameters.blackboard_activity for stream in due),
        )
        try:
            self._queue.put_nowait((snapshot, due, self._meter.statistics()))
        except queue.Full:
            self.dropped += 1

    def close(self) -> None:
        self._queue.put(None)
        self._thread.join(timeout=1.0)

    # -- services, in the executor's thread ----------------------------------------------------------------------------

    def _open(self, request: Any, response: Any) -> Any:
        name = request.topic_name
        if not name:
            name = f"~/snapshot_streams/_snapshots_{self._count}"
            self._count += 1
        elif not name.startswith(("/", "~")):
            name = f"~/snapshot_streams/{name}"
        response.topic_name = self._add(name, request.parameters)
        return response

    def _close(self, request: Any, response: Any) -> Any:
        with self._lock:
            stream = self._streams.pop(request.topic_name, None)
        response.result = stream is not None
        if stream is not None:
            stream.close()
            log.info("closed snapshot stream %s", stream.topic)
        return response

    def _reconfigure(self, request: Any, response: Any) -> Any:
        with self._lock:
            stream = self._streams.get(request.topic_name)
            if stream is not None:
                stream.parameters = request.parameters
        response.result = stream is not None
        return response

    def _add(self, name: str, parameters: Any) -> str:
        topic: str = self._ros.node.resolve_topic_name(name)
        with self._lock:
            if topic in self._streams:
                self._streams[topic].parameters = parameters
                return topic
        stream = _Stream(self._ros, topic, parameters)
        with self._lock:
            self._streams[topic] = stream
        log.info("opened snapshot stream %s", topic)
        return topic

    # -- in the publishing thread --------------------------------------------------------------------------------------

    def _publish_all(self) -> None:
        while (item := self._queue.get()) is not None:
            snapshot, streams, statistics = item
            for stream in streams:
                with self._lock:
                    still_open = self._streams.get(stream.topic) is stream
                if still_open:
                    stream.publisher.publish(self._messages.tree(snapshot, stream.parameters, statistics))
