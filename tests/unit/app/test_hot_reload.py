"""A mission's file that changes: taken when the robot stands, or on command; a broken one changes nothing."""

from __future__ import annotations

import os
import time
from collections.abc import Callable, Iterator
from pathlib import Path

import py_trees
import pytest
from py_trees.behaviour import Behaviour

from target_nav.app.hot_reload import STILL_S, Finding, HotReload, MissionChecker, ReloadMode
from target_nav.app.nav_core import NavCore
from target_nav.config import Config
from target_nav.mission import load_mission
from target_nav.state.types import Command, CommandKind, NavState, TickRecord
from tests.unit.app.test_nav_core import PERIOD_S, ScriptedWorld
from tests.unit.mission.scripted import document

MOVES = document(
    """
    <WhileDoElse>
      <MissionRequested/>
      <TurnSearch name="one"/>
      <Idle name="waiting"/>
    </WhileDoElse>
    """
)
OTHER = MOVES.replace('name="one"', 'name="two"').replace('name="waiting"', 'name="waiting too"')
BROKEN = MOVES.replace("TurnSearch", "TurnSerch")


def write(path: Path, text: str) -> None:
    """As an editor does it, with a time that differs from the last one for sure."""
    path.write_text(text, encoding="utf-8")
    stamp_ns = time.time_ns() + write.count * 10_000_000  # type: ignore[attr-defined]
    write.count += 1  # type: ignore[attr-defined]
    os.utime(path, ns=(stamp_ns, stamp_ns))


write.count = 1  # type: ignore[attr-defined]


# -- looking at files --------------------------------------------------------------------------------------------------


@pytest.fixture
def path(tmp_path: Path) -> Path:
    path = tmp_path / "mission.xml"
    path.write_text(MOVES, encoding="utf-8")
    return path


@pytest.fixture
def checker(path: Path) -> MissionChecker:
    return MissionChecker(path, [path])


def looks(checker: MissionChecker, times: int) -> list[Finding | None]:
    return [checker.look(asked=False) for _ in range(times)]


def test_nothing_is_found_while_nothing_changes(checker: MissionChecker) -> None:
    assert looks(checker, 3) == [None] * 3


def test_a_change_is_found_once_and_only_when_it_has_settled(path: Path, checker: MissionChecker) -> None:
    write(path, OTHER[:100])
    assert looks(checker, 1) == [None]
    write(path, OTHER)
    assert looks(checker, 4) == [None, Finding(), None, None]


def test_what_is_wrong_is_found_with_its_place(path: Path, checker: MissionChecker) -> None:
    write(path, BROKEN)
    _, found, again = looks(checker, 3)
    assert found is not None
    assert again is None
    (problem,) = found.problems
    assert problem.startswith(f"{path}:")
    assert "did you mean" in problem


def test_a_file_that_is_gone_for_good_is_wrong(path: Path, checker: MissionChecker) -> None:
    path.unlink()
    found = looks(checker, 2)[1]
    assert found is not None
    assert found.problems


def test_what_was_put_back_is_nothing_to_be_taken(path: Path, checker: MissionChecker) -> None:
    write(path, BROKEN)
    looks(checker, 2)
    write(path, MOVES)
    assert looks(checker, 2) == [None, Finding.SAME]
    write(path, OTHER)
    assert looks(checker, 2) == [None, Finding()]
    checker.take()
    write(path, OTHER)
    assert looks(checker, 2) == [None, Finding.SAME]


def test_asked_for_the_files_are_checked_even_if_they_did_not_change(checker: MissionChecker) -> None:
    assert checker.look(asked=True) == Finding(at_once=True)


def test_included_files_are_looked_at_too(tmp_path: Path, path: Path) -> None:
    part = tmp_path / "part.xml"
    part.write_text(
        document('<BehaviorTree ID="Part"><HoldStill/></BehaviorTree>', main=None), encoding="utf-8"
    )
    path.write_text(
        '<root BTCPP_format="4" main_tree_to_execute="Main"><include path="part.xml"/>'
        '<BehaviorTree ID="Main"><SubTree ID="Part"/></BehaviorTree></root>',
        encoding="utf-8",
    )
    checker = MissionChecker(path, [path])
    checker.look(asked=True)
    write(part, part.read_text(encoding="utf-8").replace("HoldStill", "Idle"))
    assert [found for found in looks(checker, 3) if found] == [Finding()]


