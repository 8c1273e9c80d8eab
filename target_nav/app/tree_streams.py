"""Everything by which others look into the running tree, behind one call after each tick.

Without a watcher that call is a few comparisons. With one it takes a note (`tree_note`): lists of references, made in
the time of a tenth of a tick. All else happens in the worker's thread.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Protocol

from py_trees.behaviour import Behaviour
from py_trees.blackboard import ActivityItem, Blackboard

from target_nav.app.blackboard_streams import BlackboardStreams
from target_nav.app.ros_support import RosNode
from target_nav.app.snapshot_streams import SnapshotStreams
from target_nav.app.stream_worker import StreamWorker
from target_nav.app.tick_statistics import TickMeter
from target_nav.mission.tree_note import TreeNote, TreeNotebook


class NoteTaker(Protocol):
    """Another kind of watcher, called in the tick's thread. `watch` tells of another tree."""

    def watch(self, root: Behaviour) -> None: ...

    def wants_note(self) -> bool: ...

    def take(self, note: TreeNote) -> None: ...


class TreeStreams:
    """Snapshot streams, blackboard streams and note takers of one executor."""

    def __init__(self, ros: RosNode, root: Behaviour) -> None:
        self._root = root
        self._takers: tuple[NoteTaker, ...] = ()
        self._notebook = TreeNotebook()
        self._meter = TickMeter()
        self._worker = StreamWorker()
        self._snapshots = SnapshotStreams(ros, self._worker)
        self._blackboard = BlackboardStreams(ros, self._worker, self._snapshots.shared.builder)

    def replace_tree(self, root: Behaviour) -> None:
        """Watch another tree from the next tick on."""
        self._root = root
        for taker in self._takers:
            taker.watch(root)

    def add(self, taker: NoteTaker) -> None:
        self._takers = (*self._takers, taker)

    def after_tick(self, begin_s: float, end_s: float) -> None:
        """Note how long the tick took, and what the tree looks like for whoever is watching."""
        self._meter.note(begin_s, end_s)
        snapshots, boards = self._snapshots.watched(), self._blackboard.watched()
        takers = [taker for taker in self._takers if taker.wants_note()]
        activity = self._activity(
            any(stream.parameters.blackboard_activity for stream in snapshots)
            or any(stream.with_activity for stream in boards)
        )
        if not snapshots and not boards and not takers:
            return
        board = bool(boards or takers) or any(stream.parameters.blackboard_data for stream in snapshots)
        note = self._notebook.note(self._root, board=board, activity=activity)
        self._snapshots.post(snapshots, note, self._meter.series(), begin_s)
        self._blackboard.post(boards, note)
        for taker in takers:
            taker.take(note)

    def close(self) -> None:
        self._worker.close()

    @staticmethod
    def _activity(wanted: bool) -> Sequence[ActivityItem]:
        """What was done to the blackboard in this tick; py_trees writes it down only while somebody wants it."""
        stream = Blackboard.activity_stream
        if wanted and stream is None:
            Blackboard.enable_activity_stream()
        elif not wanted and stream is not None:
            Blackboard.disable_activity_stream()
        elif stream is not None:
            items, stream.data = stream.data, []
            return items
        return ()
