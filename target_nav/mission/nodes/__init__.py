"""BehaviorTree.CPP's nodes as py_trees behaviours. The class's name is the word in a mission."""

from __future__ import annotations

from target_nav.mission.nodes.base import ControlNode, DecoratorNode, MissionNode
from target_nav.mission.nodes.blackboard import SetBlackboard, UnsetBlackboard
from target_nav.mission.nodes.branching import IfThenElse, WhileDoElse
from target_nav.mission.nodes.halting import halt, halt_tree, is_active
from target_nav.mission.nodes.in_order import (
    AsyncFallback,
    AsyncSequence,
    Fallback,
    Sequence,
    SequenceWithMemory,
)
from target_nav.mission.nodes.leaves import AlwaysFailure, AlwaysSuccess, LeafNode
from target_nav.mission.nodes.loops import LoopBool, LoopDouble, LoopInt, LoopString
from target_nav.mission.nodes.parallel import Parallel, ParallelAll
from target_nav.mission.nodes.reactive import ReactiveFallback, ReactiveSequence
from target_nav.mission.nodes.repetition import KeepRunningUntilFailure, Repeat, RetryUntilSuccessful
from target_nav.mission.nodes.results import ForceFailure, ForceSuccess, Inverter, RunOnce
from target_nav.mission.nodes.scripted import Precondition, Script, ScriptCondition
from target_nav.mission.nodes.subtree import SubTree
from target_nav.mission.nodes.switch import Switch2, Switch3, Switch4, Switch5, Switch6
from target_nav.mission.nodes.ticking import SKIPPED, Visited, tick_node
from target_nav.mission.nodes.timing import Delay, Sleep, Timeout
from target_nav.mission.nodes.try_catch import TryCatch
from target_nav.mission.nodes.updated import SkipUnlessUpdated, WaitValueUpdate, WasEntryUpdated

BUILT_INS: tuple[type[MissionNode], ...] = (
    Sequence,
    AsyncSequence,
    SequenceWithMemory,
    ReactiveSequence,
    Fallback,
    AsyncFallback,
    ReactiveFallback,
    Parallel,
    ParallelAll,
    IfThenElse,
    WhileDoElse,
    TryCatch,
    Switch2,
    Switch3,
    Switch4,
    Switch5,
    Switch6,
    Inverter,
    ForceSuccess,
    ForceFailure,
    RetryUntilSuccessful,
    Repeat,
    KeepRunningUntilFailure,
    Timeout,
    Delay,
    RunOnce,
    Precondition,
    LoopInt,
    LoopBool,
    LoopDouble,
    LoopString,
    SkipUnlessUpdated,
    WaitValueUpdate,
    AlwaysSuccess,
    AlwaysFailure,
    Script,
    ScriptCondition,
    SetBlackboard,
    UnsetBlackboard,
    WasEntryUpdated,
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
    "halt_tree",
    "is_active",
    "tick_node",
    *(node.__name__ for node in BUILT_INS),
]
