"""Snapshot streams: what lets py_trees' tree watcher look into the running tree, each stream with its own parameters.

The names, types and rules are those of py_trees_ros, so an unmodified `py-trees-tree-watcher` attaches:

    ~/snapshot_streams/{open,close,reconfigure}    services
    ~/snapshots                                    the default stream (parameter `default_snapshot_stream`)
    ~/snapshot_streams/_snapshots_<n>              a stream that a watcher opened without naming it

A tick only notes what the tree looks like (`tree_note`), and that only for streams that have a subscriber and are due.
Snapshots and messages are made in the worker's thread (`stream_worker`).
"""

from __future__ import annotations

import logging
import threading
from typing import Any

from target_nav.app.ros_support import RosNode
from target_nav.app.snapshot_messages import SnapshotMessages
from target_nav.app.stream_names import (
    DEFAULT_STREAM,
    ONLY_ON_CHANGE,
    PERIOD_SHARE,
    SNAPSHOTS,
    snapshot_topic,
)
from target_nav.app.stream_publisher import StreamPublisher
from target_nav.app.stream_worker import StreamWorker
from target_nav.app.tick_statistics import TickSeries
from target_nav.mission.snapshot_builder import SnapshotBuilder
from target_nav.mission.tree_note import TreeNote

log = logging.getLogger(__name__)


class SnapshotStream:
    """One watcher's topic. `due` and `post` in the tick's thread, `flush` in the worker's."""

    def __init__(self, publisher: StreamPublisher, parameters: Any, shared: SharedSnapshots) -> None:
        self.parameters = parameters
        self.publisher = publisher
        self._shared = shared
        self._lock = threading.Lock()
        self._pending: tuple[TreeNote, TickSeries, bool] | None = None
        self._last_s: float | None = None

    @property
    def topic(self) -> str:
        return self.publisher.topic

    def due(self, now_s: float, changed: bool) -> bool:
        period_s = self.parameters.snapshot_period
        first = self.publisher.take_new_listener() or self._last_s is None
        if first or changed or now_s - (self._last_s or 0.0) >= PERIOD_SHARE * period_s:
            self._last_s = now_s
            return True
        return False

    def post(self, note: TreeNote, series: TickSeries) -> None:
        """The newest note takes the place of one that still waits, but a change is not forgotten."""
        with self._lock:
            changed = note.changed or (self._pending is not None and self._pending[2])
            self._pending = (note, series, changed)

    def flush(self) -> None:
        with self._lock:
            pending, self._pending = self._pending, None
        if pending is not None:
            self.publisher.publish(self._shared.message(*pending, self.parameters))


class SharedSnapshots:
    """Snapshots and messages for all streams, in the worker's thread: what several watchers ask for is made once."""

    def __init__(self, messages: SnapshotMessages) -> None:
        self._messages = messages
        self.builder = SnapshotBuilder()
        self._made: tuple[TreeNote, Any] | None = None

    def message(self, note: TreeNote, series: TickSeries, changed: bool, parameters: Any) -> Any:
        if self._made is None or self._made[0] is not note:
            self._made = (note, self.builder.build(note))
        return self._messages.tree(self._made[1], parameters, series.statistics(), changed)


class SnapshotStreams:
    """The services and the streams of one executor."""

    def __init__(self, ros: RosNode, worker: StreamWorker) -> None:
        from py_trees_ros_interfaces.msg import BehaviourTree, SnapshotStreamParameters
        from py_trees_ros_interfaces.srv import (
            CloseSnapshotStream,
            OpenSnapshotStream,
            ReconfigureSnapshotStream,
        )

        self._ros, self._worker = ros, worker
        self.shared = SharedSnapshots(SnapshotMessages(ros.clock))
        self._message_type = BehaviourTree
        self._streams: dict[str, SnapshotStream] = {}
        self._count = 0
        node = ros.node
        node.create_service(OpenSnapshotStream, f"{SNAPSHOTS}/open", self._open)
        node.create_service(CloseSnapshotStream, f"{SNAPSHOTS}/close", self._close)
        node.create_service(ReconfigureSnapshotStream, f"{SNAPSHOTS}/reconfigure", self._reconfigure)
        if node.declare_parameter("default_snapshot_stream", False).value:
            self._add(DEFAULT_STREAM, SnapshotStreamParameters(snapshot_period=ONLY_ON_CHANGE))

    # -- in the tick's thread ------------------------------------------------------------------------------------------

    def watched(self) -> list[SnapshotStream]:
        """The streams that somebody listens to."""
        # a copy is one step of the interpreter, so no lock is needed that a service might be holding
        return [stream for stream in tuple(self._streams.values()) if stream.publisher.listeners]

    def post(self, streams: list[SnapshotStream], note: TreeNote, series: TickSeries, now_s: float) -> None:
        """Hand the note to those of the streams that are due."""
        for stream in streams:
            if stream.due(now_s, note.changed):
                stream.post(note, series)
                self._worker.wake(stream)

    # -- services, in the executor's thread ----------------------------------------------------------------------------

    def _open(self, request: Any, response: Any) -> Any:
        name = snapshot_topic(request.topic_name, self._count)
        self._count += not request.topic_name
        response.topic_name = self._add(name, request.parameters)
        return response

    def _close(self, request: Any, response: Any) -> Any:
        response.result = self._worker.end(self._streams.pop(request.topic_name, None))
        return response

    def _reconfigure(self, request: Any, response: Any) -> Any:
        stream = self._streams.get(request.topic_name)
        if stream is not None:
            stream.parameters = request.parameters
        response.result = stream is not None
        return response

    def _add(self, name: str, parameters: Any) -> str:
        topic: str = self._ros.node.resolve_topic_name(name)
        if topic in self._streams:
            self._streams[topic].parameters = parameters
        else:
            publisher = StreamPublisher(self._ros, self._message_type, topic)
            self._streams[topic] = SnapshotStream(publisher, parameters, self.shared)
            log.info("opened snapshot stream %s", topic)
        return topic
