"""Blackboard streams: what lets py_trees' blackboard watcher look at all entries, some, or those of the visited path.

    ~/blackboard_streams/{get_variables,open,close}    services
    ~/blackboard_streams/_watcher_<n>                  std_msgs/String, latched, published when the text changes

As in py_trees_ros; a variable may be nested (`/target/track.x_m`) and the leading `/` left out. A tick only hands over
references to the values; texts are made in the worker's thread, and only for streams that have a subscriber.
"""

from __future__ import annotations

import dataclasses
import logging
import threading
from collections.abc import Iterable, Mapping, Sequence
from typing import Any

from py_trees import console, display
from py_trees.blackboard import ActivityItem, ActivityStream, Blackboard

from target_nav.app.ros_support import RosNode
from target_nav.app.stream_names import BLACKBOARD
from target_nav.app.stream_publisher import StreamPublisher
from target_nav.app.stream_worker import StreamWorker
from target_nav.mission.snapshot_builder import SnapshotBuilder
from target_nav.mission.tree_note import TreeNote
from target_nav.mission.values_text import value_text

MAX_NESTED = 3

log = logging.getLogger(__name__)


class BlackboardStream:
    """One watcher's topic. `post` in the tick's thread, `flush` in the worker's."""

    def __init__(
        self,
        publisher: StreamPublisher,
        variables: Sequence[str],
        only_visited: bool,
        with_activity: bool,
        builder: SnapshotBuilder,
    ) -> None:
        self.publisher = publisher
        self.with_activity = with_activity
        self._variables = tuple(dict.fromkeys(absolute(name) for name in variables))
        self._only_visited = only_visited
        self._builder = builder
        self._lock = threading.Lock()
        self._pending: TreeNote | None = None
        self._last_text: str | None = None

    @property
    def topic(self) -> str:
        return self.publisher.topic

    def post(self, note: TreeNote) -> None:
        with self._lock:
            self._pending = note

    def flush(self) -> None:
        from std_msgs.msg import String

        with self._lock:
            note, self._pending = self._pending, None
        if note is None:
            return
        text = self.text(note)
        if self.publisher.take_new_listener() or text != self._last_text:
            self._last_text = text
            self.publisher.publish(String(data=text))

    def text(self, note: TreeNote) -> str:
        board = note.board or {}
        names = self._names(note, board)
        text = board_text((name, self._value(name, board)) for name in names)
        if not self.with_activity:
            return text
        keys = {name.split(".")[0] for name in names}
        return f"{_title('Blackboard Data')}{text}\n{activity_text(note.activity, keys)}"

    def _names(self, note: TreeNote, board: Mapping[str, Any]) -> list[str]:
        if not self._only_visited:
            return sorted(self._variables or board)
        visited = self._builder.visited_keys(note)
        if not self._variables:
            return visited
        return sorted(name for name in self._variables if name.split(".")[0] in visited)

    def _value(self, name: str, board: Mapping[str, Any]) -> str:
        if "." not in name:
            return self._builder.texts.of(name, board)
        key, *attributes = name.split(".")
        try:
            value = board[key]
            for attribute in attributes:
                value = getattr(value, attribute)
        except (KeyError, AttributeError):
            return "-"
        return value_text(value)


class BlackboardStreams:
    """The services and the streams of one executor."""

    def __init__(self, ros: RosNode, worker: StreamWorker, builder: SnapshotBuilder) -> None:
        from py_trees_ros_interfaces.srv import (
            CloseBlackboardStream,
            GetBlackboardVariables,
            OpenBlackboardStream,
        )

        self._ros, self._worker, self._builder = ros, worker, builder
        self._streams: dict[str, BlackboardStream] = {}
        self._count = 0
        node = ros.node
        node.create_service(GetBlackboardVariables, f"{BLACKBOARD}/get_variables", self._get_variables)
        node.create_service(OpenBlackboardStream, f"{BLACKBOARD}/open", self._open)
        node.create_service(CloseBlackboardStream, f"{BLACKBOARD}/close", self._close)

    # -- in the tick's thread ------------------------------------------------------------------------------------------

    def watched(self) -> list[BlackboardStream]:
        """The streams that somebody listens to."""
        return [stream for stream in tuple(self._streams.values()) if stream.publisher.listeners]

    def post(self, streams: list[BlackboardStream], note: TreeNote) -> None:
        for stream in streams:
            stream.post(note)
            self._worker.wake(stream)

    # -- services, in the executor's thread ----------------------------------------------------------------------------

    def _get_variables(self, request: Any, response: Any) -> Any:
        response.variables = list(variable_names(dict(Blackboard.storage)))
        return response

    def _open(self, request: Any, response: Any) -> Any:
        from std_msgs.msg import String

        topic = self._ros.node.resolve_topic_name(f"{BLACKBOARD}/_watcher_{self._count}")
        self._count += 1
        self._streams[topic] = BlackboardStream(
            StreamPublisher(self._ros, String, topic),
            request.variables,
            request.filter_on_visited_path,
            request.with_activity_stream,
            self._builder,
        )
        log.info("opened blackboard stream %s", topic)
        response.topic = topic
        return response

    def _close(self, request: Any, response: Any) -> Any:
        response.result = self._worker.end(self._streams.pop(request.topic_name, None))
        return response


def absolute(name: str) -> str:
    return Blackboard.absolute_name("/", name)


def variable_names(board: Mapping[str, Any]) -> Iterable[str]:
    """Entries in order, each followed by the fields of what it holds, as `/target/track.x_m`."""
    for key in sorted(board):
        yield key
        yield from _nested(key, board[key], MAX_NESTED)


def _nested(name: str, value: Any, depth: int) -> Iterable[str]:
    if depth and dataclasses.is_dataclass(value) and not isinstance(value, type):
        for field in dataclasses.fields(value):
            yield f"{name}.{field.name}"
            yield from _nested(f"{name}.{field.name}", getattr(value, field.name), depth - 1)


def board_text(entries: Iterable[tuple[str, str]]) -> str:
    rows = list(entries)
    width = max((len(name) for name, _ in rows), default=0)
    return "\n".join(
        f"    {console.cyan}{name:<{width}}{console.reset} : {console.yellow}{value}{console.reset}"
        for name, value in rows
    )


def activity_text(items: Iterable[ActivityItem], keys: set[str]) -> str:
    """What was done to the `keys` in the last tick."""
    stream = ActivityStream()
    for item in items:
        if item.key in keys:
            shown = ActivityItem(
                item.key,
                item.client_name,
                item.client_id,
                item.activity_type,
                None if item.previous_value is None else value_text(item.previous_value),
                None if item.current_value is None else value_text(item.current_value),
            )
            stream.push(shown)
    return str(display.unicode_blackboard_activity_stream(activity_stream=stream.data, indent=0))


def _title(text: str) -> str:
    return f"{console.green}{text}{console.reset}\n"
