"""Names of BehaviorTree.CPP that target_nav knows of but does not have, so that a message can say so."""

from __future__ import annotations

NOT_YET: tuple[str, ...] = (
    "AsyncFallback",
    "AsyncSequence",
    "ConsumeQueue",
    "LoopBool",
    "LoopDouble",
    "LoopInt",
    "LoopString",
    "ManualSelector",
    "ParallelAll",
    "PopFromQueue",
    "Precondition",
    "Script",
    "ScriptCondition",
    "SetBlackboard",
    "SkipUnlessUpdated",
    "Switch2",
    "Switch3",
    "Switch4",
    "Switch5",
    "Switch6",
    "TryCatch",
    "UnsetBlackboard",
    "WaitValueUpdate",
    "WasEntryUpdated",
)

RENAMED: dict[str, str] = {
    "FallbackStar": "Fallback",
    "RetryUntilSuccesful": "RetryUntilSuccessful",
    "SequenceStar": "SequenceWithMemory",
    "SubTreePlus": "SubTree with _autoremap",
}
"""Version 3's names and what version 4 calls them."""

CONDITIONS: tuple[str, ...] = (
    "_failureIf",
    "_successIf",
    "_skipIf",
    "_while",
    "_onSuccess",
    "_onFailure",
    "_onHalted",
    "_post",
)
"""Pre- and postconditions: attributes any node may have there."""
