"""The monitor as Groot2 sees it, and as a running BehaviorTree.CPP shows itself."""

from __future__ import annotations

import itertools
import json
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from pathlib import Path
from textwrap import dedent

import py_trees
import pytest
from py_trees.behaviour import Behaviour

pytest.importorskip("zmq")
pytest.importorskip("msgpack")

from target_nav.app.groot_monitor import HEARTBEAT_S, GrootMonitor
from target_nav.app.groot_monitor_tree import GrootTree, groot_tree
from target_nav.errors import DeviceError
from target_nav.mission.scripted_mission import ScriptedMission
from target_nav.mission.tree_note import TreeNotebook
from tests.unit.app.groot_client import GrootClient, nodes_of, paths_of
from tests.unit.mission.scenarios import MISSION

PORTS = itertools.count(21_700 + 2 * (hash(time.time_ns()) % 2000), 2)
RUNNING, SUCCESS, FAILURE, IDLE_FROM_RUNNING = 1, 2, 3, 11


class Debugged:
    """A mission that is ticked as the nav core does it, with Groot2 connected."""

    def __init__(self, mission: ScriptedMission) -> None:
        self.mission, self.held, self.pauses, self.now_s = mission, False, 0, 100.0
        self.port = next(PORTS)
        self.monitor = GrootMonitor(
            mission.root, mission.mission.path, self.port, self._hold, self._pause, lambda: self.now_s
        )
        self.groot = GrootClient(self.port)
        self._notebook = TreeNotebook()
        self.uid = {name: uid for uid, (_, name) in nodes_of(self.groot.tree()).items()}

    def _hold(self, held: bool) -> None:
        self.held = held

    def _pause(self) -> None:
        self.pauses += 1

    def tick(self, times: int = 1) -> None:
        for _ in range(times):
            if not self.held:
                self.mission.tick()
            if self.monitor.wants_note():
                self.monitor.take(self._notebook.note(self.mission.root, board=True))

    def status(self, name: str) -> int:
        return self.groot.statuses()[self.uid[name]]

    def close(self) -> None:
        self.groot.close()
        self.monitor.close()


@pytest.fixture
def debugged(tmp_path: Path) -> Iterator[Debugged]:
    path = tmp_path / "mission.xml"
    path.write_text(MISSION, encoding="utf-8")
    with ScriptedMission(path) as mission:
        made = Debugged(mission)
        yield made
        made.close()


def wait(condition: Callable[[], object]) -> None:
    deadline_s = time.monotonic() + 5.0
    while not condition():
        assert time.monotonic() < deadline_s
        time.sleep(0.005)


def test_the_tree_its_statuses_and_what_ended(debugged: Debugged) -> None:
    root = debugged.groot.tree()
    assert paths_of(root) == [("Main", "")]
    assert nodes_of(root)[1] == ("WhileDoElse", "On request")
    assert next(root.iter("TurnSearch")).get("reason") == "{why}"
    debugged.tick()
    assert (debugged.status("MissionRequested"), debugged.status("Idle")) == (FAILURE, RUNNING)
    debugged.mission.say("GO")
    debugged.tick()
    assert (debugged.status("TurnSearch"), debugged.status("Idle")) == (RUNNING, IDLE_FROM_RUNNING)


def test_the_blackboard_by_the_name_of_the_tree(debugged: Debugged) -> None:
    debugged.tick()
    board = debugged.groot.blackboard("Main;nothing")
    assert list(board) == ["Main"]
    assert board["Main"]["command/requested"] is False
    assert board["Main"]["world/obstacles_in_base_m"] == "array of shape (0, 2), float64"
    assert debugged.groot.blackboard("") == {}


def test_nobody_takes_notes_for_groot_that_is_not_there(debugged: Debugged) -> None:
    assert debugged.monitor.wants_note()
    debugged.now_s += HEARTBEAT_S + 0.1
    wait(lambda: not debugged.monitor.wants_note())
    debugged.groot.statuses()
    assert debugged.monitor.wants_note()


