"""Values wait between threads: the newest one, or all of them in order."""

from __future__ import annotations

import threading

import pytest

from target_nav.state.stores import LatestStore, QueueStore


def test_latest_is_none_until_something_was_put() -> None:
    store: LatestStore[int] = LatestStore()
    assert store.latest() is None
    store.put(1)
    store.put(2)
    assert store.latest() == 2
    assert store.latest() == 2


def test_a_queue_gives_everything_once_and_in_order() -> None:
    store: QueueStore[int] = QueueStore(10)
    store.put(1)
    store.put(2)
    assert store.take_all() == (1, 2)
    assert store.take_all() == ()


def test_a_full_queue_drops_the_oldest_and_counts() -> None:
    store: QueueStore[int] = QueueStore(3)
    for n in range(5):
        store.put(n)
    assert store.take_all() == (2, 3, 4)
    assert store.dropped == 2


def test_a_queue_needs_room() -> None:
    with pytest.raises(ValueError, match="capacity is 0"):
        QueueStore(0)


def test_nothing_is_lost_or_doubled_between_two_threads() -> None:
    store: QueueStore[int] = QueueStore(100_000)
    writer = threading.Thread(target=lambda: [store.put(n) for n in range(20_000)])
    writer.start()
    taken: list[int] = []
    while writer.is_alive():
        taken.extend(store.take_all())
    taken.extend(store.take_all())
    assert taken == list(range(20_000))
