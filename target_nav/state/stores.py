"""Where values wait between the thread that receives them and the tick that uses them."""

from __future__ import annotations

import threading
from collections import deque
from typing import Generic, TypeVar

T = TypeVar("T")


class LatestStore(Generic[T]):
    """Holds the newest value. `put` from any thread, `latest` from any thread."""

    def __init__(self) -> None:
        self._lock = threading.Lock()
        self._value: T | None = None

    def put(self, value: T) -> None:
        with self._lock:
            self._value = value

    def latest(self) -> T | None:
        with self._lock:
            return self._value


class QueueStore(Generic[T]):
    """Holds all values since the last `take_all`, at most `capacity`: the oldest are dropped and counted."""

    def __init__(self, capacity: int) -> None:
        if capacity < 1:
            raise ValueError(f"capacity is {capacity}; it must be at least 1")
        self._lock = threading.Lock()
        self._values: deque[T] = deque(maxlen=capacity)
        self._dropped = 0

    def put(self, value: T) -> None:
        with self._lock:
            self._dropped += len(self._values) == self._values.maxlen
            self._values.append(value)

    def take_all(self) -> tuple[T, ...]:
        with self._lock:
            values = tuple(self._values)
            self._values.clear()
            return values

    @property
    def dropped(self) -> int:
        with self._lock:
            return self._dropped
