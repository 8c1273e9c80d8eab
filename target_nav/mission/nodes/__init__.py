"""BehaviorTree.CPP's nodes as py_trees behaviours. The class's name is the word in a mission."""

from __future__ import annotations

from target_nav.mission.nodes.base import (
    SKIPPED,
    ControlNode,
    DecoratorNode,
    MissionNode,
    Visited,
    halt,
    is_active,
    tick_node,
)
from target_nav.mission.nodes.branching import IfThenElse, WhileDoElse
from target_nav.mission.nodes.in_order import Fallback, Sequence, SequenceWithMemory
from target_nav.mission.nodes.leaves import AlwaysFailure, AlwaysSuccess, LeafNode
from target_nav.mission.nodes.parallel import Parallel
from target_nav.mission.nodes.reactive import ReactiveFallback, ReactiveSequence
from target_nav.mission.nodes.repetition import KeepRunningUntilFailure, Repeat, RetryUntilSuccessful
from target_nav.mission.nodes.results import ForceFailure, ForceSuccess, Inverter, RunOnce
from target_nav.mission.nodes.subtree import SubTree
from target_nav.mission.nodes.timing import Delay, Sleep, Timeout

BUILT_INS: tuple[type[MissionNode], ...] = (
    Sequence,
    SequenceWithMemory,
    ReactiveSequence,
    Fallback,
    ReactiveFallback,
    Parallel,
    IfThenElse,
    WhileDoElse,
    Inverter,
    ForceSuccess,
    ForceFailure,
    RetryUntilSuccessful,
    Repeat,
    KeepRunningUntilFailure,
    Timeout,
    Delay,
    RunOnce,
    AlwaysSuccess,
    AlwaysFailure,
    Sleep,
)
"""All but SubTree, which is no word by itself: it names a tree."""

__all__ = [
    "BUILT_INS",
    "SKIPPED",
    "ControlNode",
    "DecoratorNode",
    "LeafNode",
    "MissionNode",
    "SubTree",
    "Visited",
    "halt",
    "is_active",
    "tick_node",
    *(node.__name__ for node in BUILT_INS),
]
