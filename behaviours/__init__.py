"""The words a mission is written in. `LEAVES` is the vocabulary; a class here is a tag in a mission file."""

from __future__ import annotations

from behaviours.approach import BlindApproach, ConfirmArrival, NavigateToTarget, TargetTracked
from behaviours.guards import InputsFresh, MissionRequested, SetTarget
from behaviours.leaf import MissionLeaf
from behaviours.places import GoToPoint
from behaviours.search import LookRound, SpiralSearch, TurnSearch
from behaviours.standing import Arrived, GiveUp, HoldStill, Idle
from behaviours.visits import MarkVisited

LEAVES: tuple[type[MissionLeaf], ...] = (
    SetTarget,
    MissionRequested,
    InputsFresh,
    TargetTracked,
    TurnSearch,
    LookRound,
    SpiralSearch,
    NavigateToTarget,
    BlindApproach,
    ConfirmArrival,
    GoToPoint,
    MarkVisited,
    Arrived,
    GiveUp,
    HoldStill,
    Idle,
)

__all__ = ["LEAVES", *(leaf.__name__ for leaf in LEAVES)]
