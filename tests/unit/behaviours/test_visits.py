"""A visited target is remembered once, and the leaf waits until the tracker has let go of it."""

from __future__ import annotations

from py_trees.common import Status

from behaviours import MarkVisited
from target_nav.state import keys
from tests.utils.board import ScriptedBoard, track_at


def leaf() -> MarkVisited:
    made = MarkVisited("visited")
    made.setup_ports()
    return made


def ticked(made: MarkVisited) -> Status:
    made.tick_once()
    return made.status


def test_the_track_is_remembered_and_then_has_to_go(board: ScriptedBoard) -> None:
    board.write(keys.TRACK, track_at(1.0, 0.5))
    made = leaf()
    assert ticked(made) is Status.RUNNING
    assert board.read(keys.VISITED) == ((1.0, 0.5),)
    assert ticked(made) is Status.RUNNING
    board.write(keys.TRACK, None)
    assert ticked(made) is Status.SUCCESS
    assert board.read(keys.VISITED) == ((1.0, 0.5),)


def test_another_track_will_do_as_well(board: ScriptedBoard) -> None:
    board.write(keys.TRACK, track_at(1.0, 0.5))
    made = leaf()
    ticked(made)
    board.write(keys.TRACK, track_at(2.0, 0.0))
    assert ticked(made) is Status.SUCCESS


def test_visits_add_up(board: ScriptedBoard) -> None:
    made = leaf()
    for x_m in (1.0, 2.0, 3.0):
        board.write(keys.TRACK, track_at(x_m, 0.0))
        ticked(made)
        board.write(keys.TRACK, None)
        assert ticked(made) is Status.SUCCESS
    assert board.read(keys.VISITED) == ((1.0, 0.0), (2.0, 0.0), (3.0, 0.0))
    assert made.feedback_message == "visited 3"


def test_without_a_track_there_is_nothing_to_remember(board: ScriptedBoard) -> None:
    assert ticked(leaf()) is Status.FAILURE
    assert board.read(keys.VISITED) is None