def test_a_breakpoint_holds_the_tree_until_it_is_unlocked(debugged: Debugged) -> None:
    debugged.mission.say("GO")
    uid = debugged.uid["TurnSearch"]
    debugged.groot.breakpoint(uid, once=True)
    debugged.tick(3)
    assert debugged.groot.reached() == uid
    assert debugged.held
    assert debugged.mission.request is None
    debugged.groot.unlock(uid)
    assert not debugged.held
    debugged.tick()
    assert debugged.mission.leaf == "TurnSearch"
    assert json.loads(debugged.groot.ask("D")[0]) == []


@pytest.mark.parametrize(("forced", "leaf"), [("SUCCESS", "NavigateToTarget"), ("FAILURE", "TurnSearch")])
def test_a_breakpoint_can_be_unlocked_with_a_result(debugged: Debugged, forced: str, leaf: str) -> None:
    debugged.mission.say("GO")
    uid = debugged.uid["TurnSearch"]
    debugged.groot.breakpoint(uid)
    debugged.tick()
    debugged.groot.reached()
    debugged.groot.unlock(uid, forced, remove=True)
    debugged.tick()
    assert (debugged.mission.status("TurnSearch").name, debugged.mission.leaf) == (forced, leaf)


def test_a_breakpoint_that_stays_holds_again_in_the_next_tick(debugged: Debugged) -> None:
    debugged.mission.say("GO")
    uid = debugged.uid["TurnSearch"]
    debugged.groot.breakpoint(uid)
    for _ in range(3):
        debugged.tick(2)
        assert debugged.groot.reached() == uid
        debugged.groot.unlock(uid)
    # held in the first; later each time one with the node and one held before it
    assert len(debugged.mission.observations) == 1 + 2 + 2


def test_a_forced_result_comes_in_every_tick_until_it_is_removed(debugged: Debugged) -> None:
    debugged.mission.say("GO")
    uid = debugged.uid["TurnSearch"]
    debugged.groot.breakpoint(uid, mode=1, desired_status="SUCCESS")
    debugged.tick(2)
    assert debugged.mission.leaf == "NavigateToTarget"
    (hook,) = json.loads(debugged.groot.ask("D")[0])
    assert (hook["uid"], hook["mode"], hook["desired_status"]) == (uid, 1, "SUCCESS")
    debugged.groot.hook("R", uid=uid, position=0)
    debugged.mission.say("STOP")
    debugged.tick()
    debugged.mission.say("GO")
    debugged.tick()
    assert debugged.mission.leaf == "TurnSearch"


@pytest.mark.parametrize("letter", ["A", "X"])
def test_removing_or_disabling_all_hooks_lets_the_tree_go_on(debugged: Debugged, letter: str) -> None:
    debugged.mission.say("GO")
    debugged.groot.breakpoint(debugged.uid["TurnSearch"])
    debugged.tick()
    assert debugged.held
    debugged.groot.ask(letter)
    assert not debugged.held
    debugged.tick()
    assert debugged.mission.leaf == "TurnSearch"


def test_when_groot_goes_away_at_a_breakpoint_the_mission_stays_paused(debugged: Debugged) -> None:
    debugged.mission.say("GO")
    debugged.groot.breakpoint(debugged.uid["TurnSearch"])
    debugged.tick()
    debugged.now_s += HEARTBEAT_S + 0.1
    wait(lambda: debugged.pauses == 1)
    wait(lambda: not debugged.held)


def test_another_tree_has_another_id_and_no_hooks(debugged: Debugged) -> None:
    before = debugged.groot.tree_id()
    debugged.groot.breakpoint(debugged.uid["TurnSearch"])
    debugged.monitor.watch(debugged.mission.root)
    assert debugged.groot.tree_id() != before
    assert json.loads(debugged.groot.ask("D")[0]) == []


