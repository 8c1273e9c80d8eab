"""The running executor under a person's hand: pause, single step and reload over services and the command line."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

from tests.utils.processes import Managed, ros_environment, running, wait_until

pytestmark = [pytest.mark.ros, pytest.mark.linux, pytest.mark.slow]
pytest.importorskip("rclpy")
pytest.importorskip("py_trees_ros_interfaces.srv")

from std_msgs.msg import String  # noqa: E402
from std_srvs.srv import Trigger  # noqa: E402

from target_nav.ipc import channels  # noqa: E402
from tests.integration.test_tree_executor import EXECUTOR, ONLY_ON_CHANGE, Client  # noqa: E402
from tests.unit.mission.scripted import document  # noqa: E402

PREFIX = "test_control"
MISSION = document(
    """
    <WhileDoElse>
      <MissionRequested/>
      <HoldStill name="on request" reason="first version"/>
      <Idle/>
    </WhileDoElse>
    """
)


@pytest.fixture
def mission(tmp_path: Path) -> Path:
    path = tmp_path / "mission.xml"
    path.write_text(MISSION, encoding="utf-8")
    return path


@pytest.fixture
def executor(mission: Path, tmp_path: Path) -> Iterator[Managed]:
    with running(EXECUTOR, "--prefix", PREFIX, "--mission", str(mission), "--go", folder=tmp_path) as process:
        yield process


@pytest.fixture
def client(executor: Managed) -> Iterator[Client]:
    stranger = Client()
    yield stranger
    stranger.close()


def say(word: str) -> None:
    command = [sys.executable, "-m", "target_nav.app.cli", "say", word, "--prefix", PREFIX]
    subprocess.run(command, check=True, env=ros_environment(), timeout=30.0)


def trigger(client: Client, name: str) -> Any:
    return client.call(Trigger, f"/tree_executor/{name}", Trigger.Request())


def reason(states: list[Any]) -> str:
    return str(json.loads(states[-1].data)["reason"]) if states else ""


def over_services(client: Client, word: str) -> None:
    answer = trigger(client, word)
    assert (answer.success, answer.message) == (True, f"{word.upper()} is in force with the next tick")


def over_the_command_line(client: Client, word: str) -> None:
    say(word)


@pytest.mark.parametrize("tell", [over_services, over_the_command_line])
def test_pause_step_and_resume(client: Client, tell: Any) -> None:
    with channels.open_reader(channels.NAV, prefix=PREFIX) as nav:

        def ticks_of_the_tree() -> int:
            snapshot = nav.latest()
            assert snapshot is not None
            return snapshot.tick

        states = client.listen(String, "/nav_state", 10)
        client.spin_until(lambda: reason(states) == "first version", "the mission")
        tell(client, "pause")
        client.spin_until(lambda: reason(states) == "paused", "the pause")
        before = ticks_of_the_tree()
        for number in range(1, 4):
            tell(client, "step")
            client.spin_until(lambda: ticks_of_the_tree() > before + number - 1, "a step")  # noqa: B023
            states.clear()
            client.spin_until(lambda: len(states) > 2, "some time")
            assert ticks_of_the_tree() == before + number
        tell(client, "resume")
        client.spin_until(lambda: reason(states) == "first version", "the mission again")
        assert ticks_of_the_tree() > before + 3


def test_a_changed_file_is_taken_while_the_robot_holds_still_and_watchers_see_it(
    client: Client, executor: Managed, mission: Path
) -> None:
    topic, trees = client.open_stream(snapshot_period=ONLY_ON_CHANGE)
    states = client.listen(String, "/nav_state", 10)
    client.spin_until(lambda: trees, "the first tree")
    mission.write_text(MISSION.replace("on request", "another").replace("first", "second"), encoding="utf-8")
    client.spin_until(lambda: "loaded anew" in executor.log(), "the new mission")
    client.spin_until(lambda: any(b.name == "another" for b in trees[-1].behaviours), "its tree")
    assert trees[-1].changed
    client.spin_until(lambda: reason(states) == "waiting for GO", "an idle robot")
    say("go")
    client.spin_until(lambda: reason(states) == "second version", "the new mission at work")
    assert topic


def test_a_broken_file_is_told_by_the_service_and_the_log_and_changes_nothing(
    client: Client, executor: Managed, mission: Path
) -> None:
    states = client.listen(String, "/nav_state", 10)
    client.spin_until(lambda: reason(states) == "first version", "the mission")
    mission.write_text(MISSION.replace("<Idle/>", "<Idel/>"), encoding="utf-8")
    answer = trigger(client, "reload")
    assert not answer.success
    assert f"{mission}:" in answer.message
    assert "unknown node Idel" in answer.message
    wait_until(lambda: "has errors and is not taken" in executor.log(), "the log to say so")
    states.clear()
    client.spin_until(lambda: len(states) > 5, "more states")
    assert {reason([state]) for state in states} == {"first version"}
    mission.write_text(MISSION, encoding="utf-8")
    assert trigger(client, "reload").success
    client.spin_until(lambda: reason(states) == "waiting for GO", "the mission taken anew")


def test_reload_from_the_command_line(client: Client, executor: Managed, mission: Path) -> None:
    say("reload")
    client.spin_until(lambda: "loaded anew" in executor.log(), "the mission")


def test_groot_holds_the_robot_at_a_breakpoint_and_forces_results(mission: Path, tmp_path: Path) -> None:
    pytest.importorskip("zmq")
    pytest.importorskip("msgpack")
    from tests.unit.app.groot_client import GrootClient, nodes_of

    port = 20_000 + os.getpid() % 10_000
    options = (
        "--prefix",
        PREFIX,
        "--mission",
        str(mission),
        "--go",
        "--ros-args",
        "-p",
        f"groot_port:={port}",
    )
    with running(EXECUTOR, *options, folder=tmp_path) as process:
        groot, stranger = GrootClient(port), Client()
        states = stranger.listen(String, "/nav_state", 10)
        stranger.spin_until(lambda: reason(states) == "first version", "the mission")
        uid = {name: number for number, (_, name) in nodes_of(groot.tree()).items()}["on request"]
        assert groot.statuses()[uid] in (0, 1)
        stranger.spin_until(lambda: groot.statuses()[uid] == 1, "the leaf to be shown as running")
        groot.breakpoint(uid)
        assert groot.reached() == uid
        stranger.spin_until(lambda: reason(states) == "held by a debugger", "the robot to be held")
        groot.ask("A")
        stranger.spin_until(lambda: reason(states) == "first version", "the mission again")
        # the operator said GO; forced, the condition says that nobody did
        assert groot.blackboard("Main")["Main"]["command/requested"] is True
        requested = {name: number for number, (_, name) in nodes_of(groot.tree()).items()}["MissionRequested"]
        groot.breakpoint(requested, mode=1, desired_status="FAILURE")
        stranger.spin_until(lambda: reason(states) == "waiting for GO", "the forced result to count")
        groot.hook("R", uid=requested, position=0)
        stranger.spin_until(lambda: reason(states) == "first version", "the real one again")
        stranger.close()
        groot.close()
    assert "Traceback" not in process.log()


def test_without_the_parameter_nobody_listens_for_groot(executor: Managed) -> None:
    assert "Groot2" not in executor.log()


def test_an_operators_stop_also_ends_a_position_move(client: Client) -> None:
    """Zero velocities leave one alone, for the nav process sends them while it wants nothing."""
    heard = client.listen(String, "/arduino/cmd", 10)
    client.spin_until(lambda: client.node.count_publishers("/arduino/cmd") == 1, "the executor's topic")
    say("pause")
    client.spin_until(lambda: True, "a turn of the executor")
    assert not heard

    def stopped() -> bool:
        # Again: that the topic is known here is not yet that this node is known there.
        say("stop")
        return bool(heard)

    client.spin_until(stopped, "STOP")
    assert {message.data for message in heard} == {"STOP"}
