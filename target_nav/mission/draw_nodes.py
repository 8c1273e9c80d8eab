"""What a picture of a mission shows of a node: its name, kind and ports, and the status it had in a recorded tick."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from enum import Enum

from py_trees.common import Status

from target_nav.errors import MissionError
from target_nav.mission.expand import Instance
from target_nav.mission.model import SUBTREE
from target_nav.mission.registry import NodeKind
from target_nav.mission.tree_paths import unique_paths
from target_nav.mission.vocabulary import is_condition

MAX_PORT, MAX_TITLE = 34, 40
"""Characters of a port's line and of a title; what is longer is cut."""


class Kind(str, Enum):
    CONTROL = "control"
    DECORATOR = "decorator"
    SUBTREE = "subtree"
    CONDITION = "condition"
    ACTION = "action"


@dataclass(frozen=True)
class DrawNode:
    """`title` is the name a person gave, `word` the node's own where it is another.

    `status` is None without a recording, INVALID where the tick did not come by.
    """

    title: str
    word: str
    kind: Kind
    symbol: str
    ports: tuple[str, ...]
    status: Status | None
    children: tuple[DrawNode, ...]


_SYMBOLS = {
    "Sequence": "→",
    "AsyncSequence": "→",
    "SequenceWithMemory": "→*",
    "ReactiveSequence": "R→",
    "Fallback": "?",
    "AsyncFallback": "?",
    "ReactiveFallback": "R?",
    "Parallel": "⇉",
    "ParallelAll": "⇉",
    "IfThenElse": "if",
    "WhileDoElse": "while",
    "TryCatch": "try",
}


def drawable(root: Instance, statuses: Mapping[str, str] | None = None) -> DrawNode:
    """The tree for a picture.

    Args:
        root: the mission, written out
        statuses: of one tick, by path as in `tree_paths.paths_of`; those missing were not ticked

    Raises:
        MissionError: a status or a path that the mission does not have.
    """
    paths = instance_paths(root)
    unknown = set(statuses or ()) - set(paths.values())
    if unknown:
        raise MissionError(f"the mission has no node {min(unknown)}; the recording is of another mission")
    try:
        known = {path: Status[name] for path, name in (statuses or {}).items()}
    except KeyError as error:
        raise MissionError(f"there is no status {error.args[0]!r}") from None

    def make(instance: Instance) -> DrawNode:
        definition = instance.definition
        word = "" if definition.name == definition.id else definition.id
        if definition.is_subtree:
            word = f"{SUBTREE} {word}".rstrip()
        return DrawNode(
            title=_cut(definition.name, MAX_TITLE),
            word=_cut(word, MAX_PORT),
            kind=_kind(instance),
            symbol=_SYMBOLS.get(definition.id, "switch" if definition.id.startswith("Switch") else ""),
            ports=tuple(_cut(f"{each.name} {each.value}", MAX_PORT) for each in definition.attributes),
            status=None if statuses is None else known.get(paths[instance], Status.INVALID),
            children=tuple(make(child) for child in instance.children),
        )

    return make(root)


def instance_paths(root: Instance) -> dict[Instance, str]:
    """The paths that `tree_paths.paths_of` gives to the behaviours that are built of these."""
    return dict(
        unique_paths(root, lambda instance: instance.definition.name, lambda instance: instance.children)
    )


def _kind(instance: Instance) -> Kind:
    if instance.spec is None:
        return Kind.SUBTREE
    if instance.spec.kind is NodeKind.CONTROL:
        return Kind.CONTROL
    if instance.spec.kind is NodeKind.DECORATOR:
        return Kind.DECORATOR
    if is_condition(instance.spec) or instance.spec.name in ("ScriptCondition", "WasEntryUpdated"):
        return Kind.CONDITION
    return Kind.ACTION


def _cut(text: str, most: int) -> str:
    one_line = " ".join(text.split())
    return one_line if len(one_line) <= most else f"{one_line[: most - 1]}…"