def test_a_tree_that_is_replaced_while_it_is_drawn_is_drawn_anew(
    debugged: Debugged, monkeypatch: pytest.MonkeyPatch
) -> None:
    other = py_trees.behaviours.Running("other")

    def replaced_meanwhile(root: Behaviour, path: Path | None) -> GrootTree:
        drawn = groot_tree(root, path)
        if root is not other:
            debugged.monitor.watch(other)
        return drawn

    monkeypatch.setattr("target_nav.app.groot_monitor.groot_tree", replaced_meanwhile)
    debugged.monitor.watch(debugged.mission.root)
    assert [name for _, name in nodes_of(debugged.groot.tree()).values()] == ["other"]


def test_transitions_while_recording(debugged: Debugged) -> None:
    assert int(debugged.groot.ask("r", b"start")[0]) > 1e15
    debugged.tick()
    debugged.now_s += 0.25
    debugged.mission.say("GO")
    debugged.tick()
    content = debugged.groot.ask("t")[0]
    rows = [content[i : i + 9] for i in range(0, len(content), 9)]
    seen = [(int.from_bytes(r[:6], "little"), int.from_bytes(r[6:8], "little"), r[8]) for r in rows]
    assert (0, debugged.uid["Idle"], RUNNING) in seen
    assert (250_000, debugged.uid["Idle"], 0) in seen
    assert (250_000, debugged.uid["TurnSearch"], RUNNING) in seen
    debugged.groot.ask("r", b"stop")
    debugged.tick(3)
    assert debugged.groot.ask("t")[0] == b""


@pytest.mark.parametrize(
    ("parts", "why"),
    [
        ([b"abc"], b"wrong request header"),
        ([b"\x02Q\0\0\0\0"], b"Request not recognized"),
        ([b"\x02R\0\0\0\0", b'{"uid": 99, "position": 0}'], b"Node ID not found"),
        ([b"\x02R\0\0\0\0"], b"must be 2 parts message"),
        ([b"\x02B\0\0\0\0"], b"must be 2 parts message"),
    ],
)
def test_what_cannot_be_answered_is_refused_as_there(
    debugged: Debugged, parts: list[bytes], why: bytes
) -> None:
    assert debugged.groot.raw(*parts) == [b"error", why]
    assert debugged.groot.statuses()


@pytest.mark.parametrize("content", [b"{", b"[1]", b'{"uid": 1}', b"\xff", b"[]", b"null"])
def test_nonsense_does_not_end_the_monitor(debugged: Debugged, content: bytes) -> None:
    for letter in "IRUDAXrtB":
        debugged.groot.ask(letter, content)
    debugged.tick()
    assert debugged.groot.statuses()


def test_a_port_that_is_taken_is_told(debugged: Debugged) -> None:
    with pytest.raises(DeviceError, match=f"port {debugged.port} for Groot2's monitor cannot be opened"):
        GrootMonitor(debugged.mission.root, None, debugged.port)


def test_a_tree_that_is_not_its_files_any_more_is_shown_without_attributes(debugged: Debugged) -> None:
    path = debugged.mission.mission.path
    path.write_text(MISSION.replace("<Idle/>", "<HoldStill/>"), encoding="utf-8")
    xml = groot_tree(debugged.mission.root, path).xml
    assert "<Idle " in xml
    assert "{why}" not in xml.split("<TreeNodesModel>")[0]


# -- beside BehaviorTree.CPP itself ------------------------------------------------------------------------------------

BOTH = """
<root BTCPP_format="4" main_tree_to_execute="Main">
  <BehaviorTree ID="Main">
    <Sequence name="top">
      <Script code="n:=3; t:='abc'; d:=1.5; x:=7"/>
      <SubTree ID="Sub" name="mine" y="{x}"/>
      <Inverter><SubTree ID="Other" _autoremap="true"/></Inverter>
      <AlwaysFailure name="never"/>
    </Sequence>
  </BehaviorTree>
  <BehaviorTree ID="Sub">
    <Sequence><Script code="q:=y"/><SubTree ID="Other"/></Sequence>
  </BehaviorTree>
  <BehaviorTree ID="Other">
    <Fallback name="either"><AlwaysFailure/><Sleep msec="100000"/></Fallback>
  </BehaviorTree>
</root>
"""

