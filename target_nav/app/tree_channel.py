"""The mission's tree in shared memory, for screens without ROS: ten times a second, in a thread of its own.

The tick's thread only keeps a note that it takes for other watchers as well; texts and bytes are made here.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence

from py_trees.behaviour import Behaviour
from py_trees.common import Status

from target_nav.app.stream_worker import StreamWorker
from target_nav.ipc import channels
from target_nav.ipc.seqlock import Writer
from target_nav.mission.tree_note import TreeNote
from target_nav.state.snapshots import NodeStatus, TreeRow, TreeState

PERIOD_S = 0.1 - 0.01
"""Every second tick of 20 Hz."""

_STATUS = {
    Status.INVALID: NodeStatus.INVALID,
    Status.RUNNING: NodeStatus.RUNNING,
    Status.SUCCESS: NodeStatus.SUCCESS,
    Status.FAILURE: NodeStatus.FAILURE,
}


class TreeChannel:
    """A note taker of `TreeStreams`. Raises DeviceError if another process writes the channel."""

    topic = "tree channel"

    def __init__(self, prefix: str, clock: Callable[[], float] = time.monotonic) -> None:
        self._writer = channels.open_writer(channels.TREE, prefix=prefix)
        self._worker = StreamWorker()
        self._clock = clock
        self._next_s = 0.0
        self._ticks = 0
        self._note: tuple[TreeNote, float, int] | None = None
        self._nodes: Sequence[Behaviour] = ()
        self._layout: list[tuple[int, str, str, int]] = []

    @property
    def publisher(self) -> Writer[TreeState]:
        return self._writer

    # -- in the tick's thread ------------------------------------------------------------------------------------------

    def watch(self, root: Behaviour) -> None:
        """Another tree: the next note brings it along."""

    def wants_note(self) -> bool:
        self._ticks += 1
        now_s = self._clock()
        if now_s < self._next_s:
            return False
        self._next_s = now_s + PERIOD_S
        return True

    def take(self, note: TreeNote) -> None:
        self._note = (note, self._clock(), self._ticks)
        self._worker.wake(self)

    def close(self) -> None:
        self._worker.close()
        self._writer.close()

    # -- in the worker's thread ----------------------------------------------------------------------------------------

    def flush(self) -> None:
        waiting, self._note = self._note, None
        if waiting is None:
            return
        note, stamp_s, tick = waiting
        if note.nodes is not self._nodes:
            self._nodes = note.nodes
            self._layout = depth_first(note)
        visited = set(map(id, note.visited))
        rows = tuple(
            TreeRow(
                name,
                word,
                depth,
                _STATUS[note.statuses[index]],
                id(note.nodes[index]) in visited,
                note.messages[index] or "",
            )
            for index, name, word, depth in self._layout[: channels.MAX_TREE_ROWS]
        )
        self._writer.write(TreeState(stamp_s, tick, len(self._layout), rows))


def depth_first(note: TreeNote) -> list[tuple[int, str, str, int]]:
    """(index into the note's lists, name, word, depth) of every behaviour, a parent before its children."""
    index = {id(node): i for i, node in enumerate(note.nodes)}
    rows: list[tuple[int, str, str, int]] = []
    waiting = [(note.root, 0)]
    while waiting:
        node, depth = waiting.pop()
        rows.append((index[id(node)], node.name, type(node).__name__, depth))
        waiting += [(child, depth + 1) for child in reversed(node.children)]
    return rows
