"""The words a mission is written in. `LEAVES` is the vocabulary; a class here is a tag in a mission file."""

from __future__ import annotations

from behaviours.approach import BlindApproach, ConfirmArrival, NavigateToTarget, TargetTracked
from behaviours.guards import InputsFresh, MissionRequested, SetTarget
from behaviours.leaf import MissionLeaf
from behaviours.search import SpiralSearch, TurnSearch
from behaviours.standing import Arrived, GiveUp, HoldStill, Idle

LEAVES: tuple[type[MissionLeaf], ...] = (
    SetTarget,
    MissionRequested,
    InputsFresh,
    TargetTracked,
    TurnSearch,
    SpiralSearch,
    NavigateToTarget,
    BlindApproach,
    ConfirmArrival,
    Arrived,
    GiveUp,
    HoldStill,
    Idle,
)

__all__ = ["LEAVES", *(leaf.__name__ for leaf in LEAVES)]