THERE = dedent(
    """
    import os, sys, behaviortreepy as bt
    factory = bt.BehaviorTreeFactory()
    factory.register_behavior_tree_from_text(open(sys.argv[1]).read())
    tree = factory.create_tree("Main")
    publisher = bt.Groot2Publisher(tree, int(sys.argv[2]))
    tree.tick_exactly_once()
    print("ready", flush=True)
    sys.stdin.read()
    os._exit(0)  # its threads do not end by themselves
    """
)


@pytest.fixture
def both(tmp_path: Path) -> Iterator[tuple[GrootClient, GrootClient]]:
    """The same mission, ticked once: here, and in BehaviorTree.CPP."""
    pytest.importorskip("behaviortreepy")
    path = tmp_path / "both.xml"
    path.write_text(BOTH, encoding="utf-8")
    port = next(PORTS)
    there = subprocess.Popen(
        [sys.executable, "-c", THERE, str(path), str(port)], stdin=subprocess.PIPE, stdout=subprocess.PIPE
    )
    try:
        assert there.stdout is not None
        assert there.stdout.readline() == b"ready\n"
        with ScriptedMission(path) as mission:
            made = Debugged(mission)
            made.tick()
            groot = GrootClient(port)
            yield made.groot, groot
            groot.close()
            made.close()
    finally:
        there.kill()
        there.wait()


def test_nodes_and_subtrees_have_the_same_numbers_and_paths(both: tuple[GrootClient, GrootClient]) -> None:
    here, there = (client.tree() for client in both)
    assert nodes_of(here) == nodes_of(there)
    assert sorted(paths_of(here)) == sorted(paths_of(there))
    assert paths_of(here)[0] == paths_of(there)[0]


def test_what_runs_is_the_same(both: tuple[GrootClient, GrootClient]) -> None:
    here, there = (client.statuses() for client in both)
    assert here.keys() == there.keys()
    assert {uid for uid, code in here.items() if code == RUNNING} == {
        uid for uid, code in there.items() if code == RUNNING
    }
    # what has not begun is 0 in both; what has ended keeps its colour here until its parent begins anew
    assert {uid for uid, code in here.items() if code == 0} == {
        uid for uid, code in there.items() if code == 0
    }


def test_the_blackboards_are_the_same(both: tuple[GrootClient, GrootClient]) -> None:
    here, there = (client.blackboard("Main;mine") for client in both)
    # the main board here has the robot's world as well
    own = {key: value for key, value in here["Main"].items() if "/" not in key and key != "config"}
    assert own == there["Main"] == {"n": 3, "t": "abc", "d": 1.5, "x": 7}
    assert here["mine"]["q"] == there["mine"]["q"] == 7


@pytest.mark.parametrize(
    "parts", [[b"abc"], [b"\x02Q\0\0\0\0"], [b"\x02R\0\0\0\0", b'{"uid": 99, "position": 0}']]
)
def test_the_same_questions_are_refused_in_the_same_words(
    both: tuple[GrootClient, GrootClient], parts: list[bytes]
) -> None:
    here, there = (client.raw(*parts) for client in both)
    assert here == there


def test_answers_have_as_many_parts(both: tuple[GrootClient, GrootClient]) -> None:
    questions: list[tuple[str, tuple[bytes, ...]]] = [
        ("T", ()), ("S", ()), ("B", (b"Main",)), ("D", ()), ("A", ()), ("X", ()), ("r", (b"start",)), ("t", ()),
        ("r", (b"stop",)),
    ]  # fmt: skip
    for letter, content in questions:
        here, there = (client.ask(letter, *content) for client in both)
        assert len(here) == len(there), letter
