"""The mission's tree as it ticks: statuses with a mark that needs no colour, and what each behaviour says."""

from __future__ import annotations

from dataclasses import dataclass

from target_nav.gui.source import World
from target_nav.state.snapshots import NodeStatus, TreeRow

MARK = {
    NodeStatus.INVALID: "·",
    NodeStatus.RUNNING: "▶",
    NodeStatus.SUCCESS: "✔",
    NodeStatus.FAILURE: "✘",
}


@dataclass(frozen=True)
class TreeRowView:
    """`status` is INVALID, RUNNING, SUCCESS or FAILURE; `active`: the last tick passed through it."""

    name: str
    word: str
    depth: int
    status: str
    mark: str
    active: bool
    feedback: str


@dataclass(frozen=True)
class TreeView:
    """Rows depth first. `current` is the index of the running behaviour farthest down, -1 if there is none."""

    rows: tuple[TreeRowView, ...]
    current: int
    hidden: int
    tick: int
    age_s: float
    fresh: bool
    paused: bool
    message: str


def tree_view(world: World) -> TreeView:
    state, nav = world.tree.value, world.nav.value
    rows = tuple(_row(row) for row in state.rows) if state is not None else ()
    current = -1
    for index, row in enumerate(rows):
        if row.status == NodeStatus.RUNNING.name and row.active and _is_leaf(rows, index):
            current = index
    return TreeView(
        rows=rows,
        current=current,
        hidden=max(0, state.total - len(rows)) if state is not None else 0,
        tick=state.tick if state is not None else 0,
        age_s=world.tree.age_s,
        fresh=world.tree.fresh,
        paused=nav.paused if nav is not None else False,
        message=world.tree.excuse,
    )


def shown_rows(view: TreeView, most: int) -> tuple[TreeRowView, ...]:
    """At most `most` rows for a small screen: the running path first, then what lies nearest to it, in their order."""
    if len(view.rows) <= most:
        return view.rows
    on_path = path_to(view, view.current)
    keep = set(on_path[-most:])
    centre = view.current if view.current >= 0 else 0
    by_distance = sorted(range(len(view.rows)), key=lambda i: (not view.rows[i].active, abs(i - centre)))
    for index in by_distance:
        if len(keep) >= most:
            break
        keep.add(index)
    return tuple(view.rows[i] for i in sorted(keep))


def path_to(view: TreeView, index: int) -> list[int]:
    """Indices from the root to the row at `index`; none for -1."""
    path: list[int] = []
    wanted = view.rows[index].depth if index >= 0 else -1
    for i in range(index, -1, -1):
        if view.rows[i].depth == wanted:
            path.append(i)
            wanted -= 1
    return path[::-1]


def _row(row: TreeRow) -> TreeRowView:
    return TreeRowView(
        row.name, row.word, row.depth, row.status.name, MARK[row.status], row.active, row.feedback
    )


def _is_leaf(rows: tuple[TreeRowView, ...], index: int) -> bool:
    return index + 1 == len(rows) or rows[index + 1].depth <= rows[index].depth
