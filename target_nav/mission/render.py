"""A tree as text for a terminal, through py_trees' own display; as it stands, or as a recording says it stood."""

from __future__ import annotations

from collections.abc import Mapping
from uuid import UUID

from py_trees import behaviours, common, composites, decorators, display
from py_trees.behaviour import Behaviour
from py_trees.common import Status


def paths_of(root: Behaviour) -> dict[UUID, str]:
    """Each behaviour's path by its id: names from the root down, `#2` where siblings share one.

    `/Main/Find/TurnSearch`. The same file gives the same paths in every run, which ids do not.
    """
    paths: dict[UUID, str] = {}
    taken: set[str] = set()

    def collect(node: Behaviour, prefix: str) -> None:
        path = unique = f"{prefix}/{node.name}"
        number = 2
        while unique in taken:
            unique, number = f"{path}#{number}", number + 1
        taken.add(unique)
        paths[node.id] = unique
        for child in node.children:
            collect(child, unique)

    collect(root, "")
    return paths


def render_text(root: Behaviour, statuses: Mapping[str, str] | None = None, unicode: bool = True) -> str:
    """The tree, a line a behaviour, with the status of those that have one.

    KeyError for a status name that py_trees does not know.

    Args:
        statuses: path (see `paths_of`) to status name, of a recorded tick; None: the tree's present statuses and
            messages
        unicode: marks for a terminal that shows them; plain ASCII otherwise. Colours are py_trees' decision: they
            come when standard output is a terminal.
    """
    draw = display.unicode_tree if unicode else display.ascii_tree
    drawn = root if statuses is None else _recorded(root, statuses, paths_of(root))
    seen: dict[UUID, Status] = {
        node.id: node.status for node in drawn.iterate() if node.status is not Status.INVALID
    }
    return draw(drawn, visited=seen)


def _recorded(node: Behaviour, statuses: Mapping[str, str], paths: Mapping[UUID, str]) -> Behaviour:
    """A stand-in for `node` that py_trees draws alike, with the status that was recorded."""
    children = [_recorded(child, statuses, paths) for child in node.children]
    stand_in: Behaviour
    if isinstance(node, composites.Sequence):
        stand_in = composites.Sequence(node.name, node.memory, children)
    elif isinstance(node, composites.Selector):
        stand_in = composites.Selector(node.name, node.memory, children)
    elif isinstance(node, composites.Composite):
        stand_in = composites.Parallel(node.name, common.ParallelPolicy.SuccessOnAll(), children)
    elif isinstance(node, decorators.Decorator):
        stand_in = decorators.PassThrough(node.name, children[0])
    else:
        stand_in = behaviours.Dummy(node.name)
    stand_in.status = Status[statuses.get(paths[node.id], Status.INVALID.name)]
    return stand_in
