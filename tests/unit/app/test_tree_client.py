"""The client of a running executor: finds it, notices that it is gone, and opens a stream of the next one."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import pytest

pytest.importorskip("py_trees_ros_interfaces.srv")

from target_nav.app.tree_client import ABSENT_S, ANSWER_S, OPEN_TYPE, TreeClient

pytestmark = pytest.mark.ros

OPEN = "/tree_executor/snapshot_streams/open"


class Future:
    def __init__(self) -> None:
        self.answer: Any = None

    def done(self) -> bool:
        return self.answer is not None

    def result(self) -> Any:
        return self.answer


class Graph:
    """A node in a graph that the test arranges."""

    def __init__(self) -> None:
        self.services: list[tuple[str, list[str]]] = []
        self.publishers: dict[str, list[bytes]] = {}
        self.asked: list[tuple[str, Any, Future]] = []
        self.subscribed: list[tuple[str, Any]] = []

    def start_executor(self) -> None:
        self.services = [(OPEN, [OPEN_TYPE]), ("/other", ["std_srvs/srv/Empty"])]

    def answer(self, topic: str, gid: bytes) -> None:
        self.publishers[topic] = [gid]
        self.asked[-1][2].answer = SimpleNamespace(topic_name=topic)

    def get_service_names_and_types(self) -> list[tuple[str, list[str]]]:
        return self.services

    def get_publishers_info_by_topic(self, topic: str) -> list[Any]:
        return [SimpleNamespace(endpoint_gid=list(gid)) for gid in self.publishers.get(topic, [])]

    def create_client(self, service_type: Any, name: str) -> Any:
        def call_async(request: Any) -> Future:
            self.asked.append((name, request, Future()))
            return self.asked[-1][2]

        return SimpleNamespace(service_is_ready=lambda: True, call_async=call_async)

    def destroy_client(self, client: Any) -> None: ...

    def create_subscription(self, message_type: Any, topic: str, callback: Any, qos: Any) -> Any:
        self.subscribed.append((topic, callback))
        return self.subscribed[-1]

    def destroy_subscription(self, subscription: Any) -> None:
        self.subscribed.remove(subscription)


@pytest.fixture
def graph() -> Graph:
    return Graph()


@pytest.fixture
def clock() -> list[float]:
    return [100.0]


@pytest.fixture
def client(graph: Graph, clock: list[float]) -> TreeClient:
    return TreeClient(graph, 0.1, clock=lambda: clock[0])  # type: ignore[arg-type]


def connect(graph: Graph, client: TreeClient, gid: bytes = b"a" * 16, topic: str = "/s/_snapshots_0") -> None:
    graph.start_executor()
    client.poll()
    graph.answer(topic, gid)
    client.poll()
    client.poll()


def test_nothing_happens_until_there_is_an_executor(graph: Graph, client: TreeClient) -> None:
    client.poll()
    assert (client.is_open, client.behaviours(), graph.asked) == (False, (), [])


def test_it_opens_a_stream_and_keeps_the_newest_tree(graph: Graph, client: TreeClient) -> None:
    connect(graph, client)
    ((topic, callback),) = graph.subscribed
    assert topic == "/s/_snapshots_0"
    assert graph.asked[0][1].parameters.snapshot_period == 0.1
    for tree in (["a"], ["b", "c"]):
        callback(SimpleNamespace(behaviours=tree))
    assert client.behaviours() == ("b", "c")


def test_discovery_may_be_slow(graph: Graph, client: TreeClient, clock: list[float]) -> None:
    connect(graph, client)
    graph.publishers = {}
    clock[0] += 0.9 * ABSENT_S
    client.poll()
    graph.publishers = {"/s/_snapshots_0": [b"a" * 16]}
    client.poll()
    clock[0] += 0.9 * ABSENT_S
    client.poll()
    assert client.opened == 1
    assert client.is_open


def test_after_a_restart_it_opens_another_stream(
    graph: Graph, client: TreeClient, clock: list[float]
) -> None:
    connect(graph, client)
    graph.publishers, graph.services = {}, []
    clock[0] += ABSENT_S + 0.1
    client.poll()
    assert (client.is_open, graph.subscribed) == (False, [])
    connect(graph, client, b"b" * 16)
    assert (client.is_open, client.opened) == (True, 2)


def test_a_stream_of_the_same_name_that_another_watcher_opened_after_a_restart_is_not_its_own(
    graph: Graph, client: TreeClient, clock: list[float]
) -> None:
    connect(graph, client)
    graph.publishers["/s/_snapshots_0"] = [b"b" * 16]
    clock[0] += ABSENT_S + 0.1
    client.poll()
    client.poll()
    assert len(graph.asked) == 2


def test_a_question_that_died_with_its_executor_is_asked_again(
    graph: Graph, client: TreeClient, clock: list[float]
) -> None:
    graph.start_executor()
    client.poll()
    client.poll()
    assert len(graph.asked) == 1
    clock[0] += ANSWER_S + 0.1
    client.poll()
    client.poll()
    assert len(graph.asked) == 2


def test_closing_asks_the_executor_to_close(graph: Graph, client: TreeClient) -> None:
    connect(graph, client)
    client.close()
    name, request, _ = graph.asked[-1]
    assert (name, request.topic_name) == ("/tree_executor/snapshot_streams/close", "/s/_snapshots_0")
    assert graph.subscribed == []


def test_a_stream_that_is_there_is_neither_opened_nor_closed(graph: Graph, clock: list[float]) -> None:
    client = TreeClient(graph, topic="/tree/snapshots", clock=lambda: clock[0])  # type: ignore[arg-type]
    client.poll()
    assert graph.subscribed[0][0] == "/tree/snapshots"
    client.close()
    assert graph.asked == []
