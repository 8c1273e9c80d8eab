"""What py_trees' watchers expect of a stream's name and its publisher."""

from __future__ import annotations

import sys

PERIOD_SHARE = 0.98
"""py_trees_ros: a snapshot is due when this share of the period has gone by, for a tick is never exactly on time."""

ONLY_ON_CHANGE = sys.float_info.max
"""The period of a stream that is published only when something changes."""

SNAPSHOTS = "~/snapshot_streams"
BLACKBOARD = "~/blackboard_streams"
DEFAULT_STREAM = "~/snapshots"


def snapshot_topic(asked: str, number: int) -> str:
    """The topic of a snapshot stream, to be resolved by the node: as asked, below the executor, or numbered."""
    if not asked:
        return f"{SNAPSHOTS}/_snapshots_{number}"
    return asked if asked.startswith(("/", "~")) else f"{SNAPSHOTS}/{asked}"
