"""Several targets of one kind, each visited once: what has been visited is not looked at again."""

from __future__ import annotations

from py_trees.common import Status

from behaviours.leaf import MissionLeaf
from target_nav.state import keys


class MarkVisited(MissionLeaf):
    """Remembers the tracked target as visited: from now on it is an obstacle like any other, until the next GO.

    RUNNING until the tracker has let go of it, then SUCCESS; FAILURE without a track.
    """

    INPUT_PORTS = {}
    OUTPUT_PORTS = {}
    READS = (keys.TRACK,)
    WRITES = (keys.VISITED,)

    def initialise(self) -> None:
        self._marked: tuple[float, float] | None = None

    def update(self) -> Status:
        track = self.read(keys.TRACK)
        if self._marked is not None:
            if track is not None and (track.x_m, track.y_m) == self._marked:
                return self.say("waiting for the tracker to let go", Status.RUNNING)
            return self.say(f"visited {len(self.read(keys.VISITED))}", Status.SUCCESS)
        if track is None:
            return self.say("there is no track", Status.FAILURE)
        self._marked = (track.x_m, track.y_m)
        self.write(keys.VISITED, (*(self.read(keys.VISITED) or ()), self._marked))
        return self.say(f"visited the one at {track.x_m:.2f} m, {track.y_m:.2f} m", Status.RUNNING)