# -- swapping ----------------------------------------------------------------------------------------------------------


class Running:
    """A core that ticks a mission of which the file may change. Files are looked at in every tick."""

    def __init__(self, path: Path, mode: ReloadMode) -> None:
        py_trees.blackboard.Blackboard.clear()
        self.path, self.world = path, ScriptedWorld()
        mission = load_mission(path)
        self.core = NavCore(Config(), mission.root, self.world, self.world, self.world)
        self.watched: list[Behaviour] = []
        self.reload = HotReload(mission, self.core, self.watched.append, mode, period_s=0.002)
        self.now_s = 10.0
        self.records: list[TickRecord] = []

    def tick(self, *said: CommandKind) -> TickRecord:
        self.world.commands = list(said)
        self.now_s += PERIOD_S
        record = self.core.tick(self.now_s)
        self.reload.after_tick(record)
        self.records.append(record)
        return record

    def tick_until(self, condition: Callable[[], bool], patience_s: float = 10.0) -> int:
        """How many ticks it took; each leaves the thread time for a look."""
        deadline_s = time.monotonic() + patience_s
        count = 0
        while not condition():
            assert time.monotonic() < deadline_s
            self.tick()
            count += 1
            time.sleep(0.002)
        return count

    def ready(self) -> bool:
        return self.reload._ready is not None


@pytest.fixture
def make(path: Path) -> Iterator[Callable[[ReloadMode], Running]]:
    made: list[Running] = []

    def start(mode: ReloadMode = ReloadMode.STILL) -> Running:
        made.append(Running(path, mode))
        return made[-1]

    yield start
    for each in made:
        each.reload.close()
        each.core.close()


MakeRunning = Callable[..., Running]


def test_a_changed_file_is_taken_once_the_robot_has_stood_for_a_second(make: MakeRunning) -> None:
    running = make()
    write(running.path, OTHER)
    running.tick_until(lambda: running.reload.swaps == 1)
    assert running.now_s - 10.0 >= STILL_S
    assert running.tick().running_leaf == "waiting too"
    assert running.watched == [running.core.root]


def test_while_the_robot_moves_it_waits_and_after_the_swap_it_waits_for_go(make: MakeRunning) -> None:
    running = make()
    running.tick(CommandKind.GO)
    write(running.path, OTHER)
    running.tick_until(running.ready)
    for _ in range(60):
        assert running.tick().running_leaf == "one"
    running.tick(CommandKind.STOP)
    assert running.tick_until(lambda: running.reload.swaps == 1) >= STILL_S / PERIOD_S - 2
    assert running.tick().running_leaf == "waiting too"
    assert running.tick(CommandKind.GO).running_leaf == "two"


def test_reload_takes_it_at_once_and_the_robot_brakes_to_a_stand(make: MakeRunning) -> None:
    running = make()
    running.tick(CommandKind.GO)
    for _ in range(20):
        running.tick()
    assert running.records[-1].sent.wz_radps > 0.0
    write(running.path, OTHER)
    running.tick(CommandKind.RELOAD)
    running.tick_until(lambda: running.reload.swaps == 1)
    after = [running.tick() for _ in range(20)]
    assert {record.state for record in after} == {NavState.IDLE}
    rates = [record.sent.wz_radps for record in after]
    assert rates == sorted(rates, reverse=True)
    assert rates[-1] == 0.0


def test_on_command_only_a_changed_file_waits_for_the_command(make: MakeRunning) -> None:
    running = make(ReloadMode.COMMAND)
    write(running.path, OTHER)
    running.tick_until(running.ready)
    for _ in range(60):
        running.tick()
    assert running.reload.swaps == 0
    running.tick(CommandKind.RELOAD)
    running.tick_until(lambda: running.reload.swaps == 1)


