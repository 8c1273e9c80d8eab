"""What a tick does for watchers: nothing without any, and a note where somebody listens and is due."""

from __future__ import annotations

import sys
from collections.abc import Iterator
from types import SimpleNamespace
from typing import Any

import numpy as np
import py_trees
import pytest
from py_trees.blackboard import ActivityItem, Blackboard

from target_nav.app.blackboard_streams import BlackboardStream, activity_text, variable_names
from target_nav.app.snapshot_streams import SnapshotStream
from target_nav.app.tick_statistics import TickMeter
from target_nav.mission.snapshot_builder import SnapshotBuilder
from target_nav.mission.tree_note import TreeNote, TreeNotebook
from target_nav.state.types import NavState, Pose2D, Twist2D

ONLY_ON_CHANGE = sys.float_info.max


class Publisher:
    """What `StreamPublisher` shows of itself."""

    topic = "/t"

    def __init__(self) -> None:
        self.listeners = 1
        self.new = False
        self.published: list[Any] = []

    def take_new_listener(self) -> bool:
        new, self.new = self.new, False
        return new

    def publish(self, message: Any) -> None:
        self.published.append(message)


class Shared:
    """Gives back what a message would be made of."""

    def message(self, note: TreeNote, series: Any, changed: bool, parameters: Any) -> Any:
        return (note, changed, series.count)


@pytest.fixture(autouse=True)
def _empty_board() -> Iterator[None]:
    Blackboard.clear()
    yield
    Blackboard.clear()


def notes() -> tuple[py_trees.behaviour.Behaviour, TreeNotebook]:
    root = py_trees.composites.Sequence("root", True, [py_trees.behaviours.Running("leaf")])
    root.tick_once()
    return root, TreeNotebook()


def stream(period_s: float) -> tuple[SnapshotStream, Publisher]:
    publisher = Publisher()
    return SnapshotStream(publisher, SimpleNamespace(snapshot_period=period_s), Shared()), publisher  # type: ignore[arg-type]


def test_a_stream_is_due_first_then_on_change_then_when_its_period_is_nearly_over() -> None:
    made, _ = stream(1.0)
    assert [made.due(now_s, False) for now_s in (0.0, 0.5, 0.97, 0.98, 1.5)] == [
        True,
        False,
        False,
        True,
        False,
    ]
    assert made.due(1.6, True)
    assert not made.due(2.5, False)


def test_a_stream_without_a_period_waits_for_a_change() -> None:
    made, _ = stream(ONLY_ON_CHANGE)
    assert [made.due(float(t), t == 50) for t in range(100)] == [t in (0, 50) for t in range(100)]


def test_a_new_listener_gets_one_at_once() -> None:
    made, publisher = stream(ONLY_ON_CHANGE)
    made.due(0.0, False)
    publisher.new = True
    assert [made.due(1.0, False), made.due(2.0, False)] == [True, False]


def test_a_note_that_waits_gives_way_to_a_newer_one_but_not_its_change() -> None:
    root, notebook = notes()
    made, publisher = stream(ONLY_ON_CHANGE)
    meter = TickMeter()
    first, second = notebook.note(root), notebook.note(root)
    assert (first.changed, second.changed) == (True, False)
    for note in (first, second):
        meter.note(0.0, 0.1)
        made.post(note, meter.series())
    made.flush()
    made.flush()
    assert publisher.published == [(second, True, 2)]


def test_series_are_as_they_were_when_taken() -> None:
    meter = TickMeter()
    meter.note(0.0, 0.01)
    meter.note(0.05, 0.08)
    series = meter.series()
    meter.note(0.10, 0.30)
    taken = series.statistics()
    assert (taken.count, taken.duration_s, taken.interval_s) == (2, pytest.approx(0.03), pytest.approx(0.05))
    assert taken.duration_average_s == pytest.approx(0.02)


# -- blackboard --------------------------------------------------------------------------------------------------------


def board_stream(
    *variables: str, visited: bool = False, activity: bool = False
) -> tuple[BlackboardStream, Publisher]:
    publisher = Publisher()
    made = BlackboardStream(publisher, variables, visited, activity, SnapshotBuilder())  # type: ignore[arg-type]
    return made, publisher


def rows(text: str) -> dict[str, str]:
    return {
        name.strip(): value.strip()
        for name, _, value in (line.partition(" : ") for line in text.splitlines())
    }


def test_a_board_is_its_entries_in_order_with_arrays_as_their_shape() -> None:
    root, notebook = notes()
    Blackboard.set("/b", np.zeros((1440, 2)))
    Blackboard.set("/a", Twist2D(0.1))
    text = board_stream()[0].text(notebook.note(root, board=True))
    assert list(rows(text).items()) == [
        ("/a", "Twist2D(vx_mps=0.1, vy_mps=0, wz_radps=0)"),
        ("/b", "array of shape (1440, 2), float64"),
    ]


def test_variables_may_be_nested_lack_their_slash_or_not_be_there() -> None:
    root, notebook = notes()
    Blackboard.set("/robot/pose", Pose2D(1.5))
    made, _ = board_stream("robot/pose.x_m", "/robot/pose.gone", "nothing", "/robot/pose")
    assert rows(made.text(notebook.note(root, board=True))) == {
        "/nothing": "-",
        "/robot/pose": "Pose2D(x_m=1.5, y_m=0, yaw_rad=0)",
        "/robot/pose.gone": "-",
        "/robot/pose.x_m": "1.5",
    }


class Reads(py_trees.behaviour.Behaviour):
    def __init__(self, name: str, key: str) -> None:
        super().__init__(name)
        self.attach_blackboard_client().register_key(key, py_trees.common.Access.READ)

    def update(self) -> py_trees.common.Status:
        return py_trees.common.Status.RUNNING


def test_only_what_the_last_tick_used_if_asked_for() -> None:
    root = py_trees.composites.Selector("root", True, [Reads("one", "/a"), Reads("two", "/b")])
    root.tick_once()
    for key in ("/a", "/b", "/c"):
        Blackboard.set(key, 1)
    note = TreeNotebook().note(root, board=True)
    assert list(rows(board_stream(visited=True)[0].text(note))) == ["/a"]
    assert list(rows(board_stream("/b", "a", visited=True)[0].text(note))) == ["/a"]


def test_a_text_is_published_when_it_changes_or_somebody_new_listens() -> None:
    pytest.importorskip("std_msgs.msg")
    root, notebook = notes()
    made, publisher = board_stream("/a")
    for value in (1, 1, 2):
        Blackboard.set("/a", value)
        made.post(notebook.note(root, board=True))
        made.flush()
    publisher.new = True
    made.post(notebook.note(root, board=True))
    made.flush()
    made.flush()
    assert [rows(message.data) for message in publisher.published] == [{"/a": "1"}, {"/a": "2"}, {"/a": "2"}]


def test_activity_is_that_of_the_entries_shown_and_arrays_are_their_shape() -> None:
    item = ActivityItem("/a", "writer", py_trees.behaviours.Success("x").id, "WRITE", None, np.zeros((9, 2)))
    other = ActivityItem("/b", "writer", item.client_id, "WRITE", None, 3)
    text = activity_text([item, other], {"/a"})
    assert "writer" in text
    assert "/b" not in text
    assert "0." not in text


def test_names_of_entries_with_the_fields_of_what_they_hold() -> None:
    board = {"/pose": Pose2D(), "/state": NavState.IDLE, "/none": None}
    assert list(variable_names(board)) == [
        "/none",
        "/pose",
        "/pose.x_m",
        "/pose.y_m",
        "/pose.yaw_rad",
        "/state",
    ]
