"""Who stops the wheels when a process or the cable goes: measured from the loss to the moment the motors are off.

Figures are printed (`-s`) and stand in docs/measurements.md; what is asserted leaves room for a machine that is busy.
"""

from __future__ import annotations

import json
import signal
import time
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest

from target_nav.app.arduino_sim import ArduinoSim
from target_nav.app.ros_convert import twist_to_msg
from target_nav.app.ros_support import RosNode, command_qos
from target_nav.state.types import Twist2D
from tests.unit.mission.scripted import document
from tests.utils.processes import Managed, ros_environment, running, wait_until

pytestmark = [pytest.mark.ros, pytest.mark.linux, pytest.mark.slow]

ARDUINO = "target_nav.app.arduino_node"
PREFIX = "test_stops"
FORWARD = Twist2D(0.2, 0.0, 0.0)
ROOM_S = 0.7
"""For the machine, on top of what it should take."""

TURNING = document(
    """
    <WhileDoElse>
      <MissionRequested/>
      <TurnSearch time_limit_s="60"/>
      <Idle/>
    </WhileDoElse>
    """
)


@pytest.fixture
def robot(tmp_path: Path) -> Iterator[ArduinoSim]:
    ros_environment()
    robot = ArduinoSim(tmp_path / "arduino")
    yield robot
    robot.close()


@pytest.fixture
def drive(robot: ArduinoSim, node: Managed) -> Iterator[Callable[[], None]]:
    """Publishes /cmd_vel until the wheels turn."""
    with RosNode("test_host") as ros:
        from geometry_msgs.msg import Twist

        publish = ros.publisher(Twist, "/cmd_vel", command_qos())
        ros.start()

        def drive() -> None:
            begin_s = time.monotonic()
            wait_until(lambda: ros.node.count_subscribers("/cmd_vel") > 0, "discovery")

            def drives() -> bool:
                publish(twist_to_msg(FORWARD))
                time.sleep(0.05)
                speed_mps = robot.simulation.true_twist.vx_mps
                return robot.simulation.driven_s > begin_s and speed_mps > 0.9 * FORWARD.vx_mps

            wait_until(drives, "turning wheels")

        yield drive


@pytest.fixture
def node(robot: ArduinoSim, tmp_path: Path) -> Iterator[Managed]:
    with running(ARDUINO, "--port", str(tmp_path / "arduino"), folder=tmp_path) as node:
        yield node


def motors_off_after(robot: ArduinoSim, lost_s: float, what: str) -> float:
    wait_until(lambda: robot.simulation.now_s - robot.simulation.driven_s > 0.5, "motors off")
    off_s = robot.simulation.driven_s - lost_s
    print(f"{what}: motors off after {1e3 * off_s:.0f} ms")
    return off_s


def test_an_arduino_node_that_is_killed(robot: ArduinoSim, node: Managed, drive: Callable[[], None]) -> None:
    drive()
    node.process.send_signal(signal.SIGKILL)
    off_s = motors_off_after(robot, time.monotonic(), "arduino node killed")
    assert off_s < 0.25 + ROOM_S


def test_whoever_drives_falls_silent(robot: ArduinoSim, node: Managed, drive: Callable[[], None]) -> None:
    drive()
    off_s = motors_off_after(robot, time.monotonic(), "no /cmd_vel any more")
    assert off_s < 0.3 + ROOM_S
    wait_until(lambda: "no /cmd_vel for 0.2 s: zero velocity" in node.log(), "the node's word")


def test_a_cable_that_is_pulled_and_put_back(
    robot: ArduinoSim, node: Managed, drive: Callable[[], None]
) -> None:
    drive()
    robot.unplug()
    off_s = motors_off_after(robot, time.monotonic(), "cable pulled")
    assert off_s < 0.25 + ROOM_S
    wait_until(lambda: "trying to open it again" in node.log(), "the loss to be reported")
    robot.plug_in()
    plugged_s = time.monotonic()
    wait_until(lambda: node.log().count("protocol 1") == 2, "the firmware's word over the new connection")
    print(f"back {time.monotonic() - plugged_s:.2f} s after it was plugged in")
    # Nothing old is driven late: it stands until somebody asks anew.
    time.sleep(0.3)
    assert robot.simulation.driven_s < plugged_s
    drive()


def test_a_nav_process_that_is_killed(tmp_path: Path) -> None:
    ros_environment()
    mission, truth_path = tmp_path / "mission.xml", tmp_path / "truth.json"
    mission.write_text(TURNING, encoding="utf-8")
    link = str(tmp_path / "arduino")
    sim = ("--arena", "open_floor", "--prefix", PREFIX, "--serial-link", link, "--truth", str(truth_path))
    nav = ("--mission", str(mission), "--prefix", PREFIX, "--go")

    def truth(key: str) -> float:
        return float(json.loads(truth_path.read_text())[key])

    try:
        with (
            running("target_nav.app.sim_node", *sim, folder=tmp_path),
            running(ARDUINO, "--port", link, folder=tmp_path),
            running("target_nav.app.odometry_node", folder=tmp_path),
            running("target_nav.app.tree_executor", *nav, folder=tmp_path) as executor,
        ):
            begin_s = time.monotonic()
            wait_until(lambda: truth_path.exists() and truth("driven_s") > begin_s + 1.0, "a turning robot")
            executor.process.send_signal(signal.SIGKILL)
            killed_s = time.monotonic()
            # The truth is written once a second.
            wait_until(lambda: truth("now_s") > truth("driven_s") + 1.0, "motors off")
            off_s = truth("driven_s") - killed_s
            print(f"nav process killed: motors off after {1e3 * off_s:.0f} ms")
            assert off_s < 0.3 + ROOM_S
    finally:
        for path in Path("/dev/shm").glob(f"{PREFIX}_*"):
            path.unlink()
