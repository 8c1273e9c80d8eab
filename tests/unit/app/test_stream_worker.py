"""Watchers are served in a thread of their own, each once for however often it was woken."""

from __future__ import annotations

import threading
from collections.abc import Iterator

import pytest

from target_nav.app.stream_names import snapshot_topic
from target_nav.app.stream_worker import StreamWorker


class Recorded:
    """Counts its turns; one that is held blocks the worker, as a hanging watcher would."""

    def __init__(self, topic: str, held: bool = False) -> None:
        self.topic = topic
        self.turns = 0
        self.publisher = self
        self.is_closed = False
        self.began = threading.Event()
        self.go_on = threading.Event()
        self.done = threading.Semaphore(0)
        if not held:
            self.go_on.set()

    def close(self) -> None:
        self.is_closed = True

    def flush(self) -> None:
        self.began.set()
        assert self.go_on.wait(5.0)
        self.turns += 1
        self.done.release()


@pytest.fixture
def worker() -> Iterator[StreamWorker]:
    made = StreamWorker()
    yield made
    made.close()


def test_a_stream_that_is_woken_again_and_again_while_one_hangs_has_one_turn(worker: StreamWorker) -> None:
    hanging, other = Recorded("/hanging", held=True), Recorded("/other")
    worker.wake(hanging)
    assert hanging.began.wait(5.0)
    for _ in range(1000):
        worker.wake(other)
        worker.wake(hanging)
    hanging.go_on.set()
    assert other.done.acquire(timeout=5.0)
    assert hanging.done.acquire(timeout=5.0)
    assert hanging.done.acquire(timeout=5.0)
    assert (other.turns, hanging.turns) == (1, 2)


def test_what_one_stream_does_wrong_does_not_end_the_others(
    worker: StreamWorker, caplog: pytest.LogCaptureFixture
) -> None:
    class Broken(Recorded):
        def flush(self) -> None:
            super().flush()
            raise RuntimeError("no such message")

    broken, other = Broken("/broken"), Recorded("/other")
    worker.wake(broken)
    worker.wake(other)
    assert other.done.acquire(timeout=5.0)
    assert "stream /broken: RuntimeError('no such message')" in caplog.text


def test_a_stream_that_was_closed_has_no_turn(worker: StreamWorker) -> None:
    hanging, closed, last = Recorded("/hanging", held=True), Recorded("/closed"), Recorded("/last")
    for stream in (hanging, closed, last):
        worker.wake(stream)
    assert hanging.began.wait(5.0)
    assert worker.end(closed)
    assert closed.is_closed
    assert not worker.end(None)
    hanging.go_on.set()
    assert last.done.acquire(timeout=5.0)
    assert closed.turns == 0


@pytest.mark.parametrize(
    ("asked", "topic"),
    [
        ("", "~/snapshot_streams/_snapshots_3"),
        ("mine", "~/snapshot_streams/mine"),
        ("/elsewhere/mine", "/elsewhere/mine"),
        ("~/mine", "~/mine"),
    ],
)
def test_names_of_streams(asked: str, topic: str) -> None:
    assert snapshot_topic(asked, 3) == topic
