"""A mission loaded in the place of another: nothing of the old one is left, and a broken one changes nothing."""

from __future__ import annotations

from pathlib import Path

import pytest
from py_trees.behaviour import Behaviour
from py_trees.blackboard import Blackboard
from py_trees.common import Status

from target_nav.errors import MissionError
from target_nav.mission import LoadedMission, load_mission
from target_nav.mission.replace import replace_mission
from target_nav.state import keys
from tests.unit.mission.scripted import document
from tests.utils.board import ScriptedBoard

FIRST = document(
    """
    <Sequence>
      <HoldStill name="first" reason="{why}"/>
      <SubTree ID="T" why="{why}" limit="3"/>
    </Sequence>
    """,
    """
    <BehaviorTree ID="T">
      <Timeout msec="{limit}"><HoldStill reason="{why}"/></Timeout>
    </BehaviorTree>
    """,
)
SECOND = document(
    '<Sequence><InputsFresh reason="{why}"/><HoldStill name="second" reason="{why}"/></Sequence>'
)


@pytest.fixture
def path(tmp_path: Path, board: ScriptedBoard) -> Path:
    path = tmp_path / "mission.xml"
    path.write_text(FIRST, encoding="utf-8")
    return path


def own_entries() -> dict[str, object]:
    table = {key.name for key in keys.ALL}
    return {path: value for path, value in Blackboard.storage.items() if path not in table}


def replace(path: Path, old: Behaviour, provided: tuple[str, ...] = ()) -> LoadedMission:
    def swap(new: LoadedMission) -> None:
        old.stop(Status.INVALID)

    return replace_mission(path, old, swap, provided_keys=provided)


def test_the_board_is_as_if_the_new_mission_had_been_the_first(path: Path) -> None:
    old = load_mission(path, provided_keys=["/why"]).root
    Blackboard.set("/why", "of the old mission")
    old.tick_once()
    path.write_text(SECOND, encoding="utf-8")
    new = replace(path, old)
    assert own_entries() == {}
    clients = {client.id() for node in new.root.iterate() for client in node.blackboards}
    for entry, users in Blackboard.metadata.items():
        others = (users.read | users.write | users.exclusive) - clients
        assert others <= {id_ for id_, name in Blackboard.clients.items() if name == "nav loop"}, entry


def test_the_new_mission_is_loaded_like_any_other(path: Path) -> None:
    old = load_mission(path, provided_keys=["/why"]).root
    loaded_first = sorted(map(repr, own_entries().values()))
    again = replace(path, old, ("/why",))
    assert sorted(map(repr, own_entries().values())) == loaded_first
    assert [node.name for node in again.root.iterate()] == [node.name for node in old.iterate()]
    assert again.root is not old


def test_what_others_provide_stays(path: Path) -> None:
    old = load_mission(path, provided_keys=["/why"]).root
    Blackboard.set("/why", "given from outside")
    new = replace(path, old, ("/why",))
    new.root.tick_once()
    assert Blackboard.get(keys.REQUEST.name).reason == "given from outside"


def test_the_old_mission_is_halted_on_its_own_entries(path: Path) -> None:
    old = load_mission(path, provided_keys=["/why"]).root
    Blackboard.set("/why", "old")
    old.tick_once()
    seen: list[object] = []
    leaf = next(node for node in old.iterate() if node.name == "first")
    leaf.terminate = lambda status: seen.append((status, Blackboard.get("/why")))  # type: ignore[method-assign]
    path.write_text(SECOND, encoding="utf-8")
    replace(path, old)
    assert seen == [(Status.INVALID, "old")]


@pytest.mark.parametrize("text", ["<root", SECOND.replace("InputsFresh", "InputsFersh"), ""])
def test_a_broken_mission_changes_nothing(path: Path, text: str) -> None:
    old = load_mission(path, provided_keys=["/why"]).root
    Blackboard.set("/why", "old")
    old.tick_once()
    before, clients = dict(Blackboard.storage), dict(Blackboard.clients)
    path.write_text(text, encoding="utf-8")
    with pytest.raises(MissionError):
        replace(path, old)
    assert dict(Blackboard.storage) == before
    assert dict(Blackboard.clients) == clients
    assert old.status is Status.RUNNING


def test_a_hundred_reloads_leave_no_more_than_one(path: Path) -> None:
    root = load_mission(path, provided_keys=["/why"]).root
    sizes = []
    for _ in range(100):
        root = replace(path, root, ("/why",)).root
        sizes.append((len(Blackboard.storage), len(Blackboard.metadata), len(Blackboard.clients)))
    assert len(set(sizes)) == 1
