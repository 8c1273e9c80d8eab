"""A latched publisher for watchers, that knows whether somebody listens without asking the middleware in a tick."""

from __future__ import annotations

import threading
from typing import Any

from target_nav.app.ros_support import RosNode, latched_qos


class StreamPublisher:
    """Made and closed in the executor's thread, published from the worker's, looked at in the tick's."""

    def __init__(self, ros: RosNode, message_type: Any, topic: str) -> None:
        from rclpy.event_handler import PublisherEventCallbacks

        self.topic = topic
        self.listeners = 0
        self._new_listener = False
        self._node = ros.node
        self._lock = threading.Lock()
        self._publisher: Any = ros.node.create_publisher(
            message_type, topic, latched_qos(), event_callbacks=PublisherEventCallbacks(matched=self._matched)
        )

    def take_new_listener(self) -> bool:
        """Whether somebody began to listen since the last call: who does not care for latched messages gets one."""
        new, self._new_listener = self._new_listener, False
        return new

    def publish(self, message: Any) -> None:
        """May wait for the middleware; a closed one publishes nothing."""
        with self._lock:
            if self._publisher is not None:
                self._publisher.publish(message)

    def close(self) -> None:
        with self._lock:
            publisher, self._publisher = self._publisher, None
        self.listeners = 0
        self._node.destroy_publisher(publisher)

    def _matched(self, event: Any) -> None:
        self.listeners = event.current_count
        if event.current_count_change > 0:
            self._new_listener = True
