"""Names of BehaviorTree.CPP that are not words here: those of conditions, and those a message must say something of."""

from __future__ import annotations

NOT_HERE: dict[str, str] = {
    "ConsumeQueue": "use LoopDouble or LoopString",
    "ManualSelector": "use a Switch, and write its variable",
    "PopFromQueue": "use LoopDouble or LoopString",
    "QueueSize": "use LoopDouble or LoopString",
}
"""What is no built-in there either but in a header or an example, and what does its work here."""

RENAMED: dict[str, str] = {
    "FallbackStar": "Fallback",
    "RetryUntilSuccesful": "RetryUntilSuccessful",
    "SequenceStar": "SequenceWithMemory",
    "SubTreePlus": "SubTree with _autoremap",
}
"""Version 3's names and what version 4 calls them."""

PRECONDITIONS: tuple[str, ...] = ("_failureIf", "_successIf", "_skipIf", "_while")
POSTCONDITIONS: tuple[str, ...] = ("_onHalted", "_onFailure", "_onSuccess", "_post")
CONDITIONS: tuple[str, ...] = (*PRECONDITIONS, *POSTCONDITIONS)
"""Attributes that any node may have, each a script; in the order in which they are looked at."""
