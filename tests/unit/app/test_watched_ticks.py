"""What a tick does for watchers: nothing while nobody listens, one note however many do, nothing once they are gone."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from types import SimpleNamespace
from typing import Any

import py_trees
import pytest
from py_trees.blackboard import Blackboard

pytestmark = pytest.mark.ros
pytest.importorskip("rclpy")
pytest.importorskip("py_trees_ros_interfaces.srv")

from target_nav.app.ros_clock import RosClock  # noqa: E402
from target_nav.app.tree_streams import TreeStreams  # noqa: E402
from target_nav.mission.tree_note import TreeNote, TreeNotebook  # noqa: E402

FAST = SimpleNamespace(snapshot_period=0.0, blackboard_data=True, blackboard_activity=True)
SNAPSHOTS, BOARDS = "~/snapshot_streams", "~/blackboard_streams"


class Node:
    """The services and publishers that the streams make, without a middleware."""

    def __init__(self) -> None:
        self.services: dict[str, Callable[[Any, Any], Any]] = {}
        self.matched: dict[str, Callable[[Any], None]] = {}
        self.destroyed = 0

    def create_service(self, service_type: Any, name: str, callback: Callable[[Any, Any], Any]) -> None:
        self.services[name] = callback

    def declare_parameter(self, name: str, default: Any) -> Any:
        return SimpleNamespace(value=default)

    def resolve_topic_name(self, name: str) -> str:
        return name.replace("~", "/executor")

    def create_publisher(self, message_type: Any, topic: str, qos: Any, *, event_callbacks: Any) -> Any:
        self.matched[topic] = event_callbacks.matched
        return SimpleNamespace(publish=lambda message: None)

    def destroy_publisher(self, publisher: Any) -> None:
        self.destroyed += 1


class Executor:
    """A ticked tree with its streams; `notes` are those that its ticks took."""

    def __init__(self, monkeypatch: pytest.MonkeyPatch) -> None:
        self.node = Node()
        self.root = py_trees.composites.Sequence("root", True, [py_trees.behaviours.Running("leaf")])
        self.streams = TreeStreams(SimpleNamespace(node=self.node, clock=RosClock(on_step=print)), self.root)  # type: ignore[arg-type]
        self.notes: list[TreeNote] = []
        note = TreeNotebook.note

        def noted(notebook: TreeNotebook, *args: Any, **kinds: Any) -> TreeNote:
            self.notes.append(note(notebook, *args, **kinds))
            return self.notes[-1]

        monkeypatch.setattr(TreeNotebook, "note", noted)
        self._now_s = 0.0

    def ticks(self, count: int) -> int:
        """How many notes so many ticks take."""
        before = len(self.notes)
        for _ in range(count):
            self._now_s += 0.05
            self.root.tick_once()
            self.streams.after_tick(self._now_s, self._now_s)
        return len(self.notes) - before

    def open(self, service: str, **request: Any) -> str:
        answer = self.node.services[f"{service}/open"](SimpleNamespace(**request), SimpleNamespace())
        return str(getattr(answer, "topic_name", "") or answer.topic)

    def close(self, service: str, topic: str) -> None:
        self.node.services[f"{service}/close"](SimpleNamespace(topic_name=topic), SimpleNamespace())

    def listeners(self, topic: str, count: int, change: int) -> None:
        self.node.matched[topic](SimpleNamespace(current_count=count, current_count_change=change))


@pytest.fixture
def executor(monkeypatch: pytest.MonkeyPatch) -> Iterator[Executor]:
    Blackboard.clear()
    made = Executor(monkeypatch)
    yield made
    made.streams.close()
    Blackboard.disable_activity_stream()
    Blackboard.clear()


def test_without_a_stream_a_tick_takes_no_note(executor: Executor) -> None:
    assert executor.ticks(5) == 0
    assert Blackboard.activity_stream is None


def test_a_stream_that_nobody_listens_to_costs_as_little(executor: Executor) -> None:
    topic = executor.open(SNAPSHOTS, topic_name="", parameters=FAST)
    assert executor.ticks(5) == 0
    executor.listeners(topic, 1, 1)
    assert executor.ticks(5) == 5
    executor.listeners(topic, 0, -1)
    assert executor.ticks(5) == 0
    assert Blackboard.activity_stream is None


def test_many_watchers_share_one_note(executor: Executor) -> None:
    for _ in range(3):
        executor.listeners(executor.open(SNAPSHOTS, topic_name="", parameters=FAST), 1, 1)
    board = executor.open(BOARDS, variables=[], filter_on_visited_path=False, with_activity_stream=True)
    executor.listeners(board, 2, 2)
    assert executor.ticks(5) == 5
    assert executor.notes[-1].board is not None


def test_closed_streams_cost_nothing(executor: Executor) -> None:
    snapshots = [executor.open(SNAPSHOTS, topic_name="", parameters=FAST) for _ in range(3)]
    board = executor.open(BOARDS, variables=[], filter_on_visited_path=False, with_activity_stream=True)
    for topic in (*snapshots, board):
        executor.listeners(topic, 1, 1)
    assert executor.ticks(2) == 2
    assert Blackboard.activity_stream is not None
    for topic in snapshots:
        executor.close(SNAPSHOTS, topic)
    executor.close(BOARDS, board)
    assert executor.ticks(5) == 0
    assert Blackboard.activity_stream is None, "py_trees writes nothing down any more"
    assert executor.node.destroyed == 4