def test_a_broken_file_changes_nothing_and_says_so(
    make: MakeRunning, caplog: pytest.LogCaptureFixture
) -> None:
    running = make()
    write(running.path, BROKEN)
    running.tick_until(lambda: "has errors and is not taken" in caplog.text)
    assert "unknown node TurnSerch" in caplog.text
    root = running.core.root
    for _ in range(60):
        assert running.tick().running_leaf == "waiting"
    running.tick(CommandKind.RELOAD)
    running.tick_until(lambda: caplog.text.count("has errors and is not taken") == 2)
    assert (running.core.root, running.reload.swaps) == (root, 0)


def test_a_file_that_breaks_again_before_its_turn_is_not_taken(make: MakeRunning) -> None:
    running = make()
    running.tick(CommandKind.GO)
    write(running.path, OTHER)
    running.tick_until(running.ready)
    write(running.path, BROKEN)
    running.tick_until(lambda: not running.ready())
    running.tick(CommandKind.STOP)
    for _ in range(60):
        running.tick()
    assert running.reload.swaps == 0


def test_a_file_that_breaks_in_the_last_moment_changes_nothing(
    make: MakeRunning, caplog: pytest.LogCaptureFixture
) -> None:
    running = make()
    running.reload.checker.problems = list  # type: ignore[method-assign]
    root = running.core.root
    write(running.path, BROKEN)
    running.tick(CommandKind.RELOAD)
    running.tick_until(lambda: "has errors and is not taken" in caplog.text)
    assert running.core.root is root
    assert running.tick().running_leaf == "waiting"


# -- single steps ------------------------------------------------------------------------------------------------------


def test_a_step_is_one_tick_of_the_tree_and_then_a_pause(make: MakeRunning) -> None:
    running = make()
    running.tick(CommandKind.GO)
    ticks = [running.world.published[-1].tick]
    for said in ((CommandKind.STEP,), (), (), (CommandKind.STEP,), (CommandKind.RESUME,), ()):
        running.tick(*said)
        ticks.append(running.world.published[-1].tick)
    assert [tick - ticks[0] for tick in ticks] == [0, 1, 1, 1, 2, 3, 4]


def test_after_a_step_the_robot_stands(make: MakeRunning) -> None:
    running = make()
    running.tick(CommandKind.GO)
    assert running.tick(CommandKind.STEP).requested.wz_radps > 0.0
    assert running.tick().requested.wz_radps == 0.0
    assert running.world.published[-1].reason == "paused"


# -- another mission ---------------------------------------------------------------------------------------------------


def say_load(running: Running, name: str) -> None:
    running.core.operator.obey(Command(running.now_s, CommandKind.LOAD, name))


def test_another_mission_is_taken_when_it_is_asked_for_and_waits_for_go(
    make: MakeRunning, tmp_path: Path
) -> None:
    running = make()
    other = tmp_path / "other.xml"
    write(other, OTHER)
    say_load(running, str(other))
    running.tick_until(lambda: running.reload.swaps == 1)
    assert running.tick().running_leaf == "waiting too"
    assert running.core.mission_name == "other"
    assert running.world.published[-1].notice == "mission other loaded; it waits for GO"
    write(other, MOVES)
    running.tick_until(lambda: running.reload.swaps == 2)
    assert running.tick().running_leaf == "waiting", "its file is the one that is watched now"


@pytest.mark.parametrize("content", [BROKEN, None])
def test_another_mission_that_is_wrong_or_not_there_is_told_and_the_present_one_stays(
    make: MakeRunning, tmp_path: Path, content: str | None
) -> None:
    running = make()
    other = tmp_path / "other.xml"
    if content is not None:
        write(other, content)
    say_load(running, str(other))
    running.tick_until(lambda: "other.xml has errors" in running.core.operator.notice)
    for _ in range(30):
        running.tick()
    assert running.reload.swaps == 0
    write(running.path, OTHER)
    running.tick_until(lambda: running.reload.swaps == 1)
    assert running.core.mission_name == running.path.stem
